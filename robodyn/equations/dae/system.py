"""A robot as single bodies, for any scalar: what holds two together as equations, each a row of G; and the matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import atan2, remainder, tau
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.effects.motors import armatures, coupled_motors, spins
from robodyn.dynamics.plan import applied
from robodyn.equations.ode import bias_plan
from robodyn.errors import SceneError
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross, length, narrowed, rotation_from_rpy, skew
from robodyn.robot.kinematics import Wrench, motions, poses, velocities
from robodyn.robot.model import Model
from robodyn.scene.scene import Loop, Scene
from robodyn.solids.inertia.laws import Inertia
from robodyn.support.floats import Floats, first_largest

Row = list[tuple[int, Array]]
"""(body, its six entries) pairs; entries of the same body add up."""


class Body(NamedTuple):
    """Where a body is and how it moves.

    Attributes:
        R: rotation of its axes in the ground's; c: of its mass centre from the base's origin, in the ground's axes [m]
            (so that a robot that is far away loses no digits).
        w: angular velocity in its axes; v: velocity of its mass centre in the ground's.
    """

    R: Array
    c: Array
    w: Array
    v: Array


State = tuple[Body, ...]
"""The N bodies, and behind them the ground, so that body -1 is the ground; it stands at minus the base's position."""


def velocities_of(at: State) -> Floats:
    """(6 N,) velocities (w, v) of all bodies."""
    return narrowed(np.concatenate([part for body in at[:-1] for part in (body.w, body.v)]))


def state_of(model: Model, centres: Sequence[Array], q: Sequence[Scalar], qd: Sequence[Scalar]) -> State:
    """Return the bodies in a motion of the joints: `c = p - p_base + R r`, `v = R (v_o + w x r)`, r the mass centre;
    centres: (3,) of each body, in its frame [m]."""
    base, *others = joints = motions(model, q, qd, (0.0,) * model.n)
    there = poses(model.parents, [base._replace(p=ZERO), *others])
    found = [
        Body(pose.R, pose.p + pose.R @ r, w, pose.R @ (v + cross(w, r)))
        for pose, (w, v), r in zip(there, velocities(model.parents, joints), centres, strict=True)
    ]
    return (*found, Body(IDENTITY, -base.p, ZERO, ZERO))


@dataclass(frozen=True, eq=False)
class Place:
    """`n . (x - y) + sum E_ij B_ij`: x is a body's point, y the other's, and B turns the body's axes to the other's.

    A multiplier is a force along n at x and a moment on the body, and their opposites at the same point on the other.
    The drift of this and other equations is their second derivative where nothing accelerates.

    Attributes:
        point, to: x and y from the mass centres, in the axes of each [m].
        n, E: (3,), (3, 3) in the other's axes. E = b a^T keeps a direction a of the body across b of the other.
    """

    body: int
    other: int
    point: Array
    to: Array
    n: Array = field(default_factory=lambda: ZERO)
    E: Array = field(default_factory=lambda: np.zeros((3, 3)))

    def _seen(self, at: State) -> tuple[Array, Array, Array]:
        """x from both mass centres, in the ground's axes, and B."""
        own, other = at[self.body], at[self.other]
        r = own.R @ self.point
        return r, own.c + r - other.c, other.R.T @ own.R

    def value(self, at: State) -> Scalar:
        _, s, B = self._seen(at)
        return self.n @ (at[self.other].R.T @ s - self.to) + (self.E * B).sum()

    def row(self, at: State) -> Row:
        """B' = B [w] - [w_o] B; the point moves with v - v_o + w x r - w_o x s."""
        _, s, B = self._seen(at)
        R_o, f = at[self.other].R, at[self.other].R @ self.n
        own = cross(self.point, at[self.body].R.T @ f) + np.array([(self.E * (B @ skew(e))).sum() for e in IDENTITY])
        other = cross(self.n, R_o.T @ s) - np.array([(self.E * (skew(e) @ B)).sum() for e in IDENTITY])
        return [(self.body, np.concatenate((own, f))), (self.other, np.concatenate((other, -f)))]

    def drift(self, at: State) -> Scalar:
        """n . (w x (w x r) - w_o x (w_o x s) - 2 w_o x u), of the velocity u seen, and the same of B."""
        r, s, B = self._seen(at)
        own, other = at[self.body], at[self.other]
        w, w_o = own.R @ own.w, other.R @ other.w
        u = own.v + cross(w, r) - other.v - cross(w_o, s)
        turning, carried = skew(own.w), skew(other.w)
        B_drift = B @ turning @ turning - 2.0 * (carried @ B @ turning) + carried @ carried @ B
        point = cross(w, cross(w, r)) - cross(w_o, cross(w_o, s)) - 2.0 * cross(w_o, u)
        return (other.R @ self.n) @ point + (self.E * B_drift).sum()


