"""How a link stands and moves in the axes of the link that a loop ties it to, in joint coordinates, for any scalar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.loops.equation import Equation
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross, product, skew
from robodyn.robot.kinematics import Motion, acceleration_of_point
from robodyn.robot.model import Frame, Model
from robodyn.scene.parts import Loop

GROUND_FRAME = Frame(-1, np.eye(3), np.zeros(3))


class Placed(NamedTuple):
    """A body against one that carries it, whose axes everything is in: place, velocities and their rates.

    The rates are those of a motion whose coordinates do not accelerate.
    """

    R: Array
    p: Array
    w: Array
    v: Array
    wd: Array
    a: Array

    def velocity(self, point: Array) -> Array:
        """Of the body where `point` is."""
        velocity: Array = self.v + cross(self.w, point - self.p)
        return velocity

    def acceleration(self, point: Array) -> Array:
        return acceleration_of_point(self.a, point - self.p, self.w, self.wd)


HOME = Placed(IDENTITY, ZERO, ZERO, ZERO, ZERO, ZERO)


def carried(before: Placed, joint: Motion) -> Placed:
    """Return the body that a joint carries, from the body before it: the outward recursion in fixed axes."""
    R, s = before.R @ joint.R, before.R @ joint.p
    w, v = R @ joint.w, R @ joint.v
    return Placed(
        R,
        before.p + s,
        before.w + w,
        before.v + cross(before.w, s) + v,
        before.wd + cross(before.w, w) + R @ joint.wd,
        acceleration_of_point(before.a, s, before.w, before.wd) + 2.0 * cross(before.w, v) + R @ joint.a,
    )


class Twist(NamedTuple):
    """An angular velocity, and the velocity of the loop's point."""

    w: Array
    v: Array


class Relative(NamedTuple):
    """The link in the axes of the other: its point d from the other's, its axes B, how both move, and by which joints.

    Attributes:
        speed, bias: (w, v), and its rate where no coordinate accelerates.
        columns: by rate, what a unit of it does.
    """

    d: Array
    B: Array
    speed: Twist
    bias: Twist
    columns: dict[int, Twist]


@dataclass(frozen=True, eq=False)
class Closure:
    """A loop of the scene, found in the model.

    Attributes:
        ends: frames of the two links, the body of the ground being -1.
        chains: bodies from the nearest one that carries both ends (left out) to each end.
        equations: those that are kept.
    """

    loop: Loop
    ends: tuple[Frame, Frame]
    chains: tuple[tuple[int, ...], tuple[int, ...]]
    equations: tuple[Equation, ...]

    def relative(self, model: Model, motions: Sequence[Motion]) -> Relative:
        """Return how the link stands and moves against the other.

        `v = R^T (v_a - v_b)` and `a = R^T (a_a - a_b - 2 w_b x (v_a - v_b))` for the point of the link, with the
        velocity and the acceleration that the other would have there; a joint adds `axis x r` to the one or takes it
        from the other.

        Args:
            model: its axes are any; motions: of each body relative to its parent.
        """
        a, b = (self._outward(chain, motions) for chain in self.chains)
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
                for k, twist in enumerate(_twists(model, i, before, here, point), model.bodies[i].joint.rate):
                    old = columns.get(k, Twist(ZERO, ZERO))
                    columns[k] = Twist(old.w + turn @ twist.w * side, old.v + turn @ twist.v * side)
        bias = Twist(turn @ wd, turn @ rate)
        return Relative(
            turn @ (point - other), turn @ link.R @ self.ends[0].R, Twist(turn @ w, turn @ v), bias, columns
        )

    @staticmethod
    def _outward(chain: Sequence[int], motions: Sequence[Motion]) -> list[Placed]:
        places = [HOME]
        for i in chain:
            places.append(carried(places[-1], motions[i]))
        return places


def _twists(model: Model, i: int, before: Placed, here: Placed, point: Array) -> list[Twist]:
    """What each rate of the joint that carries body i does to a point of that body, a floating one along its axes."""
    joint = model.bodies[i].joint
    if joint.kind == "floating":
        turning = [Twist(axis, cross(axis, point - here.p)) for axis in here.R.T]
        return turning + [Twist(ZERO, axis) for axis in here.R.T]
    if joint.kind == "fixed":
        return []
    axis = here.R @ joint.axis * joint.multiplier
    return [Twist(axis, cross(axis, point - here.p)) if joint.kind == "revolute" else Twist(ZERO, axis)]


def loops_size(model: Model, closures: Sequence[Closure]) -> float:
    """Return the longest offset between joints or points of the loops [m]; 1 where there is none."""
    offsets = [model.bodies[i].joint.p for closure in closures for chain in closure.chains for i in chain]
    offsets += [np.array(point) for closure in closures for point in (closure.loop.point, closure.loop.to_point)]
    return float(np.abs(offsets).max(initial=0.0)) or 1.0


class Equations(NamedTuple):
    """phi = 0 at one sample, equation by equation.

    Attributes:
        places: of each closure.
        error, rate: phi [m or rad] and phi' = J qd.
        bias: J' qd.
        J: by rate; those of a floating joint are along its body's axes.
    """

    places: list[Relative]
    error: list[Scalar]
    rate: list[Scalar]
    bias: list[Scalar]
    J: list[dict[int, Scalar]]


def held(closure: Closure, here: Relative) -> Equations:
    """phi, phi' = J qd, J' qd and J of a closure."""

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
