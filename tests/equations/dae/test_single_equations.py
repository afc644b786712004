"""Single equations between bodies: rows are rates of values, drifts what rates of rows leave, and forces balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import busy_robot
from helpers.oracles import EPS, random_state, robot, worst
from helpers.single_bodies import in_motion, random_bodies
from helpers.small_robots import random_tree

from robodyn.equations.dae.system import (
    Anchors,
    Place,
    Sum,
    Turn,
    connect,
    drifts,
    joint_connections,
    stacked,
    state_of,
    system_at,
    values,
    velocities_of,
)
from robodyn.programs.derivative import rate_of, value_of
from robodyn.scene.scene import DEFAULT


def unit(rng):
    axis = rng.normal(size=3)
    return axis / np.linalg.norm(axis)


def every_kind(rng, body, other):
    point, to = rng.normal(size=(2, 3))
    along = Place(body, other, point, to, unit(rng), np.zeros((3, 3)))
    across = Place(body, other, point, to, np.zeros(3), np.outer(unit(rng), unit(rng)))
    both, turn = replace(across, n=unit(rng)), Turn(body, other, unit(rng), np.eye(3))
    return along, across, both, turn, Sum(((1.0, along), (-2.5, turn)), 0.3)


@pytest.mark.parametrize(("body", "other"), [(0, 1), (1, -1), (-1, 0)])
@pytest.mark.parametrize("seed", range(4))
def test_rows_and_drifts_are_derivatives(seed, body, other):
    rng = np.random.default_rng(seed)
    at, a = random_bodies(rng, 2), rng.normal(size=12)
    moving = in_motion(at, a)
    for equation in every_kind(rng, body, other):
        (row,) = stacked([equation], at)
        speed = row @ velocities_of(at)
        if isinstance(equation, Place):
            assert abs(rate_of(equation.value(moving)) - speed) <= 64 * EPS
        in_duals = stacked([equation], moving)[0] @ velocities_of(moving)
        assert abs(value_of(in_duals) - speed) <= 64 * EPS
        assert abs(rate_of(in_duals) - (row @ a + equation.drift(at))) <= 128 * EPS


@pytest.mark.parametrize("seed", range(3))
def test_what_acts_on_a_body_acts_oppositely_on_the_other(seed):
    """A multiplier's forces add up to zero, and its moments about any one point: action and reaction."""
    rng = np.random.default_rng(seed)
    at = random_bodies(rng, 2)
    for equation in every_kind(rng, 0, 1):
        (row,) = stacked([equation], at)
        forces, moments = np.zeros(3), np.zeros(3)
        for place, (moment, force) in zip(at, row.reshape(-1, 2, 3), strict=False):
            forces += force
            moments += place.R @ moment + np.cross(place.c, force)
        assert max(np.abs(forces).max(), np.abs(moments).max()) <= 64 * EPS


def test_mimic_joints_hold_with_their_offsets():
    model = busy_robot()
    (q,), (qd,), (tau,) = random_state(model, np.random.default_rng(0), 1)
    system = system_at(model, DEFAULT, q, qd, tau)
    rules = [equation for mimic in system.mimics for equation in mimic.equations]
    assert any(rule.constant for rule in rules)
    assert np.abs(values(rules, system.at)).max() <= 16 * EPS
    assert np.abs(stacked(rules, system.at) @ velocities_of(system.at)).max() <= 64 * EPS


def test_a_hinge_counts_turns():
    at = random_bodies(np.random.default_rng(0), 1)
    for angle in (-20.0, -3.0, 0.1, 3.2, 50.0):
        model = robot("two_link_planar")
        centres = [body.inertia.centre_of_mass for body in model.bodies]
        joints = joint_connections(model, centres, [angle, 2 * angle])
        at = state_of(model, centres, [angle, 2 * angle], [0.0, 0.0])
        assert worst(values([joint.free[0] for joint in joints[1:]], at), [angle, 2 * angle]) <= 16 * EPS


