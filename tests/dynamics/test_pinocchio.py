"""Every robot of example-robot-data against Pinocchio, at random states, with a fixed base and with a free one."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.example_robots import PATHS, REFUSED, all_paths, cases, path_of
from helpers.oracles import frictionless, random_state, run, worst
from helpers.pinocchio_robots import PinocchioRobot
from helpers.sampled import sampled

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.mass import mass_matrix
from robodyn.dynamics.plan import Plan
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
