"""Robots against Pinocchio and against closed forms, at random states, with a fixed base and with a free one."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.example_robots import KINDS, REFUSED, all_paths, cases, kinds, path_of
from helpers.oracles import frictionless, random_state, run, worst
from helpers.peers import pin
from helpers.pinocchio_robots import PinocchioRobot

import robodyn
from robodyn.dynamics.forward import forward_dynamics
from robodyn.dynamics.inverse import bias_forces, inverse_dynamics, mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.robot.load import load

SAMPLES = 4
TOLERANCE = 1e-12
OF_ACCELERATIONS = 1e-10
MASSLESS = {"romeo": "RHand", "romeo_laas_small": "r_gripper_joint"}
"""Robots with a joint that moves links without mass, and its name."""
bases = pytest.mark.parametrize("free", [False, True], ids=["fixed", "free"])


def _pair(path, free):
    model = load(path, moving_base=free)
    rng = np.random.default_rng(len(path.name))
    return model, PinocchioRobot(path, free=free), random_state(model, rng, SAMPLES)


@pytest.mark.slow
@bases
def test_torques_of_all(free):
    paths = [case.values[0] for case in cases()]
    assert len(paths) == len(all_paths()) - len(REFUSED) >= 65
    for path in paths:
        model, other, state = _pair(path, free)
        tau = inverse_dynamics(model, *state, scene=frictionless(model), executor="numpy")
        assert worst(tau, other.torques(model, *state)) <= TOLERANCE, path


@bases
@pytest.mark.parametrize("path", kinds())
def test_torques_masses_and_places(path, free):
    model, other, (q, qd, qdd) = _pair(path, free)
    tau = inverse_dynamics(model, q, qd, qdd, scene=frictionless(model))
    assert worst(tau, other.torques(model, q, qd, qdd)) <= TOLERANCE
    assert worst(mass_matrix(model, q), other.mass_matrices(model, q)) <= TOLERANCE
    name = model.bodies[-1].name
    pin.framesForwardKinematics(other.model, other.data, other.state(model, q[0], qd[0], qdd[0])[0])
    frame, found = other.data.oMf[other.model.getFrameId(name)], robodyn.forward_kinematics(model, q[0], name)
    assert max(worst(found.R, frame.rotation), worst(found.p, frame.translation)) <= TOLERANCE


@pytest.mark.parametrize("name", KINDS)
def test_wrenches_of_every_joint(name):
    model, other, state = _pair(path_of(name), True)
    plan = Plan(model, frictionless(model))
    found = run(plan.wrenches(joints=True), plan, *state)[:, model.n :].reshape(SAMPLES, -1, 6)
    expected = other.wrenches(model, *state)
    assert found.shape[1] == len(model.bodies)
    assert worst(found[..., :3], expected[..., :3]) <= TOLERANCE
    assert worst(found[..., 3:], expected[..., 3:]) <= TOLERANCE


def _expected(other, model, q, qd, tau):
    """Pinocchio's accelerations; where joints mimic others, which `aba` cannot, from its M and bias."""
    S, (position, v, drift) = other.reduction(model, q), other.state(model, q, qd, np.zeros(model.n))
    if len(S) == model.n:
        a = pin.aba(other.model, other.data, position, v, np.linalg.solve(S.T, tau))
        return np.linalg.solve(S, a - drift)
    state = (x[None] for x in (q, qd, np.zeros(model.n)))
    return np.linalg.solve(other.mass_matrices(model, q[None])[0], tau - other.torques(model, *state)[0])


@bases
@pytest.mark.parametrize("path", kinds())
def test_accelerations(path, free):
    model, other, (q, qd, tau) = _pair(path, free)
    scene = frictionless(model)
    qdd = forward_dynamics(model, q, qd, tau, scene=scene, executor="numpy")
    expected = np.array([_expected(other, model, *row) for row in zip(q, qd, tau, strict=True)])
    assert worst(qdd, expected) <= OF_ACCELERATIONS
    M, bias = mass_matrix(model, q), bias_forces(model, q, qd, scene=scene)
    called_for = (np.abs(M) @ np.abs(qdd)[..., None])[..., 0] + np.abs(bias) + np.abs(tau)
    off = np.abs(inverse_dynamics(model, q, qd, qdd, scene=scene) - tau)
    assert (off.max(axis=1) <= 1e-14 * called_for.max(axis=1)).all()


@pytest.mark.parametrize(
    ("name", "free"),
    [("romeo", False), *(pytest.param(name, True, marks=pytest.mark.slow) for name in MASSLESS)],
)
def test_joints_that_nothing_resists_are_named(name, free):
    """Their rows of M are zero."""
    model = load(path_of(name), moving_base=free)
    q, qd, tau = random_state(model, np.random.default_rng(1), 1)
    with pytest.raises(InputError, match=f'joint "{MASSLESS[name]}" moves nothing that has inertia'):
        forward_dynamics(model, q, qd, tau)
    assert not mass_matrix(model, q)[0, model.rates.index(MASSLESS[name])].any()
