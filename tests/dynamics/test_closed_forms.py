"""The chapter's robots against their closed forms at 1e-14, and free rigid bodies against Euler's equations."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.closed_forms import TORQUES, g, two_link_planar_masses
from helpers.oracles import frictionless, robot, run, worst
from helpers.small_robots import body_numbers, built, link

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.mass import mass_matrix
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


def test_free_cylinder_needs_no_moment():
    """I = 0.04, J = 0.02, w0 = (2, 4, 6): the spin axis precesses at (I - J) / I w_z = 3 (Drake's benchmark)."""
    model = built(link("body", 1, inertia=(0.04, 0, 0, 0.04, 0, 0.02)), moving_base=True)
    t = np.linspace(0, 5, 201)
    s, c = np.sin(3 * t), np.cos(3 * t)
    none = np.zeros_like(t)
    w = np.column_stack((2 * c + 4 * s, -2 * s + 4 * c, np.full_like(t, 6.0)))
    wd = np.column_stack((-6 * s + 12 * c, -6 * c - 12 * s, none))
    pose = np.tile([0.0, 0, 0, 0, 0, 0, 1], (len(t), 1))
    rest = np.zeros((len(t), 3))
    tau = inverse_dynamics(model, pose, np.hstack((w, rest)), np.hstack((wd, rest)), scene=Scene(gravity=(0, 0, 0)))
    assert worst(tau, np.zeros_like(tau), 0.04 * np.abs(wd).max()) <= TOLERANCE


@pytest.mark.parametrize("tilt", [0.3, 1.2])
def test_steady_precession_of_a_heavy_top(tilt):
    """No torque about the pivot where `(C w_z - I1 P cos(tilt)) P = m g l`, w_z = S + P cos(tilt)."""
    m, length, A, C, P = 2.0, 0.4, 0.05, 0.02, 3.0
    I1 = A + m * length**2
    S = (m * g * length / P + I1 * P * np.cos(tilt)) / C - P * np.cos(tilt)
    model = built(link("top", m, (0, 0, length), (A, 0, 0, A, 0, C)), moving_base=True)
    spin = np.linspace(0, 6, 40)
    # Precession about the ground's z, tilt about x, spin about the body's z: body rates by the usual Euler angles.
    s, c = np.sin(spin), np.cos(spin)
    w = np.column_stack((P * np.sin(tilt) * s, P * np.sin(tilt) * c, np.full_like(s, S + P * np.cos(tilt))))
    wd = np.column_stack((P * np.sin(tilt) * c * S, -P * np.sin(tilt) * s * S, 0 * s))
    half = np.column_stack((np.cos(spin / 2), np.sin(spin / 2)))
    lean = np.array([np.sin(tilt / 2), np.cos(tilt / 2)])
    h = np.column_stack((lean[0] * half[:, 0], -lean[0] * half[:, 1], lean[1] * half[:, 1], lean[1] * half[:, 0]))
    rest = np.zeros((len(s), 3))
    tau = inverse_dynamics(model, np.hstack((rest, h)), np.hstack((w, rest)), np.hstack((wd, rest)))
    assert worst(tau[:, :3], rest, m * g * length) <= 100 * TOLERANCE


def test_composite_body_rests_on_its_base():
    model = robot("composite")
    plan = Plan(model, Scene())
    base = run(plan.wrenches(), plan, np.empty((1, 0)), np.empty((1, 0)), np.empty((1, 0)))[0]
    m, mc, _ = model.bodies[0].inertia
    assert worst(base, [0, 0, m * g, mc[1] * g, -mc[0] * g, 0]) <= 1e-15
