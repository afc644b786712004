"""The Model: planar and floating joints in elementary ones, places in q, names, frames, size."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from helpers.busy_robot import busy_robot
from helpers.oracles import EPS, robot, worst
from helpers.peers import pin
from helpers.pinocchio_robots import PinocchioRobot
from helpers.small_robots import body_numbers, built, chain_parts, joint, link, urdf

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.errors import DescriptionError
from robodyn.robot.kinematics import motions, poses
from robodyn.robot.load import load


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (0, 1, 0), (0.48, 0.6, -0.64), (0, 0, -1)])
def test_planar_joint(axis):
    """Two slides across the normal and a hinge about it, in a right-handed frame; massless bodies between."""
    rng = np.random.default_rng(1)
    model = built(link("base"), link("puck", *body_numbers(rng)), joint("p", "base", "puck", "planar", axis))
    assert model.rates == model.coordinates == ("p_x", "p_y", "p_theta")
    first, second, normal = (body.joint.axis for body in model.bodies[1:])
    assert worst(np.cross(first, second), normal) <= 2 * EPS
    assert worst([normal @ first, normal @ second, first @ second], [0, 0, 0], 1.0) <= 2 * EPS
    assert worst(normal, np.array(axis, dtype=float)) <= 2 * EPS
    at = poses(model.parents, motions(model, [0.3, -0.7, 0.5], [0] * 3, [0] * 3))[-1]
    assert worst(at.p, 0.3 * first - 0.7 * second) <= 2 * EPS
    assert worst(at.R @ normal, normal) <= 2 * EPS
    assert [body.inertia.m for body in model.bodies[:3]] == [0, 0, 0]
    assert model.independent[2].continuous


@pytest.mark.parametrize("names", [("p", "p_y"), ("p_y", "p")])
def test_a_joint_named_as_a_part_of_a_planar_one(names):
    """Names are looked up: the order of q was p_x, p_theta, p_y."""
    kinds = ["planar" if name == "p" else "revolute" for name in names]
    parts = [link("base"), *(link(name, *body_numbers(np.random.default_rng(1))) for name in ("a", "b"))]
    parts += [joint(names[0], "base", "a", kinds[0], (0, 0, 1)), joint(names[1], "a", "b", kinds[1], (0, 0, 1))]
    with pytest.raises(DescriptionError, match='joint "p_y" is named as a part of planar joint "p"'):
        built(*parts)


def test_planar_joint_about_z_against_pinocchio():
    """Pinocchio's planar joint has its velocity in the body's axes: here a turn of zero compares them."""
    rng = np.random.default_rng(2)
    text = urdf(link("base"), link("puck", *body_numbers(rng)), joint("p", "base", "puck", "planar", (0, 0, 1)))
    model, other = load(text), PinocchioRobot(text)
    qd, qdd = rng.normal(size=(2, 3))
    vx, vy, w = qd
    # At theta = 0 the body's axes are the ground's, and turn under the velocity: a_body = a - w x v.
    a = np.array([qdd[0] + w * vy, qdd[1] - w * vx, qdd[2]])
    expected = pin.rnea(other.model, other.data, np.array([0.3, -0.7, 1, 0]), qd, a)
    assert worst(inverse_dynamics(model, [0.3, -0.7, 0], qd, qdd), expected) <= 1e-14


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_friction_that_is_not_used_is_noted(kind):
    more = '<dynamics damping="3" friction="2"/>'
    model = built(link("base", 1), link("puck", 1), joint("p", "base", "puck", kind, more=more))
    assert model.notes == (f'joint "p" (line 5): a {kind} joint has no friction here',)
    assert not built(link("base", 1), link("puck", 1), joint("p", "base", "puck", kind)).notes


def test_names_and_places():
    fixed, free = busy_robot(), busy_robot(True)
    assert fixed.joint_names == ("j1", "j2", "slide", "j4", "finger")
    assert fixed.rates == fixed.coordinates == fixed.joint_names
    assert (fixed.nq, fixed.n, free.nq, free.n) == (5, 5, 12, 11)
    assert free.coordinates[:7] == tuple(f"base_{part}" for part in ("x", "y", "z", "qx", "qy", "qz", "qw"))
    assert free.rates[6:] == fixed.rates
    assert sorted(fixed.tips_first) == list(range(5))
    assert [joint.coordinate for joint in free.independent] == [0, 7, 8, 9, 10, 11]
    assert (fixed.floating, free.floating) == (False, True)


def test_total_mass_and_merged_links():
    model = busy_robot()
    assert "tool" not in [body.name for body in model.bodies]
    assert model.links["tool"].body == model.links["l3"].body
    assert set(model.links) == {*(f"l{i}" for i in range(7)), "tool"}
    links = [link("a", 1.5), link("b", 2), link("c", 3)]
    single = built(*links, joint("f", "a", "b", "fixed"), joint("j", "b", "c"))
    assert single.total_mass == 6.5
    assert [body.name for body in single.bodies] == ["a", "c"]


def test_a_robot_without_joints():
    model = robot("composite")
    assert (model.n, model.nq, len(model.bodies)) == (0, 0, 1)
    assert inverse_dynamics(model, np.empty((4, 0)), np.empty((4, 0)), np.empty((4, 0))).shape == (4, 0)


def test_a_massless_root_with_one_floating_joint_is_the_ground():
    parts = [link("world"), link("ship", 2, (0.1, 0, 0), (1, 0, 0, 1, 0, 1)), link("arm", 1)]
    parts += [joint("float", "world", "ship", "floating"), joint("j", "ship", "arm")]
    model = load(urdf(*parts))
    assert model.floating
    assert model.rates[0] == "base_wx"
    with_mass = load(urdf(link("world", 1), *parts[1:]))
    assert not with_mass.floating
    assert with_mass.rates[0] == "float_wx"


def test_a_floating_joint_cannot_be_mimicked():
    parts = [link("base", 1), link("ship", 1), link("arm", 1), joint("float", "base", "ship", "floating")]
    parts.append(joint("j", "ship", "arm", more='<mimic joint="float"/>'))
    with pytest.raises(DescriptionError, match='joint "j" mimics joint "float", which has no single coordinate'):
        load(urdf(*parts))


def test_right_angles_are_exact():
    """Folding needs exact zeros: an angle written as 1.5707963267948966 gives a permutation of axes."""
    model = robot("puma560")
    for body in model.bodies:
        assert set(np.abs(body.joint.R).ravel()) <= {0.0, 1.0}


@pytest.mark.slow
def test_ten_thousand_links():
    """Neither recursion nor quadratic time: counted by the calls that Python makes."""
    assert sys.getrecursionlimit() < 10_000
    calls = [_calls(n) for n in (1_000, 2_000)]
    assert calls[1] < 2.1 * calls[0]
    model = load(urdf(*chain_parts(10_000)))
    assert model.n == 10_000
    assert model.parents[-1] == 9_999
    assert model.tips_first[0] == 9_999
    assert model.total_mass == 10_000


def _calls(n):
    count = 0

    def tick(frame, event, arg):
        nonlocal count
        count += event == "call"

    text = urdf(*chain_parts(n))
    sys.setprofile(tick)
    try:
        load(text)
    finally:
        sys.setprofile(None)
    return count


@pytest.mark.slow
def test_ten_thousand_fixed_links_are_one_body():
    parts = [link("l0", 1)]
    for i in range(1, 10_001):
        parts.append(link(f"l{i}", 0.5, (0, 0, 0)))
        parts.append(joint(f"j{i}", f"l{i - 1}", f"l{i}", "fixed", xyz=(0.25, 0, 0)))
    model = load(urdf(*parts))
    assert len(model.bodies) == 1
    assert model.total_mass == 5001
    expected = 0.5 * 0.25 * np.arange(10_001).sum() / 5001
    assert worst(model.bodies[0].inertia.centre_of_mass, [expected, 0, 0]) <= 1e-13
