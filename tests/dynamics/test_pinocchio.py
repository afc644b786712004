"""Every robot of example-robot-data against Pinocchio, at random states, with a fixed base and with a free one."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.example_robots import PATHS, REFUSED, VARIANTS, all_paths, cases, path_of
from helpers.factorised import forward_by_factorisation
from helpers.oracles import frictionless, random_state, run, worst
from helpers.peers import pin
from helpers.pinocchio_robots import PinocchioRobot
from helpers.sampled import sampled

from robodyn.dynamics.forward import forward_dynamics
from robodyn.dynamics.inverse import bias_forces, inverse_dynamics
from robodyn.dynamics.mass import mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.robot.load import load

SAMPLES = 6
TOLERANCE = 1e-12


def test_there_are_as_many_as_expected():
    assert len(PATHS) >= 65
    assert {path.name for path in all_paths()} - {path.name for path in PATHS} == set(REFUSED)


@pytest.fixture(scope="module", params=sampled(cases(), 3))
def path(request):
    return request.param


def _pair(path, moving_base):
    model = load(path, moving_base=moving_base)
    rng = np.random.default_rng(len(path.name))
    return model, PinocchioRobot(path, free=moving_base), random_state(model, rng, SAMPLES)


@pytest.mark.parametrize("moving_base", [False, True], ids=["fixed", "free"])
def test_torques(path, moving_base):
    model, other, (q, qd, qdd) = _pair(path, moving_base)
    tau = inverse_dynamics(model, q, qd, qdd, scene=frictionless(model))
    assert worst(tau, other.torques(model, q, qd, qdd)) <= TOLERANCE


def test_mass_matrix(path):
    model, other, (q, _, _) = _pair(path, True)
    assert worst(mass_matrix(model, q[:2]), other.mass_matrices(model, q[:2])) <= TOLERANCE


@pytest.mark.parametrize("name", ["ur5_robot", "panda", "anymal", "talos_reduced"])
def test_wrenches_of_every_joint(name):
    path = path_of(name)
    model, other, (q, qd, qdd) = _pair(path, True)
    plan = Plan(model, frictionless(model))
    found = run(plan.wrenches(joints=True), plan, q, qd, qdd)[:, model.n :].reshape(SAMPLES, -1, 6)
    expected = other.wrenches(model, q, qd, qdd)
    assert found.shape[1] == len(model.bodies)
    assert worst(found[..., :3], expected[..., :3]) <= TOLERANCE
    assert worst(found[..., 3:], expected[..., 3:]) <= TOLERANCE


STATES = 4
OF_ACCELERATIONS = 1e-10
MASSLESS = {"romeo": "RHand", "romeo_laas_small": "r_gripper_joint"}
"""Robots with a joint that moves links without mass, and its name."""


def _expected(other, model, q, qd, tau):
    """Pinocchio's accelerations; where joints mimic others, which `aba` cannot, from its M and bias."""
    S, (position, v, drift) = other.reduction(model, q), other.state(model, q, qd, np.zeros(model.n))
    if len(S) == model.n:
        a = pin.aba(other.model, other.data, position, v, np.linalg.solve(S.T, tau))
        return np.linalg.solve(S, a - drift)
    state = (x[None] for x in (q, qd, np.zeros(model.n)))
    return np.linalg.solve(other.mass_matrices(model, q[None])[0], tau - other.torques(model, *state)[0])


@pytest.mark.parametrize("moving_base", [False, True], ids=["fixed", "free"])
@pytest.mark.parametrize("path", sampled(cases({*MASSLESS, *VARIANTS})))
def test_accelerations(path, moving_base):
    model = load(path, moving_base=moving_base)
    scene = frictionless(model)
    q, qd, tau = random_state(model, np.random.default_rng(len(path.name)), STATES)
    qdd = forward_dynamics(model, q, qd, tau, scene=scene, executor="numpy")
    if not model.n:
        assert qdd.shape == (STATES, 0)
        return
    other = PinocchioRobot(path, free=moving_base)
    expected = np.array([_expected(other, model, *row) for row in zip(q, qd, tau, strict=True)])
    assert worst(qdd, expected) <= OF_ACCELERATIONS
    assert worst(qdd, forward_by_factorisation(model, q, qd, tau, scene=scene)) <= OF_ACCELERATIONS
    M, bias = mass_matrix(model, q), bias_forces(model, q, qd, scene=scene)
    called_for = (np.abs(M) @ np.abs(qdd)[..., None])[..., 0] + np.abs(bias) + np.abs(tau)
    off = np.abs(inverse_dynamics(model, q, qd, qdd, scene=scene) - tau)
    assert (off.max(axis=1) <= 1e-14 * called_for.max(axis=1)).all()


@pytest.mark.parametrize("name", sampled(MASSLESS))
@pytest.mark.parametrize("moving_base", [False, True], ids=["fixed", "free"])
def test_joints_that_nothing_resists_are_named(name, moving_base):
    """Their rows of M are zero."""
    model = load(next(path for path in PATHS if path.stem == name), moving_base=moving_base)
    q, qd, tau = random_state(model, np.random.default_rng(1), 1)
    with pytest.raises(InputError, match=f'joint "{MASSLESS[name]}" moves nothing that has inertia'):
        forward_dynamics(model, q, qd, tau)
    assert not mass_matrix(model, q)[0, model.rates.index(MASSLESS[name])].any()


def test_base_wrench_of_a_fixed_base():
    path = path_of("talos_reduced")
    model, _, (q, qd, qdd) = _pair(path, False)
    plan = Plan(model, frictionless(model))
    base = run(plan.wrenches(), plan, q, qd, qdd)[:, model.n :]
    free = load(path, moving_base=True)
    still = np.zeros((SAMPLES, 6))
    pose = np.tile([0.0, 0, 0, 0, 0, 0, 1], (SAMPLES, 1))
    state = np.hstack((pose, q)), np.hstack((still, qd)), np.hstack((still, qdd))
    tau = PinocchioRobot(path, free=True).torques(free, *state)
    assert worst(base, tau[:, [3, 4, 5, 0, 1, 2]]) <= TOLERANCE