@dataclass(frozen=True, eq=False)
class Turn:
    """Angle that a body has turned about its axis e against the other: the coordinate of a hinge, with e . (w - w_o).

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

    def value(self, at: State) -> float:
        """Return it for floats: sine and cosine are the skew part of the turn along e, and half its trace less 1."""
        Q = np.asarray(self.placed.T @ at[self.other].R.T @ at[self.body].R, dtype=float)
        sine = 0.5 * (self.axis @ np.array((Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1])))
        angle = atan2(sine, 0.5 * (np.trace(Q) - 1.0))
        return float(self.near + remainder(angle - self.near, tau))

    def row(self, at: State) -> Row:
        other = at[self.other].R.T @ (at[self.body].R @ self.axis)
        return [(self.body, np.append(self.axis, ZERO)), (self.other, np.append(-other, ZERO))]

    def drift(self, at: State) -> Scalar:
        """e . (w x w_o), which vanishes where the bodies only turn about e against each other."""
        body, other = at[self.body], at[self.other]
        return self.axis @ cross(body.w, body.R.T @ (other.R @ other.w))


@dataclass(frozen=True, eq=False)
class Sum:
    """A constant plus a weighted sum of other equations: how a mimic joint follows its leader."""

    terms: tuple[tuple[float, Equation], ...]
    constant: float = 0.0

    def value(self, at: State) -> Scalar:
        return self.constant + sum(weight * term.value(at) for weight, term in self.terms)

    def row(self, at: State) -> Row:
        return [(body, weight * entries) for weight, term in self.terms for body, entries in term.row(at)]

    def drift(self, at: State) -> Scalar:
        return sum(weight * term.drift(at) for weight, term in self.terms)


Equation = Place | Turn | Sum


def stacked(equations: Sequence[Equation], at: State) -> Array:
    """Return the rows of equations, with six columns (w, v) for each body; the ground's are left out."""
    G = np.zeros((len(equations), 6 * len(at) - 6), dtype=np.result_type(*(body.R for body in at)))
    for k, equation in enumerate(equations):
        for body, entries in equation.row(at):
            if body >= 0:
                G[k, 6 * body : 6 * body + 6] = G[k, 6 * body : 6 * body + 6] + entries
    return narrowed(G)


def drifts(equations: Sequence[Equation], at: State) -> Array:
    return np.array([equation.drift(at) for equation in equations])


