"""Inverse dynamics by another road, in multiprecision: velocities in the ground's axes, every body on its own.

For each body Euler's laws about its centre of mass give the force and moment that it needs; a joint carries what all
bodies beyond it need, about the joint's own axis. No recursion of forces, no body axes, quadratic in the bodies.
"""

from __future__ import annotations

import mpmath
from mpmath import mpf


def _matrix(array):
    return mpmath.matrix([[mpf(float(x)) for x in row] for row in array])


def _vector(array):
    return mpmath.matrix([mpf(float(x)) for x in array])


def _cross(a, b):
    return mpmath.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _turn(axis, angle):
    """The rotation by the exponential of [axis] angle: columns are the turned unit vectors."""
    s, c = mpmath.sin(angle), mpmath.cos(angle)
    columns = [e * c + _cross(axis, e) * s + axis * (_dot(axis, e) * (1 - c)) for e in (_vector(r) for r in _UNITS)]
    return mpmath.matrix([[column[i] for column in columns] for i in range(3)])


_UNITS = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def torques_of(model, q, qd, qdd, gravity=(0, 0, -9.81)):
    """tau of one sample for a fixed base and hinges and slides, some of which may mimic others."""
    zero = mpmath.zeros(3, 1)
    placed = []
    for body in model.bodies:
        joint = body.joint
        R, p, w, wd, v, a = placed[body.parent] if body.parent >= 0 else (mpmath.eye(3), zero, zero, zero, zero, zero)
        arm = R * _vector(joint.p)
        v, a = v + _cross(w, arm), a + _cross(wd, arm) + _cross(w, _cross(w, arm))
        p, R = p + arm, R * _matrix(joint.R)
        if joint.kind != "fixed":
            ratio = mpf(joint.multiplier)
            x = ratio * mpf(float(q[joint.coordinate])) + mpf(joint.offset)
            rate, change = ratio * mpf(float(qd[joint.rate])), ratio * mpf(float(qdd[joint.rate]))
            axis = R * _vector(joint.axis)
        if joint.kind == "revolute":
            wd = wd + axis * change + _cross(w, axis) * rate
            w = w + axis * rate
            R = R * _turn(_vector(joint.axis), x)
        elif joint.kind == "prismatic":
            offset = axis * x
            p = p + offset
            a = a + _cross(wd, offset) + _cross(w, _cross(w, offset)) + _cross(w, axis) * (2 * rate) + axis * change
            v = v + _cross(w, offset) + axis * rate
        placed.append((R, p, w, wd, v, a))
    needs = [_needs(body.inertia, *place, _vector(gravity)) for body, place in zip(model.bodies, placed, strict=True)]
    forces, moments = [f for f, _ in needs], [n for _, n in needs]
    tau = [mpf(0)] * model.n
    for i in reversed(range(len(model.bodies))):
        body = model.bodies[i]
        joint, (R, p, *_) = body.joint, placed[i]
        if joint.kind != "fixed":
            axis = R * _vector(joint.axis)
            along = (
                _dot(axis, forces[i]) if joint.kind == "prismatic" else _dot(axis, moments[i] - _cross(p, forces[i]))
            )
            tau[joint.rate] += mpf(joint.multiplier) * along
        if body.parent >= 0:
            forces[body.parent] = forces[body.parent] + forces[i]
            moments[body.parent] = moments[body.parent] + moments[i]
    return tau


def _needs(inertia, R, p, w, wd, v, a, gravity):
    """The force on one body, and the moment about the ground's origin, that its motion needs."""
    m, first = mpf(float(inertia.m)), R * _vector(inertia.mc)
    I = R * _matrix(inertia.I) * R.T
    push = a - gravity
    f = push * m + _cross(wd, first) + _cross(w, _cross(w, first))
    n = _cross(first, push) + I * wd + _cross(w, I * w)
    return f, n + _cross(p, f)
