"""Forward dynamics of the robots of example-robot-data against Pinocchio's `aba`, with a fixed base and a free one."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.example_robots import PATHS, VARIANTS, cases
from helpers.factorised import forward_by_factorisation
from helpers.oracles import frictionless, random_state, worst
from helpers.peers import pin
from helpers.pinocchio_robots import PinocchioRobot
from helpers.sampled import sampled

from robodyn.dynamics.forward import forward_dynamics
from robodyn.dynamics.inverse import bias_forces, inverse_dynamics
from robodyn.dynamics.mass import mass_matrix
from robodyn.errors import InputError
from robodyn.robot.load import load

SAMPLES = 4
TOLERANCE = 1e-10
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
    q, qd, tau = random_state(model, np.random.default_rng(len(path.name)), SAMPLES)
    qdd = forward_dynamics(model, q, qd, tau, scene=scene, executor="numpy")
    if not model.n:
        assert qdd.shape == (SAMPLES, 0)
        return
    other = PinocchioRobot(path, free=moving_base)
    expected = np.array([_expected(other, model, *row) for row in zip(q, qd, tau, strict=True)])
    assert worst(qdd, expected) <= TOLERANCE
    assert worst(qdd, forward_by_factorisation(model, q, qd, tau, scene=scene)) <= TOLERANCE
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
