"""Bodies on their own, and what holds two of them together: scalar equations, each with its row of G and its drift.

A row says how fast the equation's value changes with the velocities of bodies: six numbers for (w, v) of each. The
drift is what remains of the value's second derivative where nothing accelerates: `row . a + drift` is all of it.
All functions take any scalar.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, remainder, tau
from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross, length, narrowed
from robodyn.robot.kinematics import Acceleration, acceleration_of_point, accelerations, motions, poses, velocities
from robodyn.robot.model import Model
from robodyn.support.floats import Floats, first_largest


class Place(NamedTuple):
    """Rotation R of a body's axes in the ground's, and position c of its mass centre in these, from the base's origin.

    From there, because then a robot that is far away from the ground's origin loses no digits.
    """

    R: Array
    c: Array


class Speed(NamedTuple):
    """Angular velocity w in the body's axes, and velocity v of its mass centre in the ground's."""

    w: Array
    v: Array


STILL = Speed(ZERO, ZERO)


class State(NamedTuple):
    """Places and velocities of the N bodies, and behind them the ground's, so that body -1 is the ground.

    The ground stands at minus the position of the base.
    """

    places: tuple[Place, ...]
    speeds: tuple[Speed, ...]

    @property
    def v(self) -> Floats:
        """(6N,) velocities (w, v) of all bodies."""
        return narrowed(np.concatenate([part for speed in self.speeds[:-1] for part in speed]))


def state_of(model: Model, centres: Sequence[Array], q: Sequence[Scalar], qd: Sequence[Scalar]) -> State:
    """The bodies in a motion of the joints: `c = p - p_base + R r`, `v = R (v_o + w x r)`, r being the mass centre.

    Args:
        centres: (3,) of each body, in its frame [m].
        q: nq scalars; qd: n scalars.
    """
    base, *others = joints = motions(model, q, qd, (0.0,) * model.n)
    there = poses(model.parents, [base._replace(p=ZERO), *others])
    places, speeds = [], []
    for pose, moving, r in zip(there, velocities(model.parents, joints), centres, strict=True):
        places.append(Place(pose.R, pose.p + pose.R @ r))
        speeds.append(Speed(moving.w, pose.R @ (moving.v + cross(moving.w, r))))
    return State((*places, Place(IDENTITY, -base.p)), (*speeds, STILL))


def accelerations_of(
    model: Model, centres: Sequence[Array], q: Sequence[Scalar], qd: Sequence[Scalar], qdd: Sequence[Scalar]
) -> list[Acceleration]:
    """wd (body's axes) and acceleration of the mass centre (ground's axes) of each body in a motion of the joints."""
    joints = motions(model, q, qd, qdd)
    moving, speeding = velocities(model.parents, joints), accelerations(model.parents, joints)
    return [
        Acceleration(wd, pose.R @ acceleration_of_point(a, r, w, wd))
        for pose, (w, _), (wd, a), r in zip(poses(model.parents, joints), moving, speeding, centres, strict=True)
    ]


Row = list[tuple[int, Array]]
"""(body, its six entries) pairs; -1 is the ground, and entries of the same body add up."""


@dataclass(frozen=True, eq=False)
class Along:
    """Distance of a body's point x from the other body's point y along a direction n of the other: n . (x - y).

    Its rate is n . (v_x - v_o - w_o x s) with s = x - c_o. A multiplier is a force at x along n on the body, and the
    opposite force, at the same point, on the other.

    Attributes:
        point: x from the body's mass centre, in its axes [m].
        to: y from the other's mass centre, in its axes [m].
        direction: n, in the other's axes.
    """

    body: int
    other: int
    point: Array
    to: Array
    direction: Array

    def _arms(self, at: State) -> tuple[Array, Array, Array]:
        """x from the mass centres of both bodies, and n, in the ground's axes."""
        own, other = at.places[self.body], at.places[self.other]
        r = own.R @ self.point
        return r, own.c + r - other.c, other.R @ self.direction

    def value(self, at: State) -> Scalar:
        _, s, n = self._arms(at)
        return n @ (s - at.places[self.other].R @ self.to)

    def row(self, at: State) -> Row:
        _, s, n = self._arms(at)
        R, R_o = at.places[self.body].R, at.places[self.other].R
        own = np.concatenate((cross(self.point, R.T @ n), n))
        return [(self.body, own), (self.other, np.concatenate((cross(self.direction, R_o.T @ s), -n)))]

    def drift(self, at: State) -> Scalar:
        """n . (w x (w x r) - w_o x (w_o x s) - 2 w_o x u): centripetal terms, and Coriolis' of the velocity u seen."""
        r, s, n = self._arms(at)
        (w, v), (w_o, v_o) = at.speeds[self.body], at.speeds[self.other]
        w, w_o = at.places[self.body].R @ w, at.places[self.other].R @ w_o
        u = v + cross(w, r) - v_o - cross(w_o, s)
        return n @ (cross(w, cross(w, r)) - cross(w_o, cross(w_o, s)) - 2.0 * cross(w_o, u))


