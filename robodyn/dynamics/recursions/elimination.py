"""Eliminating the accelerations of a tree of bodies, one unknown at a time, in axes that suit it; for any scalar."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from robodyn.errors import InputError
from robodyn.programs.vectors import Array, Scalar, cross, length, product, snapped, vector
from robodyn.robot.kinematics import Motion
from robodyn.robot.model import Body, Frame, Joint, Model
from robodyn.solids.inertia.laws import Inertia
from robodyn.support.floats import Floats

ROUNDING = 2.0**-48
"""A smaller share of a body's inertia is what rounding leaves of none."""
RESIST = "give a link that it carries mass and inertia, or the joint a rotor"


class Solved(NamedTuple):
    """A coordinate as elimination leaves it: `y = value - V . x - sum coupling y`, x being a body's (wd, a)."""

    rate: int
    value: Scalar
    V: Array
    coupling: Mapping[int, Scalar]

    def back(self, x: Array, y: list[Scalar]) -> None:
        y[self.rate] = self.rest(x, y)

    def rest(self, x: Array, y: list[Scalar]) -> Scalar:
        return self.value - self.V @ x - sum(share * y[other] for other, share in self.coupling.items())


class Freed(NamedTuple):
    """A joint of its own coordinate: `solved` says how the body accelerates along its axis."""

    axis: int
    solved: Solved

    def back(self, x: Array, y: list[Scalar]) -> None:
        total = self.solved.rest(x, y)
        y[self.solved.rate] = total - x[self.axis]
        x[self.axis] = total


class Moved(NamedTuple):
    """A joint that moves its body by `ratio` times a coordinate."""

    axis: int
    rate: int
    ratio: float

    def back(self, x: Array, y: list[Scalar]) -> None:
        x[self.axis] = x[self.axis] + self.ratio * y[self.rate]


class Elimination:
    """What is left of the equations while unknowns are eliminated from the tips of a tree to its base.

    Body i answers to its acceleration x = (wd, a) by `(n, f) = A x + sum G y + b`, where y are the coordinates that are
    known there only further inward; such a coordinate has the equation `sum G . x + sum D y = u`.

    Attributes:
        A: (6, 6) symmetric, b: (6,), G: (6,) by coordinate; of each body with all that it carries.
        D: by pairs of coordinates, at first the rotors.
        u: by coordinate, at first the forces on it.
        steps: of each body, how its unknowns are found once x and what was eliminated later is known.
    """

    def __init__(
        self, A: Sequence[Array], b: Sequence[Array], rotors: Mapping[tuple[int, int], float], forces: Sequence[Scalar]
    ) -> None:
        self.A, self.b, self.u = list(A), list(b), list(forces)
        self.G: list[dict[int, Array]] = [{} for _ in A]
        self.D: defaultdict[tuple[int, int], Scalar] = defaultdict(float)
        self.D.update(rotors)
        self.steps: list[list[Solved | Freed | Moved]] = [[] for _ in A]

    def join(self, i: int, axis: int, rate: int, ratio: float) -> None:
        """Lets body i move along an axis by `ratio` times a coordinate y: there x becomes x + ratio y."""
        A, columns = self.A[i], self.G[i]
        known = columns.get(rate, np.zeros(6))
        self.D[rate, rate] = self.D[rate, rate] + ratio * (ratio * A[axis, axis] + 2.0 * known[axis])
        for other in columns.keys() - {rate}:
            pair = _pair(rate, other)
            self.D[pair] = self.D[pair] + ratio * columns[other][axis]
        self.u[rate] = self.u[rate] - ratio * self.b[i][axis]
        columns[rate] = known + ratio * A[axis]
        self.steps[i].append(Moved(axis, rate, ratio))

    def coordinate(self, i: int, rate: int, name: str) -> None:
        """Eliminates a coordinate, all of whose joints body i carries."""
        self.steps[i].append(self._solved(i, rate, name))

    def _solved(self, i: int, rate: int, name: str) -> Solved:
        """Takes the coordinate out of all equations: `A - G G^T / D` and the like."""
        G, D, u, A = self.G[i].pop(rate), self.D[rate, rate], self.u[rate], self.A[i]
        known = [abs(x) for x in np.diag(A) if isinstance(x, float)]
        if D == 0 or (isinstance(D, float) and abs(D) <= ROUNDING * max(known, default=0.0)):
            raise unresisted(name)
        inverse = 1.0 / D
        V = G * inverse
        coupling = {other: self.D[_pair(rate, other)] * inverse for other in sorted(self.G[i])}
        upper = {(j, k): A[j, k] - G[j] * V[k] for j in range(6) for k in range(j, 6)}
        self.A[i] = np.array([[upper[_pair(j, k)] for k in range(6)] for j in range(6)])
        self.b[i] = self.b[i] + V * u
        for other, share in coupling.items():
            self.G[i][other] = self.G[i][other] - G * share
            self.u[other] = self.u[other] - share * u
            for last in (last for last in coupling if last >= other):
                self.D[other, last] = self.D[other, last] - share * self.D[_pair(rate, last)]
        return Solved(rate, inverse * u, V, coupling)

    def axis(self, i: int, axis: int, rate: int, name: str) -> None:
        """Eliminates the motion of body i along an axis by a coordinate of its own.

        The row and the column of the axis become what a rotor leaves of them. Without one that is exactly 0, so nothing
        cancels there, and six axes in turn are the factorisation L D L^T of a free body.
        """
        U, columns, force, rotor = self.A[i][axis], self.G[i], self.u[rate], self.D[rate, rate]
        crossing = {other: column[axis] for other, column in columns.items()}
        self.join(i, axis, rate, 1.0)
        self.steps[i].pop()
        solved = self._solved(i, rate, name)
        share = rotor / self.D[rate, rate]
        self.A[i][axis] = self.A[i][:, axis] = U * share
        self.b[i][axis] = force - share * self.u[rate]
        for other, entry in crossing.items():
            columns[other][axis] = share * entry
        solved.V[axis] = -share
        self.steps[i].append(Freed(axis, solved))


