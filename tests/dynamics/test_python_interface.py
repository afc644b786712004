"""The Python interface: shapes, errors, M and b as parts of tau, payload and rotors in M."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.oracles import random_state, robot, run, worst

import robodyn
from robodyn.dynamics.effects import inertia, payload, rotor_inertia
from robodyn.dynamics.plan import Plan, plan
from robodyn.errors import InputError
from robodyn.scene.scene import Scene


@pytest.mark.parametrize("moving_base", [False, True])
def test_tau_is_mass_times_acceleration_plus_bias(moving_base):
    model = busy_robot(moving_base)
    rng = np.random.default_rng(1)
    q, qd, qdd = random_state(model, rng, 20)
    columns = {name: rng.normal(size=20) for name in BUSY_SCENE.columns}
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=BUSY_SCENE, columns=columns)
    bias = robodyn.bias_forces(model, q, qd, scene=BUSY_SCENE, columns=columns)
    M = robodyn.mass_matrix(model, q, scene=BUSY_SCENE)
    assert worst(np.einsum("ijk,ik->ij", M, qdd) + bias, tau) <= 1e-14
    np.testing.assert_array_equal(M, np.swapaxes(M, 1, 2))
    assert (np.linalg.eigvalsh(M) > 0).all()


def test_mass_matrix_is_the_share_of_inertia_payload_and_rotors():
    model = busy_robot()
    q = random_state(model, np.random.default_rng(2), 1)[0]
    a_plan = Plan(model, Scene((0.0, 0.0, 0.0), rotor=BUSY_SCENE.rotor, payloads=BUSY_SCENE.payloads))
    unit, still = np.eye(model.n), np.zeros((model.n, model.n))
    state = np.repeat(q, model.n, axis=0), still, unit
    effects = inertia.EFFECT, payload.EFFECT, rotor_inertia.EFFECT
    expected = sum(run(a_plan.share(effect), a_plan, *state) for effect in effects)
    assert worst(robodyn.mass_matrix(model, q[0], scene=BUSY_SCENE), expected) <= 1e-14


def test_shapes():
    model = robot("puma560")
    q = np.zeros((2, 3, 4, 6))
    assert robodyn.inverse_dynamics(model, q, 0, 0).shape == (2, 3, 4, 6)
    assert robodyn.inverse_dynamics(model, q[0, 0, 0], 0, 0).shape == (6,)
    assert robodyn.mass_matrix(model, q).shape == (2, 3, 4, 6, 6)
    assert robodyn.bias_forces(model, q[0], q).shape == (2, 3, 4, 6)
    assert robodyn.mass_matrix(model, q[:0]).shape == (0, 3, 4, 6, 6)


WRONG = {
    "q has 5 columns, the robot has 6": ([0] * 5, 0, 0),
    "qd has 7 columns, the robot has 6": (0, [0] * 7, 0),
    "qdd has 1 columns, the robot has 6": (0, 0, [0]),
    "the shapes do not go together": (np.zeros((2, 6)), np.zeros((3, 6)), 0),
}


@pytest.mark.parametrize("message", WRONG)
def test_wrong_shapes(message):
    with pytest.raises(InputError, match=message):
        robodyn.inverse_dynamics(robot("puma560"), *WRONG[message])


def test_plans_are_made_once():
    model, scene = robot("puma560"), Scene()
    assert plan(model, scene) is plan(model, scene)
    assert plan(model, scene) is plan(model, Scene())
    assert plan(model, scene) is not plan(robodyn.load(model.file), scene)