@pytest.mark.parametrize("moving_base", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_joints_leave_their_own_rates_and_hold_the_rest(seed, moving_base):
    model = random_tree(seed, 9, moving_base)
    (q,), (qd,), _ = random_state(model, np.random.default_rng(seed), 1)
    centres = [body.inertia.centre_of_mass for body in model.bodies]
    joints, at = joint_connections(model, centres, q), state_of(model, centres, q, qd)
    v = velocities_of(at)
    held = [equation for joint in joints for equation in joint.equations]
    size = np.abs(v).max()
    assert np.abs(values(held, at)).max() <= 64 * EPS
    assert np.abs(stacked(held, at) @ v).max() <= 128 * EPS * size
    for body, joint in zip(model.bodies, joints, strict=True):
        width = len(joint.free)
        assert width + len(joint.equations) == 6
        expected = qd[body.joint.rate : body.joint.rate + width]
        assert np.abs(stacked(joint.free, at) @ v - expected).max(initial=0.0) <= 128 * EPS * size
        if body.joint.kind == "revolute":
            assert np.abs(drifts(joint.free, at)).max() <= 64 * EPS * size**2


COUNTS = {"weld": 6, "hinge": 5, "prismatic": 5, "point": 3}


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, -1, 0), (1, 0, 0), (0.48, 0.6, -0.64)])
def test_connections_hold_six_less_their_freedom(axis):
    """Assembled with a relative turn, the rows are orthonormal forces at the point and moments about axes."""
    rng = np.random.default_rng(5)
    at, axis = random_bodies(rng, 2), np.array(axis, dtype=float)
    point_of, R = rng.normal(size=3), at[1].R.T @ at[0].R
    to = at[1].R.T @ (at[0].c + at[0].R @ point_of - at[1].c)
    anchors = Anchors(0, 1, point_of, to, R)
    made = [connect(kind, kind, anchors, axis if kind in ("hinge", "prismatic") else None) for kind in COUNTS]
    for connection in made:
        assert len(connection.equations) == len(set(connection.reactions)) == COUNTS[connection.kind]
        assert np.abs(values(connection.equations, at)).max() <= 16 * EPS
        rows = stacked(connection.equations, at)[:, :6]
        forces, moments = rows[:, 3:], rows[:, :3] - np.cross(point_of, rows[:, 3:] @ at[0].R)
        both = np.hstack((forces, moments))
        assert worst(both @ both.T, np.eye(len(both))) <= 32 * EPS
        freedom = np.hstack((moments @ axis * (connection.kind == "hinge"), 0.0))
        assert np.abs(freedom).max() <= 16 * EPS
    along = connect("e", "directions", anchors, along=[np.array((0, 3.0, 0)), np.array((0, 0, 0.1))])
    assert np.abs(np.linalg.norm(stacked(along.equations, at)[:, 3:6], axis=1) - 1.0).max() <= 8 * EPS


def test_a_moment_keeps_its_place_in_the_other_body_while_a_hinge_turns():
    """lambda of a hinge is along axes that do not turn with the body."""
    at = random_bodies(np.random.default_rng(7), 2)
    anchors = Anchors(0, 1, np.zeros(3), np.zeros(3), at[1].R.T @ at[0].R)
    axis = np.array((0.0, 0.0, 1.0))
    joint = connect("h", "hinge", anchors, axis)
    c, s = np.cos(0.7), np.sin(0.7)
    spun = at[0]._replace(R=at[0].R @ np.array(((c, -s, 0), (s, c, 0), (0, 0, 1.0))))
    later = (spun, *at[1:])
    moments = [stacked(joint.equations[3:], here)[:, 6:9] for here in (at, later)]
    assert worst(moments[0], moments[1]) <= 16 * EPS
    assert worst(moments[0], -(anchors.R @ np.eye(3)[:, :2]).T) <= 16 * EPS
