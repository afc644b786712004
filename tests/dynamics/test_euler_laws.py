"""The forms of Euler's second law: against a cloud of particles, against rates of momentum, and against each other."""

from __future__ import annotations

import numpy as np
import pytest
import sympy
from helpers.euler_laws import (
    about_body_point,
    about_fixed_point,
    about_mass_centre,
    angular_momentum,
    first_law,
    inertia_about,
    inertia_about_centre,
    moment_about,
)
from helpers.oracles import EPS, random_state, worst
from helpers.small_robots import chain

from robodyn.dynamics.recursions.newton_euler import inertial_wrenches
from robodyn.programs.dual import Dual, rate_of, value_of
from robodyn.programs.vectors import cross, rotation_from_quaternion, skew
from robodyn.robot.kinematics import acceleration_of_point, motions


def _vector(name):
    return np.array(sympy.symbols([f"{name}_{k}" for k in "xyz"], real=True), dtype=object)


def _symmetric(name):
    xx, xy, xz, yy, yz, zz = sympy.symbols([f"{name}_{k}" for k in ("xx", "xy", "xz", "yy", "yz", "zz")], real=True)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=object)


def _same(a, b):
    return all(sympy.expand(x - y) == 0 for x, y in zip(np.ravel(a), np.ravel(b), strict=True))


M = sympy.Symbol("m", positive=True)
I, W, WD, R, A = _symmetric("I"), *map(_vector, ("w", "wd", "r", "a"))


def test_any_body_point_is_the_mass_centre_and_the_force_there():
    """M_p = M_c + r x F, whatever the body, the point and the motion."""
    force = first_law(M, acceleration_of_point(A, R, W, WD))
    at_centre = about_mass_centre(I, W, WD)
    assert _same(about_body_point(inertia_about(I, M, R), W, WD, M, R, A), moment_about(at_centre, force, R))


def test_the_form_without_its_last_term_is_another_law():
    force = first_law(M, acceleration_of_point(A, R, W, WD))
    at_centre = about_mass_centre(I, W, WD)
    assert not _same(about_fixed_point(inertia_about(I, M, R), W, WD), moment_about(at_centre, force, R))


def test_at_rest_a_body_point_is_a_fixed_point():
    assert _same(about_body_point(I, W, WD, M, R, 0 * A), about_fixed_point(I, W, WD))


def test_at_the_mass_centre_its_acceleration_does_not_count():
    assert _same(about_body_point(I, W, WD, M, 0 * R, A), about_mass_centre(I, W, WD))


def test_between_two_body_points():
    """The moment about q from that about p, both points accelerating as points of the body do."""
    s = _vector("s")
    a_q = acceleration_of_point(A, R - s, W, WD)
    force = first_law(M, acceleration_of_point(A, R, W, WD))
    about_p = about_body_point(inertia_about(I, M, R), W, WD, M, R, A)
    about_q = about_body_point(inertia_about(I, M, s), W, WD, M, s, a_q)
    assert _same(about_p, moment_about(about_q, force, R - s))


def test_inertia_there_and_back():
    assert _same(inertia_about_centre(inertia_about(I, M, R), M, R), I)


def test_a_cloud_of_particles_obeys_every_form():
    """Four particles that move as one: sum r x m a, with no inertia matrix in it."""
    rng = np.random.default_rng(0)
    places = [np.array([sympy.Integer(int(x)) for x in row]) for row in rng.integers(-5, 6, (4, 3))]
    masses = [sympy.Integer(int(x)) for x in rng.integers(1, 6, 4)]
    total = sum(masses)
    centre = sum(m * p for m, p in zip(masses, places, strict=True)) / total
    I_p = -sum(m * (skew(p) @ skew(p)) for m, p in zip(masses, places, strict=True))
    forces = [m * acceleration_of_point(A, p, W, WD) for m, p in zip(masses, places, strict=True)]
    moment = sum(cross(p, f) for p, f in zip(places, forces, strict=True))
    assert _same(sum(forces), first_law(total, acceleration_of_point(A, centre, W, WD)))
    assert _same(moment, about_body_point(I_p, W, WD, total, centre, A))
    at_centre = sum(cross(p - centre, f) for p, f in zip(places, forces, strict=True))
    assert _same(at_centre, about_mass_centre(inertia_about_centre(I_p, total, centre), W, WD))


@pytest.mark.parametrize("seed", range(3))
def test_moments_are_rates_of_angular_momentum(seed):
    """M_p = dH_p/dt + v_p x P in ground axes, the rates by dual numbers from a quaternion that turns."""
    rng = np.random.default_rng(seed)
    h, w, wd, v, a, r = rng.normal(size=4), *rng.normal(size=(5, 3))
    B, m = rng.normal(size=(3, 3)), 2.5
    I_p = inertia_about(B @ B.T, m, r)
    h_rate = 0.5 * np.array([*(h[3] * w + np.cross(h[:3], w)), -(h[:3] @ w)])
    turn = rotation_from_quaternion(*map(Dual, h.tolist(), h_rate.tolist()))
    spin, speed = (np.array([Dual(*pair) for pair in zip(*both, strict=True)]) for both in ((w, wd), (v, a)))
    still = np.vectorize(value_of, otypes=[float])(turn)
    body_v = turn.T @ speed  # v is given in ground axes
    H = turn @ angular_momentum(I_p, spin, m, r, body_v)
    P = m * (speed + turn @ cross(spin, r))
    rate, P_now = np.vectorize(rate_of, otypes=[float])(H), np.vectorize(value_of, otypes=[float])(P)
    moment = about_body_point(I_p, w, wd, m, r, still.T @ a)
    assert worst(still @ moment, rate + np.cross(v, P_now), np.abs(rate).max() + np.abs(moment).max()) <= 64 * EPS
    F = np.vectorize(rate_of, otypes=[float])(P)
    body_force = first_law(m, acceleration_of_point(still.T @ a, r, w, wd))
    assert worst(still @ body_force, F) <= 64 * EPS


def test_the_recursions_body_is_one_of_the_forms():
    """What moves the first link of a chain that turns about a fixed point, and an accelerating one about its origin."""
    model = chain(2)
    (q,), (qd,), (qdd,) = random_state(model, np.random.default_rng(1), 1)
    _, first, second = inertial_wrenches(model.parents, motions(model, q, qd, qdd), [b.inertia for b in model.bodies])
    w, wd = (np.array([0, 0, x[0]]) for x in (qd, qdd))
    body = model.bodies[1].inertia
    assert worst(first.n, about_fixed_point(body.I, w, wd)) <= 16 * EPS
    hinge = np.array([1.0, 0, 0])
    turned = np.array([[np.cos(q[1]), np.sin(q[1]), 0], [-np.sin(q[1]), np.cos(q[1]), 0], [0, 0, 1]])
    a_p = turned @ acceleration_of_point(np.zeros(3), hinge, w, wd)
    w[2], wd[2] = w[2] + qd[1], wd[2] + qdd[1]
    body = model.bodies[2].inertia
    assert worst(second.n, about_body_point(body.I, w, wd, body.m, body.mc / body.m, a_p)) <= 16 * EPS
