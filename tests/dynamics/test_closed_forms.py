"""The chapter's robots against their closed forms at 1e-14, and free rigid bodies against Euler's equations."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import frictionless, robot, run, worst
from small_robots import body_numbers, built, link

from robodyn.inverse import inverse_dynamics, mass_matrix
from robodyn.plan import Plan
from robodyn.scene import Scene

g = 9.81
TOLERANCE = 1e-14


def _states(n):
    return np.random.default_rng(11).uniform(-1.5, 1.5, (3, 200, n))


def _agrees(name, expected, q, qd, qdd):
    model = robot(name)
    tau = inverse_dynamics(model, q, qd, qdd, scene=frictionless(model))
    assert worst(tau, np.column_stack(expected)) <= TOLERANCE
    for found, wanted in zip(tau.T, expected, strict=True):
        assert worst(found, wanted) <= TOLERANCE


def test_scara():
    q, qd, qdd = _states(3)
    l1, l2, c1, c2, m1, m2, m3, I1, I2, I3 = 0.4, 0.3, 0.2, 0.15, 6, 4, 1.5, 0.13, 0.065, 0.001
    A = I1 + I2 + I3 + m1 * c1**2 + m2 * (l1**2 + c2**2) + m3 * (l1**2 + l2**2)
    B = l1 * (m2 * c2 + m3 * l2)
    C = I2 + I3 + m2 * c2**2 + m3 * l2**2
    (_, q2, _), (w1, w2, _), (a1, a2, a3) = q.T, qd.T, qdd.T
    tau1 = (A + 2 * B * np.cos(q2)) * a1 + (C + B * np.cos(q2)) * a2 - B * np.sin(q2) * (2 * w1 * w2 + w2**2)
    tau2 = (C + B * np.cos(q2)) * a1 + C * a2 + B * np.sin(q2) * w1**2
    _agrees("scara", [tau1, tau2, m3 * (a3 - g)], q, qd, qdd)


def test_cylindrical():
    q, qd, qdd = _states(4)
    m2, m3, m4, Izz = 5, 3, 1, 0.431
    x3, x4 = 0.3 + q[:, 2], 0.6 + q[:, 2]
    (w, _, rd, _), (al, zdd, rdd, ddd) = qd.T, qdd.T
    turning = m3 * x3 + m4 * x4
    expected = [
        (Izz + m3 * x3**2 + m4 * x4**2) * al + 2 * turning * rd * w,
        (m2 + m3 + m4) * (zdd + g) - m4 * ddd,
        (m3 + m4) * rdd - turning * w**2,
        m4 * (ddd - zdd - g),
    ]
    _agrees("cylindrical", expected, q, qd, qdd)


def test_two_link_planar():
    q, qd, qdd = _states(2)
    l1, l2, m1, m2 = 0.5, 0.4, 4, 2.5
    (q1, q2), (w1, w2), (a1, a2) = q.T, qd.T, qdd.T
    s2, c2, c12 = np.sin(q2), np.cos(q2), np.cos(q1 + q2)
    M11 = l2**2 * m2 + 2 * l1 * l2 * m2 * c2 + l1**2 * (m1 + m2)
    M12 = l2**2 * m2 + l1 * l2 * m2 * c2
    tau1 = M11 * a1 + M12 * a2 - m2 * l1 * l2 * s2 * (w2**2 + 2 * w1 * w2)
    tau1 += m2 * l2 * g * c12 + (m1 + m2) * l1 * g * np.cos(q1)
    tau2 = M12 * a1 + l2**2 * m2 * a2 + m2 * l1 * l2 * s2 * w1**2 + m2 * l2 * g * c12
    _agrees("two_link_planar", [tau1, tau2], q, qd, qdd)
    M = mass_matrix(robot("two_link_planar"), q)
    M22 = np.full_like(M11, l2**2 * m2)
    assert worst(M, np.moveaxis(np.array([[M11, M12], [M12, M22]]), -1, 0)) <= TOLERANCE


def test_two_link_spatial():
    q, qd, qdd = _states(2)
    Izz, a, m2, c, Ix, Iy, Iz = 0.09, 0.15, 3, 0.3, 0.004, 0.1, 0.102
    q2, (w1, w2), (a1, a2) = q[:, 1], qd.T, qdd.T
    r = a + c * np.cos(q2)
    k = (Ix - Iz) * np.sin(q2) * np.cos(q2) - m2 * r * c * np.sin(q2)
    M11 = Izz + Ix * np.sin(q2) ** 2 + Iz * np.cos(q2) ** 2 + m2 * r**2
    expected = [M11 * a1 + 2 * k * w1 * w2, (Iy + m2 * c**2) * a2 - k * w1**2 + m2 * g * c * np.cos(q2)]
    _agrees("two_link_spatial", expected, q, qd, qdd)


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
