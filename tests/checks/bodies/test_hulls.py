"""The depth to which convex hulls reach into each other, against closed forms; and the pairs that are looked at."""

from __future__ import annotations

import re

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.sampled import sampled

from robodyn.checks.bodies.contacts import Hull, depth, overlaps, rest
from robodyn.checks.catalogue import BY_CODE
from robodyn.checks.context import Context
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.kinematics import Pose
from robodyn.robot.urdf.document import read_document

CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


def hull(kind, half, at=(0.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.0)):
    half = np.array(half, float)
    pose = Pose(rotation_from_rpy(*rpy).astype(float), np.array(at, float))
    points = CORNERS * half if kind == "mesh" else None
    return Hull(kind, half, points, pose)


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        (hull("sphere", (0.2,) * 3), hull("sphere", (0.3,) * 3, (0.3, 0.2, 0.1)), 0.5 - 0.14**0.5),
        (hull("box", (0.1, 0.2, 0.3)), hull("box", (0.1, 0.2, 0.3), (0.15, 0.0, 0.1)), 0.05),
        (hull("mesh", (0.1, 0.2, 0.3)), hull("box", (0.1, 0.2, 0.3), (0.15, 0.0, 0.1)), 0.05),
        (hull("box", (0.5, 0.5, 0.5)), hull("capsule", (0.1, 0.1, 0.4), (0.0, 0.0, 0.8)), 0.1),
        (hull("box", (0.5, 0.5, 0.5)), hull("cylinder", (0.1, 0.1, 0.4), (0.0, 0.55, 0.0)), 0.05),
        (hull("box", (0.5, 0.5, 0.5)), hull("cylinder", (0.1, 0.1, 0.4), (0.0, 0.85, 0.0), (np.pi / 2, 0, 0)), 0.05),
        (hull("sphere", (0.2,) * 3), hull("box", (0.1, 0.1, 0.1), (0.28, 0.0, 0.0), (0.0, 0.0, 0.6)), None),
        (hull("sphere", (0.2,) * 3), hull("sphere", (0.3,) * 3, (0.5, 0.1, 0.0)), 0.0),
    ],
)
def test_depth(first, second, expected):
    found = depth(first, second, 0.0)
    assert found == pytest.approx(depth(second, first, 0.0), abs=2e-3), "a percent of the smaller body"
    if expected is None:
        assert 0 < found < 0.2
    else:
        assert expected - 1e-12 <= found <= expected * 1.01 + 1e-3


def test_a_depth_within_the_bound_is_none():
    first, second = hull("box", (0.1, 0.1, 0.1)), hull("box", (0.1, 0.1, 0.1), (0.15, 0.0, 0.0))
    assert depth(first, second, 0.06) == 0.0
    assert depth(first, second, 0.04) == pytest.approx(0.05)


def found(text, folder):
    file = folder / "arm.urdf"
    file.write_text(text, encoding="utf-8")
    return [(one.first.name, one.second.name) for one in overlaps(Context(read_document(file)))]


def test_neighbours_and_pairs_disabled_in_the_srdf_are_left_out(tmp_path):
    bad, good = BY_CODE["RD610"].bad, BY_CODE["RD610"].good
    assert found(bad, tmp_path) == [("fore", "tool")]
    assert found(good, tmp_path) == []
    assert found(good.replace('link="tool"/><origin xyz="0 0 0.1"', 'link="tool"/><origin xyz="0 0 0"'), tmp_path) == []
    srdf = '<robot name="arm"><disable_collisions link1="tool" link2="fore" reason="Never"/></robot>'
    (tmp_path / "arm.srdf").write_text(srdf, encoding="utf-8")
    assert found(bad, tmp_path) == []


@pytest.mark.parametrize("robot", sampled(["panda_collision", "centauro", "talos_reduced", "tiago_pro"], 2))
def test_depths_are_those_of_mujoco(robot):
    mujoco = pytest.importorskip("mujoco")
    path = path_of(robot)
    context = Context(read_document(path))
    text = path.read_text(encoding="utf-8").replace("package://example-robot-data", str(path.parents[3]))
    compiler = '<compiler strippath="false" fusestatic="false" balanceinertia="true" boundmass="1e-6"'
    more = f'<mujoco>{compiler} boundinertia="1e-9"/></mujoco>'
    text = re.sub(r"(<robot[^>]*>)", rf"\1{more}", text, count=1)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for joint in context.view.joints:
        k = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint.name)
        if k >= 0:
            data.qpos[model.jnt_qposadr[k]] = rest(joint)
    mujoco.mj_forward(model, data)
    deepest: dict[frozenset[str], float] = {}
    for contact in data.contact:
        names = frozenset(model.body(model.geom_bodyid[geom]).name for geom in contact.geom)
        deepest[names] = max(deepest.get(names, 0.0), -contact.dist)
    ours = {frozenset((one.first.name, one.second.name)): one.depth for one in overlaps(context)}
    assert ours
    assert ours == pytest.approx({pair: deepest[pair] for pair in ours}, rel=0, abs=2.5e-3)
