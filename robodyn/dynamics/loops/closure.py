"""How a link stands and moves in the axes of the link that a loop ties it to, in joint coordinates, for any scalar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial
from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import (
    IDENTITY,
    ZERO,
    Array,
    Scalar,
    cross,
    product,
    rotation_from_rpy,
    skew,
    snapped,
    sqrt,
    vector,
)
from robodyn.robot.kinematics import Motion, acceleration_of_point
from robodyn.robot.model import Frame, Model
from robodyn.scene.scene import Loop
from robodyn.support.floats import Floats

TERMS = 10
"""Of the series for turns within a step: errors below 1e-16 up to 1 rad per step, 1e-9 up to 3."""
_COSINE = tuple((-1) ** k / factorial(2 * k) for k in range(TERMS))
_SINE = tuple((-1) ** k / factorial(2 * k + 1) for k in range(TERMS))
_BERNOULLI = (1 / 6, -1 / 30, 1 / 42, -1 / 30, 5 / 66, -691 / 2730, 7 / 6, -3617 / 510, 43867 / 798, -174611 / 330)
_INVERSE = tuple(abs(b) / factorial(2 * k) for k, b in enumerate(_BERNOULLI, 1))
"""Of (1 - (t / 2) cot(t / 2)) / t^2, by powers of t^2."""
GROUND_FRAME = Frame(-1, np.eye(3), np.zeros(3))


def moved(model: Model, q: Sequence[Scalar], u: Sequence[Scalar]) -> list[Scalar]:
    """q after the displacement u: sums, and `h exp(u)` for the quaternion h of a floating joint, to 4 eps for turns of
    up to 1 rad."""
    out = list(q)
    for joint in model.independent:
        k, i = joint.coordinate, joint.rate
        if joint.kind == "floating":
            out[k : k + 3] = [x + dx for x, dx in zip(q[k : k + 3], u[i + 3 : i + 6], strict=True)]
            t, a, r = vector(*u[i : i + 3]), vector(*q[k + 3 : k + 6]), q[k + 6]
            quarter = 0.25 * product(t, t)
            w, v = _series(_COSINE, quarter), t * (0.5 * _series(_SINE, quarter))
            out[k + 3 : k + 7] = [*(v * r + a * w + cross(a, v)), r * w - product(a, v)]
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
    """The rates of u: qd, and for a rotation vector t `w + t x w / 2 + c t x (t x w)`, the inverse of exp's derivative,
    with `c = (1 - (|t| / 2) cot(|t| / 2)) / |t|^2` and the angular velocity w in the body's axes."""
    out = list(qd)
    for joint in model.independent:
        if joint.kind == "floating":
            part = slice(joint.rate, joint.rate + 3)
            t, w = vector(*u[part]), vector(*qd[part])
            once = cross(t, w)
            out[part] = w + once * 0.5 + cross(t, once) * _series(_INVERSE, product(t, t))
    return out


def _series(coefficients: Sequence[float], x: Scalar) -> Scalar:
    value: Scalar = coefficients[-1]
    for coefficient in coefficients[-2::-1]:
        value = value * x + coefficient
    return value


class Equation(NamedTuple):
    """`D . d + sum_ij E_ij B_ij = 0` for the point at d and the axes B of the link, both in the axes of the other.
    Being linear it gives its rates: `D . v + E : [w] B`, and so on. `unit` is "m" or "rad", `about` what it holds."""

    D: Floats
    E: Floats
    unit: str
    about: str

    def of(self, d: Array, B: Array) -> Scalar:
        value: Scalar = product(self.D, d)
        return value + (self.E * B).sum() if self.E.any() else value

    def moment(self, B: Array) -> Array:
        """(3,) on the link about its point, in the axes of the other, for lambda = 1: `n_j = E : [e_j] B`; the force is
        D."""
        return np.array([(self.E * product(skew(axis), B)).sum() for axis in IDENTITY])


def equations_of(loop: Loop) -> tuple[Equation, ...]:
    """All equations of a closure: those of the point, then those of the axes.

    A point is held along three axes, or along the loop's directions. A hinge moreover keeps its axis s across two
    vectors t across the hinge's axis in the other link: `t . B s = 0`. A weld keeps the turn `X = B R^T` from its own R
    symmetric, which near no turn is none: `(X_32 - X_23) / 2 = 0` and so on.
    """
    along = [_unit(direction) for direction in loop.directions] or list(IDENTITY)
    held = [Equation(D, np.zeros((3, 3)), "m", f"along {_shown(D)}") for D in along]
    if loop.kind == "hinge":
        s, other = _unit(loop.axis), _unit(loop.to_axis)
        t = np.roll(IDENTITY[int(np.argmax(np.abs(other)))], 1)
        t = _unit(t - other * product(other, t))  # coordinate axes where the hinge's axis is one
        for each in (t, snapped(cross(other, t))):
            held.append(Equation(np.zeros(3), np.outer(each, s), "rad", f"axis across {_shown(each)}"))
    if loop.kind == "weld":
        R = rotation_from_rpy(*loop.rpy)
        for i, axis in enumerate(IDENTITY):
            j, k = (i + 1) % 3, (i + 2) % 3
            E = 0.5 * (np.outer(IDENTITY[k], R[j]) - np.outer(IDENTITY[j], R[k]))
            held.append(Equation(np.zeros(3), E, "rad", f"turn about {_shown(axis)}"))
    return tuple(held)


def _unit(values: object) -> Floats:
    x = np.asarray(values, dtype=float)
    return snapped(x / np.sqrt(product(x, x)))


def _shown(axis: Floats) -> str:
    for name, one in zip("xyz", IDENTITY, strict=True):
        if np.array_equal(np.abs(axis), one):
            return name
    return f"({', '.join(f'{x:.3g}' for x in axis)})"


