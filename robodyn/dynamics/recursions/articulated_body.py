"""Accelerations by articulated bodies (ABA), one unknown eliminated at a time, and the mass matrix by composite bodies
(CRBA) with its sparse factors; for any scalar, in axes that suit them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import hypot
from typing import NamedTuple

import numpy as np

from robodyn.errors import InputError
from robodyn.programs.vectors import ZERO, Array, Scalar, cross, length, product, skew, snapped, sqrt, total, vector
from robodyn.robot.kinematics import Motion, Wrench
from robodyn.robot.model import Frame, Joint, Model
from robodyn.solids.inertia.laws import Inertia, symmetric

ROUNDING = 2.0**-48
"""A smaller share of a body's inertia is what rounding leaves of none."""
RESIST = "give a link that it carries mass and inertia, or the joint a rotor"
Back = Callable[[Array, list[Scalar]], None]
"""Finds an unknown of a body, or a coordinate in y, once its x and what was eliminated later is known."""
UNDECIDED = 1e-6
"""Axes with a smaller sine between them count as parallel: they decide no direction."""
AXES = {"fixed": (), "revolute": (2,), "prismatic": (5,), "floating": (0, 1, 2, 3, 4, 5)}
"""The entries of a body's acceleration (wd, a) that each kind of joint adds to, where its axis is z."""
_NEXT, _LAST = np.ix_((1, 2, 0), (1, 2, 0)), np.ix_((2, 0, 1), (2, 0, 1))
"""Matrices with axes y, z, x in the place of x, y, z, and back."""
_UPPER = np.triu_indices(3)
Entries = dict[tuple[int, int], Scalar]
"""Of a symmetric matrix, by (i, j) with i <= j; those left out are zero."""


class Solved(NamedTuple):
    """A coordinate as elimination leaves it: `y = value - V . x - sum coupling y`, x being a body's (wd, a)."""

    value: Scalar
    V: Array
    coupling: Mapping[int, Scalar]

    def rest(self, x: Array, y: list[Scalar]) -> Scalar:
        return self.value - self.V @ x - sum(share * y[other] for other, share in self.coupling.items())


class Elimination:
    """What is left of the equations while unknowns are eliminated from the tips of a tree to its base.

    Body i answers to its acceleration x = (wd, a) by `(n, f) = A x + sum G y + b`, where y are the coordinates that are
    known there only further inward; such a coordinate has the equation `sum G . x + sum D y = u`.

    A: (6, 6) symmetric, b: (6,), G: (6,) by coordinate, of each body with all that it carries; D: by pairs of
    coordinates, at first the rotors; u: by coordinate, at first the forces on it; steps: of each body, in the order of
    elimination.
    """

    def __init__(
        self, A: Sequence[Array], b: Sequence[Array], rotors: Mapping[tuple[int, int], float], forces: Sequence[Scalar]
    ) -> None:
        self.A, self.b, self.u = list(A), list(b), list(forces)
        self.G: list[dict[int, Array]] = [{} for _ in A]
        self.D: defaultdict[tuple[int, int], Scalar] = defaultdict(float)
        self.D.update(rotors)
        self.steps: list[list[Back]] = [[] for _ in A]

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

        def back(x: Array, y: list[Scalar]) -> None:
            x[axis] = x[axis] + ratio * y[rate]

        self.steps[i].append(back)

    def coordinate(self, i: int, rate: int, name: str) -> None:
        """Eliminates a coordinate, all of whose joints body i carries."""
        solved = self._solved(i, rate, name)

        def back(x: Array, y: list[Scalar]) -> None:
            y[rate] = solved.rest(x, y)

        self.steps[i].append(back)

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
        return Solved(inverse * u, V, coupling)

    def axis(self, i: int, axis: int, rate: int, name: str) -> None:
        """Eliminates the motion of body i along an axis by a coordinate of its own. The row and the column of the axis
        become what a rotor leaves of them: without one exactly 0, so that nothing cancels, and six axes in turn are the
        factorisation L D L^T of a free body."""
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

        def back(x: Array, y: list[Scalar]) -> None:
            total = solved.rest(x, y)
            y[rate], x[axis] = total - x[axis], total

        self.steps[i].append(back)


def _pair(k: int, other: int) -> tuple[int, int]:
    return min(k, other), max(k, other)


def unresisted(name: str) -> InputError:
    what = f'joint "{name}" moves nothing that has inertia, so its acceleration is not defined'
    return InputError(what, remedy=RESIST)


