"""Real robots: each loads as another reader reads it, or is refused for a defect that it has."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from helpers.peers import pin
from helpers.sampled import sampled

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.description import load_description
from robodyn.robot.urdf.document import Element, read_document
from robodyn.robot.urdf.parts import Description

yourdfpy = pytest.importorskip("yourdfpy")

REFUSED = {
    "alex_psyonic_hands.urdf": (1037, "joint 'Left_index_q2' mimics joint 'index_q1', which does not exist"),
    "ur3.urdf": (6, "<robot> has no attribute 'name'"),  # an empty <robot>
}


def real_robots() -> list[Path]:
    files = importlib.metadata.files("example-robot-data") or []
    return sorted(Path(str(file.locate())) for file in files if file.suffix == ".urdf")


ROBOTS = real_robots()
LOADED = [path for path in ROBOTS if path.name not in REFUSED]
EPS = np.finfo(float).eps


def test_there_are_as_many_as_expected() -> None:
    assert len(ROBOTS) >= 65
    assert {path.name for path in ROBOTS} >= set(REFUSED)


@pytest.mark.parametrize("path", [path for path in ROBOTS if path.name in REFUSED], ids=lambda path: path.name)
def test_refused_for_a_real_defect(path: Path) -> None:
    line, what = REFUSED[path.name]
    with pytest.raises(DescriptionError) as caught:
        load_description(path)
    assert (caught.value.line, caught.value.what) == (line, what)


def local(name: str) -> str:
    """`p:x` and `{uri}x` are both x."""
    return name.rpartition(":")[2].rpartition("}")[2]


@pytest.mark.parametrize("path", sampled(LOADED, 4), ids=lambda path: path.name)
def test_the_document_has_every_element_of_elementtree(path: Path) -> None:
    def same(ours: Element, theirs: ElementTree.Element) -> None:
        assert local(ours.tag) == local(theirs.tag)
        written = [(name, attribute.value) for name, attribute in ours.attributes.items() if "xmlns" not in name]
        assert [(local(name), value) for name, value in written] == [(local(k), v) for k, v in theirs.attrib.items()]
        assert ours.text.strip() == "".join([theirs.text or "", *(child.tail or "" for child in theirs)]).strip()
        assert len(ours.children) == len(theirs)
        for child, other in zip(ours.children, theirs, strict=True):
            same(child, other)

    same(read_document(path).root, ElementTree.parse(path).getroot())


@pytest.mark.parametrize("path", LOADED, ids=lambda path: path.name)
def test_agrees_with_yourdfpy(path: Path) -> None:
    robot = load_description(path)
    other = yourdfpy.URDF.load(str(path), build_scene_graph=False, load_meshes=False).robot
    assert (robot.name, [link.name for link in robot.links]) == (other.name, [link.name for link in other.links])
    for link, theirs in zip(robot.links, other.links, strict=True):
        assert len(link.geometries) == len(theirs.visuals) + len(theirs.collisions)
        if link.inertial is None:
            assert theirs.inertial is None
            continue
        assert link.inertial.mass == theirs.inertial.mass
        ixx, ixy, ixz, iyy, iyz, izz = link.inertial.inertia
        assert np.array_equal([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]], theirs.inertial.inertia)
        if theirs.inertial.origin is not None:
            assert np.array_equal(link.inertial.origin.xyz, theirs.inertial.origin[:3, 3])
    assert len(robot.joints) == len(other.joints)
    for joint, mate in zip(robot.joints, other.joints, strict=True):
        assert (joint.name, joint.type, joint.parent, joint.child) == (mate.name, mate.type, mate.parent, mate.child)
        assert np.array_equal(joint.axis, mate.axis)
        assert np.array_equal(joint.origin.xyz, np.zeros(3) if mate.origin is None else mate.origin[:3, 3])
        if joint.limit is not None:
            for name in ("lower", "upper", "effort", "velocity"):
                assert getattr(joint.limit, name) == getattr(mate.limit, name)
        assert (joint.mimic and joint.mimic.joint) == (mate.mimic and mate.mimic.joint)


@pytest.mark.parametrize("path", LOADED, ids=lambda path: path.name)
def test_agrees_with_pinocchio(path: Path) -> None:
    robot = load_description(path)
    model = pin.buildModelFromUrdf(str(path))
    joints = {joint.name: joint for joint in robot.joints}
    moving = [joint for joint in robot.joints if joint.type != "fixed"]
    assert set(model.names[1:]) == {joint.name for joint in moving}
    total = sum(inertia.mass for inertia in model.inertias)
    assert abs(total - carried_mass(robot)) <= len(robot.links) * EPS * total
    for index in range(1, model.njoints):
        joint = joints[model.names[index]]
        velocity = model.joints[index].idx_v
        assert model.damping[velocity] == joint.damping
        assert model.upperDryFrictionLimit[velocity] == joint.friction
        if joint.limit is not None and joint.limit.effort is not None:
            assert model.upperEffortLimit[velocity] == joint.limit.effort
            assert model.upperVelocityLimit[velocity] == joint.limit.velocity
    for frame in model.frames:
        if frame.type in (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT) and frame.name in joints:
            origin = joints[frame.name].origin
            placement = pin.SE3(pin.rpy.rpyToMatrix(*origin.rpy), np.array(origin.xyz))
            error = np.abs(placement.homogeneous - above(model, frame).homogeneous).max()
            assert error <= 40 * EPS * max(1.0, *np.abs(placement.translation))


def above(model: Any, frame: Any) -> Any:
    """Placement of a joint frame in the frame of the link before it."""
    before = model.frames[frame.parentFrame]
    if before.parentJoint == frame.parentJoint:
        return before.placement.actInv(frame.placement)
    return before.placement.actInv(model.jointPlacements[frame.parentJoint])


def carried_mass(robot: Description) -> float:
    return sum(link.inertial.mass for link in robot.links if link.inertial is not None)
