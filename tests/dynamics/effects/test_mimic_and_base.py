"""Mimic joints against coordinates reduced by hand; moving bases against free flyers and fixed robots."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import busy_parts, busy_robot
from helpers.oracles import EPS, random_state, run, worst
from helpers.pinocchio_robots import PinocchioRobot
from helpers.small_robots import joint, link, random_tree, random_tree_parts, urdf

from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.programs.vectors import cross
from robodyn.robot.kinematics import motions, poses
from robodyn.robot.load import load
from robodyn.scene.scene import Scene

MIMIC = '<mimic joint="finger" multiplier="-2.5" offset="0.3"/>'


def _independent():
    return load(urdf(*(part.replace(MIMIC, "") for part in busy_parts())))


def test_mimic_is_the_reduction_by_hand():
    """q_full = S q + offset, so tau = S^T tau_full and M = S^T M_full S, friction of the follower included."""
    model, full = busy_robot(), _independent()
    q, qd, qdd = random_state(model, np.random.default_rng(17), 20)
    S = np.zeros((full.n, model.n))
    for k, name in enumerate(full.joint_names):
        S[k, model.joint_names.index("finger" if name == "follower" else name)] = -2.5 if name == "follower" else 1.0
    offset = np.array([0.3 if name == "follower" else 0.0 for name in full.joint_names])
    expected = inverse_dynamics(full, q @ S.T + offset, qd @ S.T, qdd @ S.T) @ S
    assert worst(inverse_dynamics(model, q, qd, qdd), expected) <= 8 * EPS
    assert worst(mass_matrix(model, q), S.T @ mass_matrix(full, q @ S.T + offset) @ S) <= 8 * EPS


def test_a_mimic_of_a_mimic():
    chained = [part.replace(MIMIC, '<mimic joint="j4" multiplier="2" offset="1"/>') for part in busy_parts()]
    chained = [
        part.replace('<dynamics damping="0.5" friction="0.6"/>', '<mimic joint="follower" multiplier="3" offset="-1"/>')
        for part in chained
    ]
    model = load(urdf(*chained))
    assert "finger" not in model.joint_names
    finger = next(body.joint for body in model.bodies if body.joint.name == "finger")
    assert (finger.mimics, finger.multiplier, finger.offset) == ("j4", 6.0, 2.0)


def test_a_tree_on_a_moving_base_against_pinocchio():
    """Whose bodies' axes are askew in their links, and who has links that are fixed to others."""
    parts = random_tree_parts(np.random.default_rng(0), 6)
    model = load(urdf(*parts), moving_base=True)
    state = random_state(model, np.random.default_rng(0), 10)
    assert (
        worst(inverse_dynamics(model, *state), PinocchioRobot(urdf(*parts), free=True).torques(model, *state)) <= 1e-14
    )


def test_a_base_at_rest_is_a_fixed_one():
    """Torques are the same, and the base's are the base wrench: the moment in its axes, the force in the ground's."""
    fixed, free = random_tree(31), random_tree(31, moving_base=True)
    state = random_state(free, np.random.default_rng(19), 10)
    state[0][:, :7] = [0, 0, 0, 0, 0, 0, 1]
    state[1][:, :6] = state[2][:, :6] = 0.0
    own = [state[0][:, 7:], state[1][:, 6:], state[2][:, 6:]]
    tau = inverse_dynamics(free, *state)
    plan = Plan(fixed, Scene())
    out = run(plan.wrenches(), plan, *own)
    np.testing.assert_array_equal(tau[:, 6:], inverse_dynamics(fixed, *own))
    np.testing.assert_array_equal(tau[:, 3:6], out[:, fixed.n : fixed.n + 3])
    np.testing.assert_array_equal(tau[:, :3], out[:, fixed.n + 3 :])


def test_length_of_the_quaternion_does_not_matter():
    model = random_tree(34, moving_base=True)
    q, qd, qdd = random_state(model, np.random.default_rng(22), 10)
    longer = q.copy()
    longer[:, 3:7] *= 4.0
    np.testing.assert_array_equal(inverse_dynamics(model, longer, qd, qdd), inverse_dynamics(model, q, qd, qdd))
    longer[:, 3:7] *= -0.3
    assert worst(inverse_dynamics(model, longer, qd, qdd), inverse_dynamics(model, q, qd, qdd)) <= 16 * EPS


def test_a_quaternion_of_zero_is_refused():
    model = random_tree(34, moving_base=True)
    with pytest.raises(InputError, match="the quaternion of base is zero"):
        inverse_dynamics(model, 0, 0, 0)
    q, qd, qdd = random_state(model, np.random.default_rng(22), 3)
    q[1, 3:7] = 0
    with pytest.raises(InputError, match="the quaternion of base is zero"):
        inverse_dynamics(model, q, qd, qdd)


def test_a_floating_joint_within_a_tree():
    """A body that floats off a fixed one is a free body, placed by its joint's origin."""
    parts = [link("base", 3), link("ship", 2, (0.1, 0.2, 0.3), (0.1, 0.01, 0.02, 0.2, 0.03, 0.25))]
    parts.append(joint("float", "base", "ship", "floating", xyz=(1, 2, 3), rpy=(0.4, 0.5, 0.6)))
    model = load(urdf(*parts))
    assert model.rates == tuple(f"float_{part}" for part in ("wx", "wy", "wz", "vx", "vy", "vz"))
    q, qd, qdd = random_state(model, np.random.default_rng(23), 10)
    tau = inverse_dynamics(model, q, qd, qdd)
    assert worst(tau, PinocchioRobot(urdf(*parts)).torques(model, q, qd, qdd)) <= 1e-14
    plan = Plan(model, Scene())
    base = run(plan.wrenches(), plan, q, qd, qdd)[:, model.n :]
    mount = model.bodies[1].joint.R
    assert worst(base[:, :3], tau[:, 3:] @ mount.T + [0, 0, 3 * 9.81]) <= 1e-14
    ship = poses(model.parents, motions(model, q[0], qd[0], qdd[0]))[1]
    moment = ship.R @ tau[0, :3] + cross(ship.p, mount @ tau[0, 3:])
    assert worst(base[0, 3:], moment) <= 1e-14