def _pair(k: int, other: int) -> tuple[int, int]:
    return min(k, other), max(k, other)


def unresisted(name: str) -> InputError:
    what = f'joint "{name}" moves nothing that has inertia, so its acceleration is not defined'
    return InputError(what, remedy=RESIST)


UNDECIDED = 1e-6
"""Axes with a smaller sine between them count as parallel: they decide no direction."""


def aligned(model: Model) -> Model:
    """Return the same robot with other axes in its bodies; origins stay, and so do q, qd and tau.

    Body i's new axes stand in its old ones as the columns of Q_i: z along its joint, x across this and the axis of the
    first joint that it carries, as Denavit and Hartenberg's. Then `R' = Q_j^T R Q_i` is a turn about x, then about z.

    Accuracy: each number of the model within 16 eps of the largest of its vector or matrix.
    """
    first: dict[int, Joint] = {}
    for body in model.bodies[1:]:
        if body.joint.kind in ("revolute", "prismatic"):
            first.setdefault(body.parent, body.joint)
    Q = [_axes(body.joint, first.get(i)) for i, body in enumerate(model.bodies)]
    bodies = tuple(_turned(body, Q[i], Q[body.parent] if i else np.eye(3)) for i, body in enumerate(model.bodies))
    links = {name: Frame(i, product(Q[i].T, R), product(Q[i].T, p)) for name, (i, R, p) in model.links.items()}
    return Model(model.name, model.file, bodies, links, model.notes)


def _axes(joint: Joint, carried: Joint | None) -> Floats:
    """Return the new axes of the body that `joint` moves, in its old ones; those of a base or a free body stay."""
    if joint.kind not in ("revolute", "prismatic"):
        return np.eye(3)
    z = joint.axis
    x = np.zeros(3) if carried is None else cross(z, product(carried.R, carried.axis))
    if length(x) < UNDECIDED:
        x = np.roll(np.eye(3)[int(np.argmax(np.abs(z)))], 1)
    x = x / length(x)
    x = x - z * (z * x).sum()
    x = snapped(x / length(x))
    return np.stack((x, cross(z, x), z), axis=1)


def _turned(body: Body, Q: Floats, Q_parent: Floats) -> Body:
    m, mc, I = body.inertia
    I = product(Q.T, np.triu(I) + np.triu(I, 1).T, Q)
    R, axis = snapped(product(Q_parent.T, body.joint.R, Q)), snapped(product(Q.T, body.joint.axis))
    joint = replace(body.joint, R=R, p=product(Q_parent.T, body.joint.p), axis=axis)
    return replace(body, joint=joint, inertia=Inertia(m, product(Q.T, mc), 0.5 * (I + I.T)))


def floating_turns(model: Model, joints: Sequence[Motion]) -> list[tuple[slice, Array]]:
    """Return the places of the rates of each floating joint's position, and the turn from body's to parent's axes."""
    free = [(body.joint, joint.R) for body, joint in zip(model.bodies, joints, strict=True)]
    return [(slice(j.rate + 3, j.rate + 6), j.R.T @ R) for j, R in free if j.kind == "floating"]


def turned(values: Sequence[Scalar], turns: list[tuple[slice, Array]], back: bool = False) -> list[Scalar]:
    """Rates or forces, those of floating joints' positions turned to the axes of the parent, or back."""
    out = list(values)
    for place, turn in turns:
        out[place] = (turn.T if back else turn) @ vector(*out[place])
    return out
