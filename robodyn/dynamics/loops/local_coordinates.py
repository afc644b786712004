"""Where a robot is after a short motion from q.

Runge-Kutta methods add; rotations do not. So each step has coordinates of its own (Munthe-Kaas, "High order
Runge-Kutta methods on manifolds", Appl. Numer. Math. 29, 1999): u, zero where the step begins, is the displacement of
every hinge and slide and of a floating joint the rotation vector in the body's axes and the displacement of its origin.
`moved` takes u to positions, and u itself changes at `local_rates`.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial

from robodyn.programs.vectors import Array, Scalar, cross, product, sqrt, vector
from robodyn.robot.model import Model

TERMS = 10
"""Of the series for turns within a step: errors below 1e-16 up to 1 rad per step, 1e-9 up to 3."""
_COSINE = tuple((-1) ** k / factorial(2 * k) for k in range(TERMS))
_SINE = tuple((-1) ** k / factorial(2 * k + 1) for k in range(TERMS))
_BERNOULLI = (1 / 6, -1 / 30, 1 / 42, -1 / 30, 5 / 66, -691 / 2730, 7 / 6, -3617 / 510, 43867 / 798, -174611 / 330)
_INVERSE = tuple(abs(b) / factorial(2 * k) for k, b in enumerate(_BERNOULLI, 1))
"""Of (1 - (t / 2) cot(t / 2)) / t^2, by powers of t^2."""


def moved(model: Model, q: Sequence[Scalar], u: Sequence[Scalar]) -> list[Scalar]:
    """q after the displacement u: sums, and `h exp(u)` for the quaternion h of a floating joint.

    Args:
        q: nq scalars; u: n.

    Accuracy: 4 eps for turns of up to 1 rad.
    """
    out = list(q)
    for joint in model.independent:
        k, i = joint.coordinate, joint.rate
        if joint.kind == "floating":
            out[k : k + 3] = [x + dx for x, dx in zip(q[k : k + 3], u[i + 3 : i + 6], strict=True)]
            out[k + 3 : k + 7] = _turned(q[k + 3 : k + 7], vector(*u[i : i + 3]))
        else:
            out[k] = q[k] + u[i]
    return out


def unit(model: Model, q: Sequence[Scalar]) -> list[Scalar]:
    """q with quaternions of unit length."""
    out = list(q)
    for joint in model.independent:
        if joint.kind == "floating":
            part = slice(joint.coordinate + 3, joint.coordinate + 7)
            x, y, z, w = out[part]
            out[part] = [part / sqrt(x * x + y * y + z * z + w * w) for part in (x, y, z, w)]
    return out


def local_rates(model: Model, u: Sequence[Scalar], qd: Sequence[Scalar]) -> list[Scalar]:
    """The rates of u: qd, and for a rotation vector t `w + t x w / 2 + c t x (t x w)`, the inverse of exp's derivative.

    `c = (1 - (|t| / 2) cot(|t| / 2)) / |t|^2`, w the angular velocity in the body's axes.
    """
    out = list(qd)
    for joint in model.independent:
        if joint.kind == "floating":
            part = slice(joint.rate, joint.rate + 3)
            t, w = vector(*u[part]), vector(*qd[part])
            once = cross(t, w)
            out[part] = w + once * 0.5 + cross(t, once) * _series(_INVERSE, product(t, t))
    return out


def _turned(h: Sequence[Scalar], t: Array) -> list[Scalar]:
    quarter = 0.25 * product(t, t)
    w = _series(_COSINE, quarter)
    v = t * (0.5 * _series(_SINE, quarter))
    a, r = vector(*h[:3]), h[3]
    return [*(v * r + a * w + cross(a, v)), r * w - product(a, v)]


def _series(coefficients: Sequence[float], x: Scalar) -> Scalar:
    value: Scalar = coefficients[-1]
    for coefficient in coefficients[-2::-1]:
        value = value * x + coefficient
    return value