def aligned(model: Model) -> Model:
    """Return the same robot with other axes in its bodies; origins stay, and so do q, qd and tau.

    Body i's new axes stand in its old ones as the columns of Q_i: z along its joint, x across this and the axis of the
    first joint that it carries, as Denavit and Hartenberg's. Then `R' = Q_j^T R Q_i` is a turn about x, then about z.
    Accuracy: each number within 16 eps of the largest of its vector or matrix.
    """
    carried: dict[int, Joint] = {}
    for body in model.bodies[1:]:
        if body.joint.kind in ("revolute", "prismatic"):
            carried.setdefault(body.parent, body.joint)
    Q, bodies = [], []
    for i, body in enumerate(model.bodies):
        joint, (m, mc, I) = body.joint, body.inertia
        turn = np.eye(3)  # the axes of a base or a free body stay
        if joint.kind in ("revolute", "prismatic"):
            z, x, first = joint.axis, np.zeros(3), carried.get(i)
            if first is not None:
                x = cross(z, product(first.R, first.axis))
            if length(x) < UNDECIDED:
                x = np.roll(np.eye(3)[int(np.argmax(np.abs(z)))], 1)
            x = x / length(x)
            x = x - z * (z * x).sum()
            x = snapped(x / length(x))
            turn = np.stack((x, cross(z, x), z), axis=1)
        Q.append(turn)
        back = Q[body.parent].T if i else np.eye(3)
        R, axis = snapped(product(back, joint.R, turn)), snapped(product(turn.T, joint.axis))
        joint = replace(joint, R=R, p=product(back, joint.p), axis=axis)
        I = product(turn.T, symmetric(I[_UPPER]), turn)
        bodies.append(replace(body, joint=joint, inertia=Inertia(m, product(turn.T, mc), 0.5 * (I + I.T))))
    links = {name: Frame(i, product(Q[i].T, R), product(Q[i].T, p)) for name, (i, R, p) in model.links.items()}
    return Model(model.name, model.file, tuple(bodies), links, model.notes)


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


def articulated(body: Inertia) -> Array:
    """((I, [m c]), ([m c]^T, m 1)): what takes (wd, a) of a rigid body to the moment and the force (n, f)."""
    H = skew(body.mc)
    return _joined(body.I, H, body.m * np.eye(3))


def _joined(I: Array, H: Array, M: Array) -> Array:
    return np.concatenate((np.concatenate((I, H), 1), np.concatenate((H.T, M), 1)))


def at_parent(A: Array, joint: Joint, R: Array, p: Array) -> Array:
    """Return the same inertia in the axes and about the origin of the parent: I, H and M become `R I R^T` and so on, by
    three turns unless the joint is floating, then `H' = H + [p] M` and `I' = I + [p] H'^T + ([p] H^T)^T`, p being the
    origin from the parent's in the parent's axes."""
    blocks = [A[:3, :3], A[:3, 3:], A[3:, 3:]]
    if joint.kind == "floating":
        I, H, M = (R @ block @ R.T for block in blocks)
    else:
        # turns about z, x and z make R; the first two are constants, being those that bring z to the joint's axis
        sx, cx, z = float(joint.R[0, 2]), -float(joint.R[1, 2]), float(joint.R[2, 2])
        sine = hypot(sx, cx)
        c, s = outer = (cx / sine, sx / sine) if sine else (1.0, 0.0)
        middle, inner = (z, sine), (c * R[0, 0] + s * R[1, 0], -(c * R[0, 1] + s * R[1, 1]))
        blocks = [_about_z(block, *inner) for block in blocks]
        blocks = [_about_z(block[_NEXT], *middle)[_LAST] for block in blocks]  # about x
        I, H, M = (_about_z(block, *outer) for block in blocks)
    shift = skew(p)
    H_p = H + shift @ M
    I_p = symmetric((I + shift @ H_p.T + (shift @ H.T).T)[_UPPER])
    return _joined(I_p, H_p, M)


