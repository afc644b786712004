"""Momenta and energies of a tree of bodies, for any scalar, and the dual state that gives their rates."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from robodyn.programs.derivative import Dual
from robodyn.programs.vectors import Array, Scalar, cross
from robodyn.robot.kinematics import Motion, velocities
from robodyn.robot.model import Model
from robodyn.solids.inertia.laws import Inertia


def dual_state(
    model: Model, q: Sequence[Scalar], qd: Sequence[Scalar], qdd: Sequence[Scalar]
) -> tuple[list[Dual], list[Dual]]:
    """q and qd as duals whose rates are those of the motion."""
    position = [Dual(x, rate) for x, rate in zip(q, position_rates(model, q, qd), strict=True)]
    return position, [Dual(x, rate) for x, rate in zip(qd, qdd, strict=True)]


def position_rates(model: Model, q: Sequence[Scalar], qd: Sequence[Scalar]) -> list[Scalar]:
    """Return the rates of q: qd; of a floating joint v, and `h (w_body, 0) / 2` of its quaternion h (x y z w)."""
    rates: list[Scalar] = []
    for joint in model.independent:
        if joint.kind == "floating":
            w, v = qd[joint.rate : joint.rate + 3], qd[joint.rate + 3 : joint.rate + 6]
            x, y, z, s = q[joint.coordinate + 3 : joint.coordinate + 7]
            a, b, c = (0.5 * component for component in w)
            turn = [s * a + y * c - z * b, s * b + z * a - x * c, s * c + x * b - y * a, -(x * a + y * b + z * c)]
            rates += [*v, *turn]
        else:
            rates.append(qd[joint.rate])
    return rates


class Momenta(NamedTuple):
    """Linear and angular momentum, kinetic energy, mass and first moment of the tree, about the base's origin and in
    its axes [SI units]."""

    P: Array
    H: Array
    T: Scalar
    m: Scalar
    mc: Array


def momentum_of_bodies(
    parents: Sequence[int], motions: Sequence[Motion], inertias: Sequence[Inertia]
) -> list[tuple[Array, Array]]:
    """Return each body's `P = m v + w x m c` and `H = m c x v + I w`, about its origin and in its axes."""
    return [
        (body.m * v + cross(w, body.mc), cross(body.mc, v) + body.I @ w)
        for (w, v), body in zip(velocities(parents, motions), inertias, strict=True)
    ]


def momenta(parents: Sequence[int], motions: Sequence[Motion], inertias: Sequence[Inertia]) -> Momenta:
    """Momenta and energy from velocities alone: no force and no acceleration enters; arguments as for `newton_euler`.

    `T = sum (P . v + H . w) / 2` over the bodies; inward `P_j += R P`, `H_j += R H + p x R P`, and the same for mass
    and first moment.

    Accuracy: 1e-14 of the sum of the magnitudes that add up to each result.
    """
    each = momentum_of_bodies(parents, motions, inertias)
    P, H = [body[0] for body in each], [body[1] for body in each]
    m, mc = [body.m for body in inertias], [body.mc for body in inertias]
    twice_T: Scalar = 0.0
    for i, (w, v) in enumerate(velocities(parents, motions)):
        twice_T = twice_T + P[i] @ v + H[i] @ w
    for i in reversed(range(len(parents))):
        if (j := parents[i]) >= 0:
            R, p = motions[i].R, motions[i].p
            P_in = R @ P[i]
            P[j], H[j] = P[j] + P_in, H[j] + R @ H[i] + cross(p, P_in)
            m[j], mc[j] = m[j] + m[i], mc[j] + R @ mc[i] + m[i] * p
    return Momenta(P[0], H[0], 0.5 * twice_T, m[0], mc[0])
