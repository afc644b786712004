"""The chapter's robots against their closed forms at 1e-14, and free rigid bodies against Euler's equations."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.closed_forms import TORQUES, g, two_link_planar_masses
from helpers.oracles import frictionless, robot, run, worst
from helpers.small_robots import body_numbers, built, link

from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.scene.scene import Scene

TOLERANCE = 1e-14


def _states(n):
    return np.random.default_rng(11).uniform(-1.5, 1.5, (3, 200, n))


@pytest.mark.parametrize("name", TORQUES)
def test_torques(name):
    model = robot(name)
    q, qd, qdd = _states(model.n)
    expected = TORQUES[name](q, qd, qdd)
    tau = inverse_dynamics(model, q, qd, qdd, scene=frictionless(model))
    assert worst(tau, np.column_stack(expected)) <= TOLERANCE
    for found, wanted in zip(tau.T, expected, strict=True):
        assert worst(found, wanted) <= TOLERANCE


def test_mass_matrix_of_craigs_arm():
    q = _states(2)[0]
    M11, M12, M22 = two_link_planar_masses(q)
    expected = np.moveaxis(np.array([[M11, M12], [M12, M22]]), -1, 0)
    assert worst(mass_matrix(robot("two_link_planar"), q), expected) <= TOLERANCE


def test_moment_of_a_free_body_is_eulers():
    """About its centre of mass tau = I wd + w x I w, and the force m (a - g) does not see the rotation."""
    rng = np.random.default_rng(5)
    m, _, six = body_numbers(rng)
    I = np.zeros((3, 3))
    I[np.triu_indices(3)] = six
    I += np.triu(I, 1).T
    model = built(link("body", m, inertia=six), moving_base=True)
    q = rng.normal(size=(50, 7))
    qd, qdd = rng.normal(size=(2, 50, 6))
    tau = inverse_dynamics(model, q, qd, qdd)
    w, wd = qd[:, :3], qdd[:, :3]
    assert worst(tau[:, :3], wd @ I + np.cross(w, w @ I)) <= TOLERANCE
    assert worst(tau[:, 3:], m * (qdd[:, 3:] + [0, 0, g])) <= TOLERANCE


def test_composite_body_rests_on_its_base():
    model = robot("composite")
    plan = Plan(model, Scene())
    base = run(plan.wrenches(), plan, np.empty((1, 0)), np.empty((1, 0)), np.empty((1, 0)))[0]
    m, mc, _ = model.bodies[0].inertia
    assert worst(base, [0, 0, m * g, mc[1] * g, -mc[0] * g, 0]) <= 1e-15