def _about_z(B: Array, c: Scalar, s: Scalar) -> Array:
    """R B R^T for a turn R about z: the plane's trace and its antisymmetric part stay, the rest turns twice as far."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = B.tolist()
    stretch, shear = xx - yy, xy + yx
    sine2, product = s * s, c * s
    e, g = sine2 * stretch + product * shear, product * stretch - sine2 * shear
    return np.array(
        (
            (xx - e, xy + g, c * xz - s * yz),
            (yx + g, yy + e, s * xz + c * yz),
            (c * zx - s * zy, s * zx + c * zy, zz),
        )
    )


def wrench_at_parent(b: Array, R: Array, p: Array) -> Array:
    """Return the same wrench (n, f) about the parent's origin in the parent's axes: `R n + p x R f`, `R f`."""
    f = R @ b[3:]
    return np.concatenate((R @ b[:3] + cross(p, f), f))


def articulated_body(
    model: Model,
    motions: Sequence[Motion],
    inertias: Sequence[Inertia],
    biases: Sequence[Wrench],
    forces: Sequence[Scalar],
    rotors: Mapping[tuple[int, int], float],
    spins: Sequence[tuple[int, int, Array]] = (),
) -> list[Scalar]:
    """Return how much faster than in `motions` the coordinates accelerate: M^-1 (forces - J^T biases).

    Inward, from the tips to the base, a body answers to an acceleration x = (wd, a) with the wrench `A x + b`. Its
    joint, S being its axis, moves freely: with `U = A S`, `D = S . U + rotor` and `u = force - S . b` its parent feels
    `A - U U^T / D` and `b + U u / D`. Outward, `qdd = (u - U . x) / D`. A coordinate that moves several joints is
    carried inward as a column of its own until a body carries them all, and so is one that a rotor couples with others,
    or with a body whose turning it resists. InputError where nothing resists a joint.

    Source: Featherstone, *Rigid Body Dynamics Algorithms* (2008), table 7.1, velocities being in `biases` alone; shared
        coordinates as in Jain, *Robot and Multibody Dynamics* (2011), ch. 11.

    Args:
        model: of `aligned`. biases: the wrench on each body, in its axes, that `motions` calls for and nothing
            supplies.
        forces: n scalars, those of a floating joint in the body's axes, as is what is returned.
        rotors: reflected inertias, by coordinates i <= j [kg m^2 or kg]. spins: as those of `Terms`.
    """
    A, b = [articulated(body) for body in inertias], [np.concatenate((bias.n, bias.f)) for bias in biases]
    work, joints_of, ends = Elimination(A, b, rotors, forces), *_coordinates(model, rotors, spins)
    for i, rate, moment in spins:
        work.G[i][rate] = work.G[i].get(rate, 0.0) + np.concatenate((moment, ZERO))
    for i, body in reversed(list(enumerate(model.bodies))):
        joint, (R, p, *_) = body.joint, motions[i]
        own = dict(enumerate(AXES[joint.kind], joint.rate))
        for rate in (rate for rate in ends[i] if rate not in own):
            work.coordinate(i, rate, model.rates[rate])
        for rate, axis in own.items():
            if joints_of[rate] == 1:
                work.axis(i, axis, rate, joint.name)
            else:
                work.join(i, axis, rate, joint.multiplier)
                if rate in ends[i]:
                    work.coordinate(i, rate, model.rates[rate])
        if (j := body.parent) >= 0:
            work.A[j] = work.A[j] + at_parent(work.A[i], joint, R, p)
            work.b[j] = work.b[j] + wrench_at_parent(work.b[i], R, p)
            for rate, column in work.G[i].items():
                work.G[j][rate] = work.G[j].get(rate, 0.0) + wrench_at_parent(column, R, p)
    x: list[Array] = []
    y: list[Scalar] = [0.0] * model.n
    for i, (body, (R, p, *_)) in enumerate(zip(model.bodies, motions, strict=True)):
        wd, a = np.split(x[body.parent] if i else np.zeros(6), 2)
        x.append(np.concatenate((R.T @ wd, R.T @ (a + cross(wd, p)))).astype(object))
        for back in reversed(work.steps[i]):
            back(x[i], y)
    return y


def _coordinates(
    model: Model, rotors: Mapping[tuple[int, int], float], spins: Sequence[tuple[int, int, Array]]
) -> tuple[list[int], list[list[int]]]:
    """For each coordinate how many joints move with it, and for each body the shared ones that end there: at the
    outermost body that carries all the joints that they move, and the rotors that spin with them; coordinates that
    rotors couple end together, where a body carries all their joints from below."""
    bodies: dict[int, list[int]] = {}
    for i, body in enumerate(model.bodies):
        for rate, _ in enumerate(AXES[body.joint.kind], body.joint.rate):
            bodies.setdefault(rate, []).append(i)
    ends: list[list[int]] = [[] for _ in model.bodies]
    counts = [len(bodies[rate]) for rate in range(model.n)]
    together = list(range(model.n))  # of each coordinate, the first of those that rotors couple with it
    for (i, j), rotor in rotors.items():
        if i != j and rotor:
            low, high = sorted((together[i], together[j]))
            together = [low if each == high else each for each in together]
    for first in sorted(set(together)):
        group = [rate for rate in range(model.n) if together[rate] == first]
        moved = [i for rate in group for i in bodies[rate]]
        if len(group) > 1:
            moved = [model.bodies[i].parent for i in moved]
        moved += [i for i, rate, _ in spins if rate in group]
        for rate in group if len(moved) > 1 else ():
            counts[rate] = len(moved)
            above = set(moved)
            while len(above) > 1:
                last = max(above)
                above = above - {last} | {model.parents[last]}
            ends[above.pop()].append(rate)
    return counts, ends


def known_zero(value: Scalar) -> bool:
    return isinstance(value, float) and value == 0.0


class Pivot(NamedTuple):
    """An unknown that was eliminated: 1 / sqrt(D), and what it takes of each unknown that is left."""

    unknown: int
    scale: Scalar
    shares: dict[int, Scalar]


class Root:
    """A = C C^T with `C = L sqrt(D)`, in a given order of unknowns, whose names are for messages. InputError if a pivot
    is exactly zero, or a float that is not positive."""

    def __init__(self, entries: Entries, order: Sequence[int], names: Sequence[str]) -> None:
        rows: dict[int, dict[int, Scalar]] = {unknown: {} for unknown in order}
        for (i, j), value in entries.items():
            rows[i][j] = rows[j][i] = value
        self.pivots: list[Pivot] = []
        for unknown in order:
            row = rows.pop(unknown)
            D = row.pop(unknown, 0.0)
            if known_zero(D):
                raise unresisted(names[unknown])
            if isinstance(D, float) and not D > 0.0:
                what = f'joint "{names[unknown]}" moves an inertia of {D:.3g}, so its acceleration is not defined'
                raise InputError(what, remedy="robodyn check finds links with masses and inertias that cannot be")
            inverse = 1.0 / D
            shares = {j: row[j] * inverse for j in sorted(row)}
            for j, share in shares.items():
                own = rows[j]
                del own[unknown]
                for k in (k for k in shares if k >= j):
                    own[k] = rows[k][j] = own.get(k, 0.0) - row[k] * share
            self.pivots.append(Pivot(unknown, sqrt(inverse), shares))

    def inward(self, right: Sequence[Scalar]) -> list[Scalar]:
        """C^-1 right."""
        x = list(right)
        for unknown, scale, shares in self.pivots:
            for j, share in shares.items():
                x[j] = x[j] - share * x[unknown]
            x[unknown] = x[unknown] * scale
        return x

    def outward(self, right: Sequence[Scalar]) -> list[Scalar]:
        """C^-T right."""
        x = list(right)
        for unknown, scale, shares in reversed(self.pivots):
            x[unknown] = scale * x[unknown] - total(share * x[j] for j, share in shares.items())
        return x


def composite_body(
    model: Model, motions: Sequence[Motion], inertias: Sequence[Inertia], rotors: Mapping[tuple[int, int], Scalar]
) -> Entries:
    """M(q) as the entries (i, j), i <= j, that can be other than zero: pairs of joints of which one carries the other.

    Inward, the bodies that a joint carries are one rigid body, A its inertia; a unit acceleration of that joint asks
    for the wrench `F = A S`, which has the entry `M_ij = S_j . F` along the axis of every joint met (Featherstone 2008,
    table 6.2). The model is of `aligned`; a floating joint's entries are along its body's axes. Accuracy: 1e-14 of the
    largest entry.
    """
    A: list[Array] = [articulated(body) for body in inertias]
    entries: Entries = {pair: rotor for pair, rotor in rotors.items() if not known_zero(rotor)}
    for i, body in reversed(list(enumerate(model.bodies))):
        for rate, axis in enumerate(AXES[body.joint.kind], body.joint.rate):
            F, k = A[i][axis] * body.joint.multiplier, i
            while k >= 0:  # what the wrench F about body k does along the axes of the joints from there to the base
                joint = model.bodies[k].joint
                for other, along in enumerate(AXES[joint.kind], joint.rate):
                    share = joint.multiplier * F[along]
                    if k != i:
                        share = share * 2.0 if other == rate else share
                    if not known_zero(share) and (k != i or other >= rate):
                        pair = min(rate, other), max(rate, other)
                        entries[pair] = entries.get(pair, 0.0) + share
                F, k = wrench_at_parent(F, motions[k].R, motions[k].p), model.bodies[k].parent
        if (j := body.parent) >= 0:
            A[j] = A[j] + at_parent(A[i], body.joint, motions[i].R, motions[i].p)
    return entries


def rates_inward(model: Model) -> list[int]:
    """Return all rates, those of the tips first: an order in which M is factorised without further entries."""
    joints = [body.joint for body in reversed(model.bodies)]
    return list(dict.fromkeys(joint.rate + k for joint in joints for k, _ in enumerate(AXES[joint.kind])))
