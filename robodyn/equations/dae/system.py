"""A robot in a scene and a state as a system of single bodies: joints and loops as connections, and the matrices."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.effects.motors import armatures, coupled_motors, spins
from robodyn.dynamics.plan import applied
from robodyn.equations.dae.constraints import (
    Along,
    Anchors,
    Connection,
    Equation,
    State,
    Sum,
    Turn,
    connect,
    drifts,
    stacked,
    state_of,
)
from robodyn.equations.ode import bias_plan
from robodyn.errors import SceneError
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross, length, narrowed, rotation_from_rpy
from robodyn.robot.kinematics import Wrench
from robodyn.robot.model import Model
from robodyn.scene.parts import Loop
from robodyn.scene.scene import Scene
from robodyn.solids.inertia.laws import Inertia
from robodyn.support.floats import Floats


class Matrices(NamedTuple):
    """`M a = f + G^T reactions` and `G a = gamma`; a is (wd, dv/dt) of each body, 6 N numbers.

    Attributes:
        M: (6N, 6N) I_c and m 1 of each body, and what rotors add.
        f: (6N,) -w x I_c w, weight, external wrenches and torques at joints.
        G, gamma: (m, 6N), (m,) of the constraints.
        S, sigma: (k, 6N), (k,) the joints' own accelerations are S a + sigma.
        along: (k,) what acts along the joints' own coordinates, rotors aside [N m or N].
        armature: (k, k) of rotors, symmetric.
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
    """A robot taken apart.

    Attributes:
        sample, terms: the motion without acceleration, and what the scene's effects make of it.
        joints: of each body; mimics: one equation each; loops: what else connects bodies.
        rotors: by pairs of bodies, the reflected inertia between their joints [kg m^2 or kg].
        at: where the bodies are.
    """

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
        tau = [
            (0.0 if body.joint.mimics is not None else self.tau[body.joint.rate + k]) - self.terms.at_joint.get(i, 0.0)
            for i, (body, connection) in enumerate(zip(self.model.bodies, self.joints, strict=True))
            for k in range(len(connection.free))
        ]
        along = np.array(tau)
        M, f = self._masses(), narrowed(self._forces()) + S.T @ along
        bodies = [joint.body for joint in self.joints for _ in joint.free]
        armature = np.array([[self.rotors.get((i, k), 0.0) for k in bodies] for i in bodies])
        armature = armature.reshape(len(bodies), len(bodies))
        for i, k in np.argwhere(armature):
            M = M + armature[i, k] * np.outer(S[i], S[k])
            f = f - armature[i, k] * sigma[k] * S[i]
        return Matrices(M, f, G, gamma, S, sigma, along, armature)

    def _masses(self) -> Array:
        blocks = [inertia.about_centre for inertia in self.inertias]
        count = 6 * len(blocks)
        M = np.zeros((count, count), dtype=np.result_type(*blocks, *(type(b.m) for b in self.inertias)))
        for i, (inertia, I_c) in enumerate(zip(self.inertias, blocks, strict=True)):
            M[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = I_c
            for k in range(6 * i + 3, 6 * i + 6):
                M[k, k] = inertia.m
        return M

    def _forces(self) -> Array:
        """(moment about the mass centre in the body's axes, force in the ground's) on each body, gyroscopic too."""
        moments, forces = [], []
        for inertia, speed in zip(self.inertias, self.at.speeds, strict=False):
            moments.append(-cross(speed.w, inertia.about_centre @ speed.w))
            forces.append(inertia.m * self.terms.gravity)
        centres = self.centres
        for i, (force, moment) in self.terms.wrenches:
            moments[i] = moments[i] + moment - cross(centres[i], force)
            forces[i] = forces[i] + self.at.places[i].R @ force
        return np.concatenate([part for pair in zip(moments, forces, strict=True) for part in pair])

    def joint_wrenches(self, a: Floats, reactions: Floats) -> list[Wrench]:
        """Return the force and moment that each body's parent exerts on it, about its origin, drives included.

        The reactions of its joint's equations; along the joint's coordinates what acts there, less `J (S a + sigma)`
        for a rotor, and the reactions of the mimic rules that it takes part in.

        Args:
            a: (6N,) accelerations of the bodies.
            reactions: (m,) in the order of the rows of G.
        """
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
        f = self.at.places[i].R.T @ total[3:]
        return Wrench(f, total[:3] + cross(self.centres[i], f))


def system_at(model: Model, scene: Scene, q: Sequence[Scalar], qd: Sequence[Scalar], tau: Sequence[Scalar]) -> System:
    """Return the robot in a state; `q`, `qd` and `tau` may be any scalar.

    Raises:
        InputError: the scene does not fit the model, or says the axes of rotors.
    """
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
    mimics = tuple(_mimic_connections(model, joints))
    loops = tuple(_loop_connection(model, centres, loop) for loop in scene.loops)
    at = state_of(model, centres, sample.q, sample.qd)
    return System(model, scene, sample, terms, tau, joints, mimics, loops, rotors, at)


def joint_connections(model: Model, centres: Sequence[Array], q: Sequence[Scalar]) -> tuple[Connection, ...]:
    """Return one for each body's joint, in the order of the bodies; where a joint is floating, one without equations.

    Args:
        centres: (3,) mass centre of each body, in its frame [m].
        q: nq scalars near which the angles of hinges are (they count turns).
    """
    found = []
    for i, body in enumerate(model.bodies):
        joint, j, R = body.joint, body.parent, body.joint.R
        to = joint.p - (centres[j] if j >= 0 else ZERO)
        anchors = Anchors(i, j, -centres[i], to, R)
        if joint.kind == "floating":
            turns = [Turn(i, j, e, R) for e in IDENTITY]
            moves = [Along(i, j, -centres[i], to, R @ e) for e in IDENTITY]
            found.append(Connection(joint.name, "floating", i, j, free=(*turns, *moves)))
        elif joint.kind == "fixed":
            found.append(connect(joint.name, "fixed", anchors))
        else:
            near = joint.multiplier * q[joint.coordinate] + joint.offset
            turn, move = Turn(i, j, joint.axis, R, near), Along(i, j, -centres[i], to, R @ joint.axis)
            free = turn if joint.kind == "revolute" else move
            found.append(connect(joint.name, joint.kind, anchors, joint.axis, free=(free,)))
    return tuple(found)


def _mimic_connections(model: Model, joints: Sequence[Connection]) -> Iterator[Connection]:
    """For each joint that follows a leader, one equation: q_follower - multiplier q_leader - offset = 0."""
    number = {body.joint.name: i for i, body in enumerate(model.bodies)}
    for i, body in enumerate(model.bodies):
        joint = body.joint
        if joint.mimics is not None:
            leader = joints[number[joint.mimics]].free[0]
            rule = Sum(((1.0, joints[i].free[0]), (-joint.multiplier, leader)), -joint.offset)
            name, reaction = f"{joint.name} follows {joint.mimics}", "F" if joint.kind == "prismatic" else "M"
            yield Connection(name, "mimic", i, body.parent, (reaction,), (rule,))


def _loop_connection(model: Model, centres: Sequence[Array], loop: Loop) -> Connection:
    body, R, place = _frame(model, centres, loop.link, loop.point)
    other, R_o, to = _frame(model, centres, loop.to, loop.to_point)
    if loop.kind == "hinge":
        axis, to_axis = R @ np.array(loop.axis), R_o @ np.array(loop.to_axis)
        axis, to_axis = axis / length(axis), to_axis / length(to_axis)
        return connect(loop.name, "hinge", Anchors(body, other, place, to, _turn_between(axis, to_axis)), axis)
    if loop.kind == "weld":
        return connect(loop.name, "weld", Anchors(body, other, place, to, R_o @ rotation_from_rpy(*loop.rpy) @ R.T))
    if loop.directions:
        along = [R_o @ np.array(n) for n in loop.directions]
        return connect(loop.name, "directions", Anchors(body, other, place, to, IDENTITY), along=along)
    return connect(loop.name, "point", Anchors(body, other, place, to, R_o @ R.T))


def _frame(model: Model, centres: Sequence[Array], link: str, at: Sequence[float]) -> tuple[int, Array, Array]:
    """The body of a link, or the ground; the link's axes in the body's, and a point of it from the mass centre."""
    if link not in model.links:
        return -1, IDENTITY, np.array(at, dtype=float)
    body, R, p = model.links[link]
    return body, R, p + R @ np.array(at, dtype=float) - centres[body]


def _turn_between(a: Array, b: Array) -> Array:
    """Return a rotation that takes the unit vector a to b: half a turn about a + b, after half a turn about a.

    Where they are opposite, half a turn about a vector across them.
    """
    middle, opposite = a + b, False
    if np.abs(middle).max() < 1e-6:
        middle, opposite = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))]), True
    middle = middle / length(middle)
    turn = 2.0 * np.outer(middle, middle) - np.eye(3)
    return turn if opposite else turn @ (2.0 * np.outer(a, a) - np.eye(3))