@dataclass(frozen=True, eq=False)
class Connection:
    """A joint, a mimic rule ("mimic") or a loop's closure, as equations between a body and another.

    Attributes:
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


def connect(
    name: str,
    kind: str,
    held: Place,
    R: Array,
    axis: Array | None = None,
    along: Sequence[Array] = (),
    free: Sequence[Equation] = (),
) -> Connection:
    """Return a connection that holds 6 - f directions.

    "fixed" and "weld" hold all; "revolute" and "hinge" all but turns about the axis, "prismatic" all but moves along
    it; "point" holds the points together, a ball joint; "directions" keeps them level along some directions.

    Args:
        held: the points, without a direction; R: turns the body's axes to the other's where they are connected.
        axis: unit vector in the body's axes; along: of "directions", in the other's axes.
    """
    basis, names, last = np.eye(3), "xyz", 2
    if axis is not None and np.abs(axis).max() == 1.0:
        last = int(np.argmax(np.abs(axis)))
    elif axis is not None:  # along any other axis two vectors 1 and 2 with 1 x 2 = a
        first = np.cross(np.eye(3)[first_largest(-np.abs(axis), noise=1e-9)], axis)
        first = first / length(first)
        basis, names = np.array((first, np.cross(axis, first), axis)), "12a"
    rest = [k for k in range(3) if k != last]
    directions = {names[k]: R @ basis[k] for k in (rest if kind == "prismatic" else range(3))}
    if kind == "directions":
        directions = {str(k): n / length(n) for k, n in enumerate(along, 1)}
    reactions = [f"F{which}" for which in directions]
    equations = [replace(held, n=n) for n in directions.values()]
    turns = {"point": [], "directions": [], "revolute": rest, "hinge": rest}.get(kind, [0, 1, 2])
    for k in turns:
        # For the moment about k = i x j, direction i of the body stays across direction j of the other. Where the body
        # may turn about j, its direction j stays across -i of the other: the moment keeps its place in the other.
        i, j = (k + 1) % 3, (k + 2) % 3
        reactions.append(f"M{names[k]}")
        kept = j in turns or i not in turns
        a, b = (basis[i], R @ basis[j]) if kept else (basis[j], -R @ basis[i])
        equations.append(replace(held, E=np.outer(b, a)))
    return Connection(name, kind, held.body, held.other, tuple(reactions), tuple(equations), tuple(free))


class Matrices(NamedTuple):
    """`M a = f + G^T reactions` and `G a = gamma`; a is (wd, dv/dt) of each body, 6 N numbers.

    The joints' own accelerations are `S a + sigma` (k,); `along` (k,) acts there, rotors aside [N m or N], whose
    `armature` (k, k) is in M. f: -w x I_c w, weight, external wrenches and torques at joints.
    """

    M: Array
    f: Array
    G: Array
    gamma: Array
    S: Array
    sigma: Array
    along: Array
    armature: Array


@dataclass(frozen=True, eq=False)
class System:
    """A robot taken apart: its motion without acceleration, what the scene's effects make of it, and the connections, a
    joint for each body first; `rotors`: by pairs of bodies, the inertia between their joints [kg m^2 or kg]."""

    model: Model
    scene: Scene
    sample: Sample
    terms: Terms
    tau: Sequence[Scalar]
    joints: tuple[Connection, ...]
    mimics: tuple[Connection, ...]
    loops: tuple[Connection, ...]
    rotors: Mapping[tuple[int, int], float]
    at: State

    @property
    def inertias(self) -> Sequence[Inertia]:
        """Of each body, about its own origin."""
        return self.terms.inertias

    @property
    def centres(self) -> list[Array]:
        return [inertia.centre_of_mass for inertia in self.inertias]

    @property
    def connections(self) -> tuple[Connection, ...]:
        """In the order of the rows of G."""
        return (*self.joints, *self.mimics, *self.loops)

    @cached_property
    def equations(self) -> tuple[Equation, ...]:
        """Of all connections: the rows of G."""
        return tuple(equation for connection in self.connections for equation in connection.equations)

    @cached_property
    def free(self) -> tuple[Equation, ...]:
        """The rates of all joints, in the order of the bodies: the rows of S."""
        return tuple(equation for joint in self.joints for equation in joint.free)

    @property
    def tree(self) -> int:
        """How many rows of G come before those of loops."""
        return sum(len(connection.equations) for connection in (*self.joints, *self.mimics))

    @property
    def length(self) -> float:
        """The largest distance between a mass centre and a joint [m], 1 where all are zero."""
        bodies, centres = self.model.bodies, self.centres
        arms = [*centres, *(body.joint.p - centres[body.parent] for body in bodies if body.parent >= 0)]
        return max(length(np.asarray(arm, dtype=float)) for arm in arms) or 1.0

    def own_rates(self, along: Sequence[Scalar]) -> list[Scalar]:
        """Return the n entries, in the order of `model.rates`, out of those of all joints in the order of bodies."""
        out: list[Scalar] = [0.0] * self.model.n
        start = 0
        for body, connection in zip(self.model.bodies, self.joints, strict=True):
            width = len(connection.free)
            if body.joint.mimics is None:
                out[body.joint.rate : body.joint.rate + width] = along[start : start + width]
            start += width
        return out

    @cached_property
    def matrices(self) -> Matrices:
        """Newton's and Euler's laws of each body about its mass centre, and the connections.

        `m dv/dt = m g + F`, `I_c wd + w x I_c w = M`. What acts along joints, tau less friction and springs, enters as
        S^T along; a rotor adds its inertia to M along the joint, `S^T J S`.
        """
        S, sigma = stacked(self.free, self.at), drifts(self.free, self.at)
        G, gamma = stacked(self.equations, self.at), -drifts(self.equations, self.at)
        along = np.array([
            (0.0 if body.joint.mimics is not None else self.tau[body.joint.rate + k]) - self.terms.at_joint.get(i, 0.0)
            for i, (body, connection) in enumerate(zip(self.model.bodies, self.joints, strict=True))
            for k in range(len(connection.free))
        ])  # fmt: skip
        blocks = [inertia.about_centre for inertia in self.inertias]
        M = np.zeros((6 * len(blocks),) * 2, dtype=np.result_type(*blocks, *(type(b.m) for b in self.inertias)))
        moments, forces, centres = [], [], self.centres
        for i, (inertia, I_c, body) in enumerate(zip(self.inertias, blocks, self.at, strict=False)):
            M[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = I_c
            for k in range(6 * i + 3, 6 * i + 6):
                M[k, k] = inertia.m
            moments.append(-cross(body.w, I_c @ body.w))
            forces.append(inertia.m * self.terms.gravity)
        for i, (force, moment) in self.terms.wrenches:
            moments[i] = moments[i] + moment - cross(centres[i], force)
            forces[i] = forces[i] + self.at[i].R @ force
        f = narrowed(np.concatenate([part for pair in zip(moments, forces, strict=True) for part in pair]))
        f = f + S.T @ along
        bodies = [joint.body for joint in self.joints for _ in joint.free]
        armature = np.array([[self.rotors.get((i, k), 0.0) for k in bodies] for i in bodies])
        armature = armature.reshape(len(bodies), len(bodies))
        for i, k in np.argwhere(armature):
            M = M + armature[i, k] * np.outer(S[i], S[k])
            f = f - armature[i, k] * sigma[k] * S[i]
        return Matrices(M, f, G, gamma, S, sigma, along, armature)

    def joint_wrenches(self, a: Floats, reactions: Floats) -> list[Wrench]:
        """Return the force and moment that each body's parent exerts on it, about its origin, drives included. The
        reactions of its joint's equations; along the joint's coordinates what acts there, less `J (S a + sigma)` for a
        rotor, and the reactions of the mimic rules that it takes part in."""
        found = self.matrices
        along = found.along - found.armature @ (found.S @ a + found.sigma)
        first = sum(len(joint.equations) for joint in self.joints)
        for mimic, reaction in zip(self.mimics, reactions[first:].tolist(), strict=False):
            for rule in mimic.equations:
                assert isinstance(rule, Sum)
                for weight, term in rule.terms:
                    along[self.free.index(term)] += weight * reaction
        out, row, k = [], 0, 0
        for i, joint in enumerate(self.joints):
            held, own = slice(row, row + len(joint.equations)), slice(k, k + len(joint.free))
            row, k, mine = held.stop, own.stop, slice(6 * i, 6 * i + 6)
            out.append(self._about_origin(i, reactions[held] @ found.G[held, mine] + along[own] @ found.S[own, mine]))
        return out

    def loop_wrenches(self, reactions: Floats) -> list[tuple[int, Wrench]]:
        """(i, wrench) pairs: what the closure of each loop does to both its bodies, the ground aside, about origins."""
        out, row = [], self.tree
        for loop in self.loops:
            held = slice(row, row + len(loop.equations))
            row = held.stop
            for i in (loop.body, loop.other):
                if i >= 0:
                    total = reactions[held] @ self.matrices.G[held, 6 * i : 6 * i + 6]
                    out.append((i, self._about_origin(i, total)))
        return out

    def _about_origin(self, i: int, total: Floats) -> Wrench:
        """From the moment about the mass centre (body's axes) and the force (ground's): both about the origin."""
        f = self.at[i].R.T @ total[3:]
        return Wrench(f, total[:3] + cross(self.centres[i], f))


def system_at(model: Model, scene: Scene, q: Sequence[Scalar], qd: Sequence[Scalar], tau: Sequence[Scalar]) -> System:
    """Return the robot in a state; SceneError where the scene does not fit the model, or says the axes of rotors."""
    for spin in spins(model, scene):
        what = f"[rotor] {spin.joint.name} has an axis, and bodies on their own know only rotors that turn in place"
        raise SceneError(what, remedy="leave axis and on out, or ask for another form of the equations")
    sample = Sample(model, tuple(q), tuple(qd), (0.0,) * model.n)
    terms = applied(bias_plan(model, scene).effects, sample, scene)
    centres = [inertia.centre_of_mass for inertia in terms.inertias]
    rotors = {(i, i): inertia for i, _, inertia in armatures(model, scene)}
    for motor, turned in coupled_motors(model, scene):
        for i, _, first in turned if motor.reflected else ():
            for k, _, second in turned:
                rotors[i, k] = rotors.get((i, k), 0.0) + first * second * motor.reflected
    joints = joint_connections(model, centres, sample.q)
    number, mimics = {body.joint.name: i for i, body in enumerate(model.bodies)}, []
    for i, body in enumerate(model.bodies):
        joint = body.joint
        if joint.mimics is not None:  # q_follower - multiplier q_leader - offset = 0
            leader = joints[number[joint.mimics]].free[0]
            rule = Sum(((1.0, joints[i].free[0]), (-joint.multiplier, leader)), -joint.offset)
            name, reaction = f"{joint.name} follows {joint.mimics}", "F" if joint.kind == "prismatic" else "M"
            mimics.append(Connection(name, "mimic", i, body.parent, (reaction,), (rule,)))
    loops = tuple(_loop_connection(model, centres, loop) for loop in scene.loops)
    at = state_of(model, centres, sample.q, sample.qd)
    return System(model, scene, sample, terms, tau, joints, tuple(mimics), loops, rotors, at)


def joint_connections(model: Model, centres: Sequence[Array], q: Sequence[Scalar]) -> tuple[Connection, ...]:
    """Return one for each body's joint, in the order of the bodies; where a joint is floating, one without equations;
    centres: (3,) mass centre of each body, in its frame [m]; q: near which the angles of hinges are."""
    found = []
    for i, body in enumerate(model.bodies):
        joint, j, R = body.joint, body.parent, body.joint.R
        held = Place(i, j, -centres[i], joint.p - (centres[j] if j >= 0 else ZERO))
        if joint.kind == "floating":
            turns, moves = [Turn(i, j, e, R) for e in IDENTITY], [replace(held, n=R @ e) for e in IDENTITY]
            found.append(Connection(joint.name, "floating", i, j, free=(*turns, *moves)))
        elif joint.kind == "fixed":
            found.append(connect(joint.name, "fixed", held, R))
        else:
            near = joint.multiplier * q[joint.coordinate] + joint.offset
            turning = joint.kind == "revolute"
            rate = Turn(i, j, joint.axis, R, near) if turning else replace(held, n=R @ joint.axis)
            found.append(connect(joint.name, joint.kind, held, R, joint.axis, free=(rate,)))
    return tuple(found)


def _loop_connection(model: Model, centres: Sequence[Array], loop: Loop) -> Connection:
    body, R, place = _frame(model, centres, loop.link, loop.point)
    other, R_o, to = _frame(model, centres, loop.to, loop.to_point)
    axis, turn = None, R_o @ R.T
    if loop.kind == "hinge":
        axis, to_axis = R @ np.array(loop.axis), R_o @ np.array(loop.to_axis)
        axis, to_axis = axis / length(axis), to_axis / length(to_axis)
        # half a turn about the middle of both, after half a turn about the axis; opposite: half a turn across them
        middle, before = axis + to_axis, 2.0 * np.outer(axis, axis) - np.eye(3)
        if np.abs(middle).max() < 1e-6:
            middle, before = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))]), np.eye(3)
        middle = middle / length(middle)
        turn = (2.0 * np.outer(middle, middle) - np.eye(3)) @ before
    elif loop.kind == "weld":
        turn = R_o @ rotation_from_rpy(*loop.rpy) @ R.T
    along = [R_o @ np.array(n) for n in loop.directions]
    kind = "directions" if along else loop.kind
    return connect(loop.name, kind, Place(body, other, place, to), turn, axis, along)


def _frame(model: Model, centres: Sequence[Array], link: str, at: Sequence[float]) -> tuple[int, Array, Array]:
    """The body of a link, or the ground; the link's axes in the body's, and a point of it from the mass centre."""
    if link not in model.links:
        return -1, IDENTITY, np.array(at, dtype=float)
    body, R, p = model.links[link]
    return body, R, p + R @ np.array(at, dtype=float) - centres[body]
