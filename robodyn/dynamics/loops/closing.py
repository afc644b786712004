"""Where a robot is after a short motion from q, and closed chains brought back onto their loops after each step.

Runge-Kutta methods add; rotations do not. So each step has coordinates of its own (Munthe-Kaas, "High order
Runge-Kutta methods on manifolds", Appl. Numer. Math. 29, 1999): u, zero where the step begins, is the displacement of
every hinge and slide and of a floating joint the rotation vector in the body's axes and the displacement of its origin.
`moved` takes u to positions, and u itself changes at `local_rates`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial

from robodyn.dynamics.effects import payload
from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.loops.closed_chain import ClosedChain
from robodyn.dynamics.loops.find import jacobian
from robodyn.dynamics.plan import Plan, applied
from robodyn.programs.vectors import Array, Scalar, cross, product, sqrt, vector
from robodyn.robot.model import Model
from robodyn.support.floats import Floats

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


GENTLE = 2.0**-10
"""Softness of corrections: near a configuration at which the equations depend on each other, errors of rounding in the
direction that is lost are left alone, where an exact correction would blow them up."""
CORRECTIONS = 2
"""Of the positions after each step, with one factorisation: each divides their error by the inverse of the step's."""


@dataclass(frozen=True, eq=False)
class Closing:
    """The loops of a plan.

    Attributes:
        chain: with their equations; `necessary.closing` leaves out those that others imply.
    """

    plan: Plan
    chain: ClosedChain

    @property
    def model(self) -> Model:
        return self.chain.model

    def sample(self, q: Sequence[Scalar], qd: Sequence[Scalar]) -> Sample:
        return Sample(self.model, tuple(q), tuple(qd), (0.0,) * self.model.n)

    def at_rest(self, q: Sequence[Scalar]) -> Sample:
        return self.sample(q, (0.0,) * self.model.n)

    def jacobian(self, q: Sequence[float]) -> Floats:
        """(equations, n) J where the robot stands."""
        return jacobian(self.chain, self.at_rest(q))

    def inertial(self, sample: Sample) -> Terms:
        """Inertias alone."""
        return applied([payload.EFFECT], sample, self.plan.scene)

    def settled(self, q: Sequence[Scalar], qd: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """The state on the loops that is nearest in kinetic energy, for any scalar; with Baumgarte's terms, the same.

        `M u - J^T mu = 0`, `J u = -phi` for positions, twice with the J of the first; `J u = -phi'` for speeds.
        """
        if self.chain.baumgarte:
            return list(q), list(qd)
        n, first = self.model.n, self.sample(q, qd)
        here = self.chain.equations(first)
        solver = self.chain.solver(first, self.inertial(first), here.J, GENTLE)

        def step(errors: Sequence[Scalar]) -> list[Scalar]:
            found, _ = solver.solve([0.0] * n, [0.0 - error for error in errors])
            return self.chain.along_parents(first, found)

        for _ in range(CORRECTIONS):
            q = unit(self.model, moved(self.model, q, step(here.error)))
            here = self.chain.equations(self.sample(q, qd))
        return list(q), [rate + more for rate, more in zip(qd, step(here.rate), strict=True)]