@dataclass(frozen=True, eq=False)
class Across:
    """The cosine of the angle between a direction a of a body and b of the other: a . b, which is to be zero.

    Its rate is (a x b) . (w - w_o). A multiplier is a moment about a x b on the body, and its opposite on the other.

    Attributes:
        first: a, in the body's axes.
        second: b, in the other's axes.
    """

    body: int
    other: int
    first: Array
    second: Array

    def value(self, at: State) -> Scalar:
        return (at.places[self.body].R @ self.first) @ (at.places[self.other].R @ self.second)

    def row(self, at: State) -> Row:
        R, R_o = at.places[self.body].R, at.places[self.other].R
        own, other = cross(self.first, R.T @ (R_o @ self.second)), cross(self.second, R_o.T @ (R @ self.first))
        return [(self.body, _turning(own)), (self.other, _turning(other))]

    def drift(self, at: State) -> Scalar:
        """((w x a) x b + a x (w_o x b)) . (w - w_o)."""
        R, R_o = at.places[self.body].R, at.places[self.other].R
        a, b, w, w_o = R @ self.first, R_o @ self.second, R @ at.speeds[self.body].w, R_o @ at.speeds[self.other].w
        return (cross(cross(w, a), b) + cross(a, cross(w_o, b))) @ (w - w_o)


@dataclass(frozen=True, eq=False)
class Turn:
    """Angle that a body has turned about its axis e against the other: the coordinate of a hinge.

    Its rate is e . (w - w_o). A multiplier is a moment about e on the body, and its opposite on the other.

    Attributes:
        axis: e, in the body's axes.
        placed: rotation of the body's axes in the other's where the coordinate is zero.
        near: the angle is that which differs from this one by less than half a turn [rad].
    """

    body: int
    other: int
    axis: Array
    placed: Array
    near: float = 0.0

    def _seen(self, at: State) -> Array:
        """Return rotation from the other's axes to the body's."""
        turned: Array = at.places[self.body].R.T @ at.places[self.other].R
        return turned

    def value(self, at: State) -> float:
        """For floats: sin and cos of the angle are the skew part of the turn along e, and half of its trace less 1."""
        Q = np.asarray(self.placed.T @ self._seen(at).T, dtype=float)
        sine = 0.5 * (self.axis @ np.array((Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1])))
        angle = atan2(sine, 0.5 * (np.trace(Q) - 1.0))
        return float(self.near + remainder(angle - self.near, tau))

    def row(self, at: State) -> Row:
        other = self._seen(at).T @ self.axis
        return [(self.body, _turning(self.axis)), (self.other, _turning(-other))]

    def drift(self, at: State) -> Scalar:
        """e . (w x w_o), which vanishes where the bodies only turn about e against each other."""
        return self.axis @ cross(at.speeds[self.body].w, self._seen(at) @ at.speeds[self.other].w)


@dataclass(frozen=True, eq=False)
class Sum:
    """A constant plus a weighted sum of other equations: how a mimic joint follows its leader.

    A multiplier acts through each of them, times its weight.
    """

    terms: tuple[tuple[float, Equation], ...]
    constant: float = 0.0

    def value(self, at: State) -> Scalar:
        return self.constant + sum(weight * term.value(at) for weight, term in self.terms)

    def row(self, at: State) -> Row:
        return [(body, weight * entries) for weight, term in self.terms for body, entries in term.row(at)]

    def drift(self, at: State) -> Scalar:
        return sum(weight * term.drift(at) for weight, term in self.terms)


Equation = Along | Across | Turn | Sum
"""A scalar function of the places of some bodies.

`value` is the function [m, rad, or the cosine of an angle], `row` its rate as a linear function of velocities, and
`drift` its second derivative where nothing accelerates.
"""


