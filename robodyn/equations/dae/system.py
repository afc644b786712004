"""The equations of motion of all bodies and what connects them, as matrices; the reactions of their solution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from robodyn.equations.dae.connections import Connection
from robodyn.equations.dae.equations import Equation, Sum, drifts, stacked
from robodyn.equations.dae.state import State
from robodyn.programs.vectors import ZERO, Array, Scalar, cross, narrowed, product
from robodyn.robot.kinematics import Wrench
from robodyn.solids.inertia.laws import Inertia


@dataclass(frozen=True, eq=False)
class System:
    """Bodies and what connects them.

    Attributes:
        inertias: of each body, about its own origin.
        joints: of each body; mimics: one equation each; loops: what else connects bodies.
        rotors: by pairs of bodies, the reflected inertia between their joints [kg m^2 or kg].
    """

    inertias: tuple[Inertia, ...]
    joints: tuple[Connection, ...]
    mimics: tuple[Connection, ...] = ()
    loops: tuple[Connection, ...] = ()
    rotors: Mapping[tuple[int, int], float] = field(default_factory=dict)

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
    def rules(self) -> tuple[Sum, ...]:
        """The equations of mimic joints."""
        return tuple(rule for mimic in self.mimics for rule in mimic.equations if isinstance(rule, Sum))

    @property
    def tree(self) -> int:
        """How many rows of G come before those of loops."""
        return sum(len(connection.equations) for connection in (*self.joints, *self.mimics))

    @property
    def centres(self) -> tuple[Array, ...]:
        return tuple(inertia.centre_of_mass for inertia in self.inertias)


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


def matrices(
    system: System,
    at: State,
    gravity: Array = ZERO,
    wrenches: Sequence[tuple[int, Wrench]] = (),
    along: Sequence[Scalar] | None = None,
) -> Matrices:
    """Return the system in a state.

    Newton's and Euler's laws of each body about its mass centre: `m dv/dt = m g + F`, `I_c wd + w x I_c w = M`. What
    acts along joints enters as S^T along; a rotor adds its inertia to M along the joint, `S^T J S`.

    Args:
        gravity: (3,) m/s^2, in the ground's axes.
        wrenches: (i, wrench) pairs ON body i, about its origin in its axes.
        along: k numbers, one for each row of S [N m or N].
    """
    S, sigma = stacked(system.free, at), drifts(system.free, at)
    G, gamma = stacked(system.equations, at), -drifts(system.equations, at)
    forces = np.array(along) if along is not None else np.zeros(len(system.free))
    M, f = _mass(system), narrowed(_forces(system, at, gravity, wrenches)) + product(S.T, forces)
    bodies = [joint.body for joint in system.joints for _ in joint.free]
    armature = np.array([[system.rotors.get((i, k), 0.0) for k in bodies] for i in bodies]).reshape(
        len(bodies), len(bodies)
    )
    for i, k in np.argwhere(armature):
        M = M + armature[i, k] * np.outer(S[i], S[k])
        f = f - armature[i, k] * sigma[k] * S[i]
    return Matrices(M, f, G, gamma, S, sigma, forces, armature)


def _mass(system: System) -> Array:
    blocks = [inertia.about_centre for inertia in system.inertias]
    count = 6 * len(blocks)
    M = np.zeros((count, count), dtype=np.result_type(*blocks, *(type(b.m) for b in system.inertias)))
    for i, (inertia, I_c) in enumerate(zip(system.inertias, blocks, strict=True)):
        M[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = I_c
        for k in range(6 * i + 3, 6 * i + 6):
            M[k, k] = inertia.m
    return M


def _forces(system: System, at: State, gravity: Array, wrenches: Sequence[tuple[int, Wrench]]) -> Array:
    """(moment about the mass centre in the body's axes, force in the ground's) on each body, gyroscopic terms too."""
    moments, forces = [], []
    for inertia, speed in zip(system.inertias, at.speeds, strict=False):
        moments.append(-cross(speed.w, inertia.about_centre @ speed.w))
        forces.append(inertia.m * gravity)
    for i, (force, moment) in wrenches:
        moments[i] = moments[i] + moment - cross(system.centres[i], force)
        forces[i] = forces[i] + at.places[i].R @ force
    return np.concatenate([part for pair in zip(moments, forces, strict=True) for part in pair])


def joint_wrenches(system: System, at: State, found: Matrices, a: Array, reactions: Sequence[Scalar]) -> list[Wrench]:
    """Return the force and moment that each body's parent exerts on it, about its origin in its axes, drives included.

    The reactions of its joint's equations; along the joint's coordinates what acts there, less `J (S a + sigma)` for a
    rotor, and the reactions of the mimic rules that it takes part in.

    Args:
        a: (6N,) accelerations of the bodies.
        reactions: (m,) in the order of the rows of G.
    """
    own: dict[int, Scalar] = {}
    start = sum(len(joint.equations) for joint in system.joints)
    for k, rule in enumerate(system.rules, start):
        for weight, term in rule.terms:
            own[id(term)] = own.get(id(term), 0.0) + weight * reactions[k]
    along = found.along - product(found.armature, product(found.S, a) + found.sigma)
    out, row, k = [], 0, 0
    for i, joint in enumerate(system.joints):
        acting = [(equation, reactions[row + j]) for j, equation in enumerate(joint.equations)]
        acting += [(term, along[k + j] + own.get(id(term), 0.0)) for j, term in enumerate(joint.free)]
        row, k = row + len(joint.equations), k + len(joint.free)
        out.append(_about_origin(system, at, i, acting))
    return out


def loop_wrenches(system: System, at: State, reactions: Sequence[Scalar]) -> list[tuple[int, Wrench]]:
    """(i, wrench) pairs: what the closure of each loop does to both its bodies, the ground aside, about their origins.

    Args:
        reactions: (m,) in the order of the rows of G.
    """
    out, row = [], 0
    for connection in system.connections:
        size = len(connection.equations)
        if connection in system.loops:
            acting = list(zip(connection.equations, reactions[row : row + size], strict=True))
            ends = [i for i in (connection.body, connection.other) if i >= 0]
            out += [(i, _about_origin(system, at, i, acting)) for i in ends]
        row += size
    return out


def _about_origin(system: System, at: State, i: int, acting: Sequence[tuple[Equation, Scalar]]) -> Wrench:
    total = wrench_on(i, acting, at)
    f = at.places[i].R.T @ total[3:]
    return Wrench(f, total[:3] + cross(system.centres[i], f))


def wrench_on(body: int, acting: Sequence[tuple[Equation, Scalar]], at: State) -> Array:
    """What multipliers of equations do to a body: moment about its mass centre (its axes) and force (ground's)."""
    total: Array = np.zeros(6)
    for equation, multiplier in acting:
        for other, entries in equation.row(at):
            if other == body:
                total = total + entries * multiplier
    return total
