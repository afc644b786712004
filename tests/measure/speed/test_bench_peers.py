"""Other libraries compute the torques that robodyn computes, and say so where they cannot."""

from __future__ import annotations

import sys
from xml.etree import ElementTree

import numpy as np
import pytest
from helpers.example_robots import real
from helpers.oracles import robot
from helpers.peers import needs_peers
from helpers.small_robots import joint, link, urdf

from robodyn.dynamics.plan import plan
from robodyn.measure.speed.executors import random_sources
from robodyn.measure.speed.libraries import LIBRARIES, Task
from robodyn.measure.speed.peers import bare_description, bare_scene, compared, following
from robodyn.robot.load import load

SAMPLES = 20
GRAVITY = (1.0, -2.0, 3.0)
ALL = ["Pinocchio", "Pinocchio", "MuJoCo", "Drake"]


def peers_of(model):
    told = []
    sources = random_sources(model, bare_scene(model), SAMPLES)
    found = compared(model, GRAVITY, sources, SAMPLES, told.append)
    assert told[:-1] == list(LIBRARIES)
    return found


@needs_peers
@pytest.mark.parametrize("model", [robot("scara"), robot("gripper"), real("panda"), real("kinova"), real("solo12")])
def test_torques_agree(model):
    """With friction, transmissions and mimic joints in the description, and continuous ones, which Pinocchio turns."""
    found = peers_of(model)
    assert [peer.name.split()[0].strip(",") for peer in found.peers] == ALL
    assert all(peer.problem is None and peer.difference <= 5e-15 and peer.samples == SAMPLES for peer in found.peers)
    assert found.operations == plan(model, bare_scene(model, GRAVITY)).torques().size


@needs_peers
def test_a_link_named_world_is_the_world():
    model = real("ur5_robot")
    assert model.bodies[0].name == "world"
    assert max(peer.difference for peer in peers_of(model).peers) <= 5e-15


def test_only_gravity_inertia_and_coriolis_are_on():
    for model in (robot("gripper"), robot("puma560"), real("panda")):
        on = {effect.name for effect in plan(model, bare_scene(model)).effects}
        assert on - {"mimic"} == {"gravity", "inertia", "coriolis"}


def test_what_mimics_follows_and_is_reflected():
    model = robot("gripper")
    S, offset = following(model)
    mimicking = [body.joint for body in model.bodies[1:] if body.joint.mimics]
    assert S.shape == (model.n + len(mimicking), model.n)
    for k, body in enumerate(model.bodies[1:]):
        assert S[k].sum() == S[k, body.joint.rate] == body.joint.multiplier
        assert offset[k] == body.joint.offset


def test_other_libraries_see_links_and_joints_alone():
    root = ElementTree.fromstring(bare_description(robot("gripper")))
    assert {part.tag for part in root} == {"link", "joint"}
    assert {detail.tag for part in root for detail in part} <= {
        *("inertial", "origin", "parent", "child", "axis", "limit"),
    }


def test_a_library_that_is_not_there(monkeypatch):
    for name in ("pinocchio", "mujoco", "pydrake.multibody.parsing"):
        monkeypatch.setitem(sys.modules, name, None)
    found = peers_of(robot("scara"))
    assert {peer.name: peer.problem for peer in found.peers} == {
        "Pinocchio": "is not installed (pip install pin)",
        "MuJoCo": "is not installed (pip install mujoco)",
        "Drake": "is not installed (pip install drake)",
    }
    assert all(peer.time is None and peer.difference is None and peer.samples is None for peer in found.peers)
    assert found.ours.least > 0.0


@needs_peers
def test_a_library_that_refuses_the_robot_is_told_from_the_others():
    """MuJoCo does not move links without mass."""
    found = {peer.name.split()[0].strip(","): peer for peer in peers_of(real("romeo")).peers}
    assert found["MuJoCo"].problem.startswith("does not take part: Error: mass and inertia of moving bodies must be ")
    assert len(found["MuJoCo"].problem) < 200
    assert "\n" not in found["MuJoCo"].problem
    assert found["Pinocchio"].difference <= 5e-15
    assert found["Drake"].difference <= 5e-15


def test_floating_joints_are_not_compared():
    found = peers_of(robot("rigid_body", True))
    assert {peer.problem for peer in found.peers} == {
        "does not take part: a joint floats, whose rates each library defines in its own way"
    }


@needs_peers
def test_joints_that_a_library_does_not_know(tmp_path):
    """A planar joint is three here, one to the others."""
    file = tmp_path / "puck.urdf"
    puck = link("puck", 1.0, inertia=(1, 0, 0, 1, 0, 1))
    file.write_bytes(urdf(link("base"), puck, joint("slide", "base", "puck", kind="planar")))
    model = load(file)
    assert model.joint_names == ("slide_x", "slide_y", "slide_theta")
    problems = {peer.name: peer.problem for peer in peers_of(model).peers}
    assert problems["Pinocchio"] == "does not take part: it does not know the joint slide_x"
    assert all(problem.startswith("does not take part: ") for problem in problems.values())


def test_torques_that_are_not_finite(monkeypatch):
    monkeypatch.setitem(LIBRARIES, "Drake", ("drake", _broken))
    found = peers_of(robot("scara")).peers
    assert [peer.problem for peer in found if peer.name == "a broken one"] == [
        "does not take part: its torques are not finite"
    ]


def _broken(urdf, gravity, states):
    yield Task("a broken one", 2, lambda: None, lambda: np.full((2, len(states.names)), np.nan))