class Twist(NamedTuple):
    """An angular velocity, and the velocity of the loop's point."""

    w: Array
    v: Array


class Relative(NamedTuple):
    """The link in the axes of the other: its point d from the other's, its axes B, how both move, and by which joints.
    `speed` and `bias` are (w, v), and its rate where no coordinate accelerates; `columns`, by rate, what a unit does.
    """

    d: Array
    B: Array
    speed: Twist
    bias: Twist
    columns: dict[int, Twist]


@dataclass(frozen=True, eq=False)
class Closure:
    """A loop of the scene, found in the model: ends, frames of the two links, the ground's body being -1; chains,
    bodies from the nearest one that carries both (left out) to each; and the equations that are kept."""

    loop: Loop
    ends: tuple[Frame, Frame]
    chains: tuple[tuple[int, ...], tuple[int, ...]]
    equations: tuple[Equation, ...]

    def relative(self, model: Model, motions: Sequence[Motion]) -> Relative:
        """How the link stands and moves against the other: `v = R^T (v_a - v_b)`, `a = R^T (a_a - a_b - 2 w_b x (v_a -
        v_b))` for the point of the link, with the velocity and the acceleration that the other would have there; a
        joint adds `axis x r` to the one or takes it from the other."""
        a, b = (_placed(chain, motions) for chain in self.chains)
        link, to = a[-1], b[-1]
        point = link.p + link.R @ (self.ends[0].p + product(self.ends[0].R, np.array(self.loop.point)))
        other = to.p + to.R @ (self.ends[1].p + product(self.ends[1].R, np.array(self.loop.to_point)))
        turn = (to.R @ self.ends[1].R).T
        w, v = link.w - to.w, link.velocity(point) - to.velocity(point)
        wd = link.wd - to.wd - cross(to.w, w)
        rate = link.acceleration(point) - to.acceleration(point) - 2.0 * cross(to.w, v)
        columns: dict[int, Twist] = {}
        for side, chain, places in zip((1.0, -1.0), self.chains, (a, b), strict=True):
            for i, before, here in zip(chain, places, places[1:], strict=False):
                joint = model.bodies[i].joint
                twists: list[Twist] = []
                if joint.kind == "floating":
                    twists = [Twist(axis, cross(axis, point - here.p)) for axis in here.R.T]
                    twists += [Twist(ZERO, axis) for axis in (before.R @ joint.R).T]
                elif joint.kind != "fixed":
                    axis = here.R @ joint.axis * joint.multiplier
                    turns = joint.kind == "revolute"
                    twists = [Twist(axis, cross(axis, point - here.p)) if turns else Twist(ZERO, axis)]
                for k, twist in enumerate(twists, joint.rate):
                    old = columns.get(k, Twist(ZERO, ZERO))
                    columns[k] = Twist(old.w + turn @ twist.w * side, old.v + turn @ twist.v * side)
        bias = Twist(turn @ wd, turn @ rate)
        return Relative(
            turn @ (point - other), turn @ link.R @ self.ends[0].R, Twist(turn @ w, turn @ v), bias, columns
        )


class Placed(NamedTuple):
    """A body against one that carries it, in whose axes all is: place, velocities, and their rates without qdd."""

    R: Array
    p: Array
    w: Array
    v: Array
    wd: Array
    a: Array

    def velocity(self, point: Array) -> Array:
        velocity: Array = self.v + cross(self.w, point - self.p)
        return velocity

    def acceleration(self, point: Array) -> Array:
        return acceleration_of_point(self.a, point - self.p, self.w, self.wd)


def _placed(chain: Sequence[int], motions: Sequence[Motion]) -> list[Placed]:
    """The body that carries a chain, and each body of it: the outward recursion in the axes of the first."""
    places = [Placed(IDENTITY, ZERO, ZERO, ZERO, ZERO, ZERO)]
    for joint in (motions[i] for i in chain):
        before = places[-1]
        R, s = before.R @ joint.R, before.R @ joint.p
        w, v = R @ joint.w, R @ joint.v
        wd = before.wd + cross(before.w, w) + R @ joint.wd
        a = acceleration_of_point(before.a, s, before.w, before.wd) + 2.0 * cross(before.w, v) + R @ joint.a
        places.append(Placed(R, before.p + s, before.w + w, before.v + cross(before.w, s) + v, wd, a))
    return places


def loops_size(model: Model, closures: Sequence[Closure]) -> float:
    """Return the longest offset between joints or points of the loops [m]; 1 where there is none."""
    offsets = [model.bodies[i].joint.p for closure in closures for chain in closure.chains for i in chain]
    offsets += [np.array(point) for closure in closures for point in (closure.loop.point, closure.loop.to_point)]
    return float(np.abs(offsets).max(initial=0.0)) or 1.0


class Equations(NamedTuple):
    """phi [m or rad], phi' = J qd, J' qd and J by rate, equation by equation, and the place of each closure."""

    places: list[Relative]
    error: list[Scalar]
    rate: list[Scalar]
    bias: list[Scalar]
    J: list[dict[int, Scalar]]


def held(closure: Closure, here: Relative) -> Equations:
    def of(twist: Twist) -> list[Scalar]:
        turned = skew(twist.w) @ here.B
        return [equation.of(twist.v, turned) for equation in closure.equations]

    spin = skew(here.speed.w)
    turned = (skew(here.bias.w) + spin @ spin) @ here.B
    columns = {rate: of(twist) for rate, twist in here.columns.items()}
    return Equations(
        [here],
        [equation.of(here.d, here.B) for equation in closure.equations],
        of(here.speed),
        [equation.of(here.bias.v, turned) for equation in closure.equations],
        [{rate: values[k] for rate, values in columns.items()} for k in range(len(closure.equations))],
    )
