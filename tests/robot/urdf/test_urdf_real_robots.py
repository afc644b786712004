"""Real robots: each loads as another reader reads it, or is refused for a defect that it has."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.example_robots import all_paths
from helpers.sampled import sampled

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.description import link_shapes, load_description

yourdfpy = pytest.importorskip("yourdfpy")

REFUSED = {
    "alex_psyonic_hands.urdf": (1037, "joint 'Left_index_q2' mimics joint 'index_q1', which does not exist"),
    "ur3.urdf": (6, "<robot> has no attribute 'name'"),  # an empty <robot>
}


ROBOTS = all_paths()
LOADED = [path for path in ROBOTS if path.name not in REFUSED][::4]


@pytest.mark.parametrize("path", [path for path in ROBOTS if path.name in REFUSED], ids=lambda path: path.name)
def test_refused_for_a_real_defect(path: Path) -> None:
    line, what = REFUSED[path.name]
    assert len(ROBOTS) >= 65
    with pytest.raises(DescriptionError) as caught:
        load_description(path)
    assert (caught.value.line, caught.value.what) == (line, what)


@pytest.mark.parametrize("path", sampled(LOADED, 4), ids=lambda path: path.name)
def test_agrees_with_yourdfpy(path: Path) -> None:
    robot = load_description(path)
    other = yourdfpy.URDF.load(str(path), build_scene_graph=False, load_meshes=False).robot
    assert (robot.name, [link.name for link in robot.links]) == (other.name, [link.name for link in other.links])
    share = next((folder for folder in path.parents if folder.name == "share"), path.parent)
    for link, theirs in zip(robot.links, other.links, strict=True):
        shapes = [*link_shapes(robot, link.name, "visual"), *link_shapes(robot, link.name, "collision")]
        for shape, their in zip(shapes, [*theirs.visuals, *theirs.collisions], strict=True):
            assert np.array_equal(
                shape.geometry.origin.xyz, np.zeros(3) if their.origin is None else their.origin[:3, 3]
            )
            if their.geometry.mesh is None:
                assert shape.path is None
                continue
            name = their.geometry.mesh.filename
            file = share / name.removeprefix("package://") if "://" in name else path.parent / name
            assert shape.path.samefile(file) if file.exists() else shape.missing
            scale = 1.0 if their.geometry.mesh.scale is None else their.geometry.mesh.scale
            assert np.array_equal(shape.geometry.scale, np.broadcast_to(scale, 3))
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
        if mate.dynamics is not None:
            assert joint.damping == float(mate.dynamics.damping or 0.0)
            assert joint.friction == float(mate.dynamics.friction or 0.0)
        assert (joint.mimic and joint.mimic.joint) == (mate.mimic and mate.mimic.joint)