def _turning(w: Array) -> Array:
    return np.concatenate((w, np.zeros(3)))


def stacked(equations: Sequence[Equation], at: State) -> Array:
    """The rows of equations, one below the other, with six columns (w, v) for each body; the ground's are left out."""
    count = len(at.places) - 1
    G = np.zeros((len(equations), 6 * count), dtype=np.result_type(*(place.R for place in at.places)))
    for k, equation in enumerate(equations):
        for body, entries in equation.row(at):
            if body >= 0:
                G[k, 6 * body : 6 * body + 6] = G[k, 6 * body : 6 * body + 6] + entries
    return narrowed(G)


def drifts(equations: Sequence[Equation], at: State) -> Array:
    return np.array([equation.drift(at) for equation in equations])


def values(equations: Sequence[Equation], at: State) -> Array:
    """Return the value of each, of floats."""
    return np.array([equation.value(at) for equation in equations], dtype=float)


@dataclass(frozen=True, eq=False)
class Connection:
    """A joint, a mimic rule or a loop's closure, as equations between a body and another.

    Attributes:
        kind: "fixed", "revolute", "prismatic", "floating", "mimic", "point", "hinge", "weld" or "directions".
        body, other: what is held, and what holds it; -1 is the ground.
        reactions: their names, F for forces and M for moments, each with its direction; equations: one for each.
        free: rates of the joint's own coordinates, f of them; along them act drives, friction, springs and rotors.
    """

    name: str
    kind: str
    body: int
    other: int
    reactions: tuple[str, ...] = ()
    equations: tuple[Equation, ...] = ()
    free: tuple[Equation, ...] = ()


class Anchors(NamedTuple):
    """Two bodies, a point of each from its mass centre in its axes [m], and the turn R from the body's to the other's.

    Axes that are R apart coincide where the bodies are connected.
    """

    body: int
    other: int
    point: Array
    to: Array
    R: Array


def connect(
    name: str,
    kind: str,
    anchors: Anchors,
    axis: Array | None = None,
    along: Sequence[Array] = (),
    free: Sequence[Equation] = (),
) -> Connection:
    """Return a connection that holds 6 - f directions.

    "fixed" and "weld" hold all; "revolute" and "hinge" all but turns about the axis, "prismatic" all but moves along
    it; "point" holds the points together, a ball joint; "directions" keeps them level along some directions.

    Args:
        axis: unit vector in the body's axes.
        along: of "directions", in the other's axes.
    """
    body, other, point, to, R = anchors
    basis, names, last = basis_about(axis)
    rest = [k for k in range(3) if k != last]
    directions = {names[k]: R @ basis[k] for k in (rest if kind == "prismatic" else range(3))}
    if kind == "directions":
        directions = {str(k): n / length(n) for k, n in enumerate(along, 1)}
    reactions = [f"F{which}" for which in directions]
    equations: list[Equation] = [Along(body, other, point, to, n) for n in directions.values()]
    turns = {"point": [], "directions": [], "revolute": rest, "hinge": rest}.get(kind, [0, 1, 2])
    for k in turns:
        # For the moment about k = i x j, direction i of the body stays across direction j of the other. Where the body
        # may turn about j, its direction j stays across -i of the other: the moment keeps its place in the other.
        i, j = (k + 1) % 3, (k + 2) % 3
        reactions.append(f"M{names[k]}")
        kept = j in turns or i not in turns
        pair = (basis[i], R @ basis[j]) if kept else (basis[j], -R @ basis[i])
        equations.append(Across(body, other, *pair))
    return Connection(name, kind, body, other, tuple(reactions), tuple(equations), tuple(free))


def basis_about(axis: Array | None) -> tuple[Array, str, int]:
    """Return three perpendicular unit vectors, right-handed, their names, and the number of the axis among them.

    x, y and z without an axis, or where it is one of these or its opposite; for any other two vectors 1 and 2 with
    1 x 2 = a.
    """
    if axis is None or np.abs(axis).max() == 1.0:
        return np.eye(3), "xyz", 2 if axis is None else int(np.argmax(np.abs(axis)))
    first = np.cross(np.eye(3)[first_largest(-np.abs(axis), noise=1e-9)], axis)
    first = first / length(first)
    return np.array((first, np.cross(axis, first), axis)), "12a", 2
