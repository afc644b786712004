"""The state of a motion as dual scalars: every coordinate with its rate."""

from __future__ import annotations

from collections.abc import Sequence

from robodyn.programs.dual import Dual
from robodyn.programs.vectors import Scalar
from robodyn.robot.model import Model


def along_motion(
    model: Model, q: Sequence[Scalar], qd: Sequence[Scalar], qdd: Sequence[Scalar]
) -> tuple[list[Dual], list[Dual]]:
    """q and qd as duals whose rates are those of the motion.

    A hinge or slide moves at qd. A floating joint's position moves at v, its quaternion h (x y z w) at
    `h_dot = h (w_body, 0) / 2`. Speeds change at qdd.

    Args:
        q: nq scalars; qd, qdd: n scalars.
    """
    rates: list[Scalar] = []
    for joint in model.independent:
        if joint.kind == "floating":
            w, v = qd[joint.rate : joint.rate + 3], qd[joint.rate + 3 : joint.rate + 6]
            rates += [*v, *_quaternion_rate(q[joint.coordinate + 3 : joint.coordinate + 7], w)]
        else:
            rates.append(qd[joint.rate])
    position = [Dual(x, rate) for x, rate in zip(q, rates, strict=True)]
    return position, [Dual(x, rate) for x, rate in zip(qd, qdd, strict=True)]


def _quaternion_rate(h: Sequence[Scalar], w: Sequence[Scalar]) -> list[Scalar]:
    x, y, z, s = h
    a, b, c = (0.5 * component for component in w)
    return [s * a + y * c - z * b, s * b + z * a - x * c, s * c + x * b - y * a, -(x * a + y * b + z * c)]
