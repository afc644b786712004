"""The mass matrix by composite rigid bodies (CRBA), entry by entry, and its sparse factors, for any scalar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from robodyn.dynamics.recursions.articulated_body import AXES, articulated, at_parent, turns_of, wrench_at_parent
from robodyn.dynamics.recursions.elimination import indefinite, unresisted
from robodyn.programs.vectors import Array, Scalar, sqrt, total
from robodyn.robot.kinematics import Motion
from robodyn.robot.model import Model
from robodyn.solids.inertia.laws import Inertia

Entries = dict[tuple[int, int], Scalar]
"""Of a symmetric matrix, by (i, j) with i <= j; those left out are zero."""


def add_entry(entries: Entries, i: int, j: int, value: Scalar) -> None:
    """Adds to the entry (i, j), or (j, i); a zero that is known beforehand is left out."""
    if not known_zero(value):
        place = (i, j) if i <= j else (j, i)
        entries[place] = entries.get(place, 0.0) + value


def known_zero(value: Scalar) -> bool:
    return isinstance(value, float) and value == 0.0


class Pivot(NamedTuple):
    """An unknown that was eliminated: 1 / sqrt(D), and what it takes of each unknown that is left."""

    unknown: int
    scale: Scalar
    shares: dict[int, Scalar]


class Root:
    """A = C C^T with `C = L sqrt(D)`, in a given order of unknowns."""

    def __init__(self, entries: Entries, order: Sequence[int], names: Sequence[str]) -> None:
        """Raise InputError if a pivot is exactly zero, or a float that is not positive; `names` are of the unknowns."""
        rows: dict[int, dict[int, Scalar]] = {unknown: {} for unknown in order}
        for (i, j), value in entries.items():
            rows[i][j] = rows[j][i] = value
        self.pivots = [_eliminated(unknown, rows, names) for unknown in order]

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


def _eliminated(unknown: int, rows: dict[int, dict[int, Scalar]], names: Sequence[str]) -> Pivot:
    """Takes an unknown out of the rows that are left."""
    row = rows.pop(unknown)
    D = row.pop(unknown, 0.0)
    if known_zero(D):
        raise unresisted(names[unknown])
    if isinstance(D, float) and not D > 0.0:
        raise indefinite(names[unknown], D)
    inverse = 1.0 / D
    shares = {j: row[j] * inverse for j in sorted(row)}
    for j, share in shares.items():
        own = rows[j]
        del own[unknown]
        for k in (k for k in shares if k >= j):
            own[k] = rows[k][j] = own.get(k, 0.0) - row[k] * share
    return Pivot(unknown, sqrt(inverse), shares)


def composite_body(
    model: Model, motions: Sequence[Motion], inertias: Sequence[Inertia], rotors: Mapping[tuple[int, int], Scalar]
) -> Entries:
    """M(q) as the entries (i, j), i <= j, that can be other than zero: pairs of joints of which one carries the other.

    Inward, the bodies that a joint carries are one rigid body, A its inertia; a unit acceleration of that joint asks
    for the wrench `F = A S`, and carried on inward F has the entry `M_ij = S_j . F` along the axis of every joint met.

    Source: Featherstone, *Rigid Body Dynamics Algorithms* (2008), table 6.2. The model is of `aligned`; a floating
    joint's entries are along its body's axes. Accuracy: 1e-14 of the largest entry.
    """
    A: list[Array] = [articulated(body) for body in inertias]
    entries: Entries = {pair: rotor for pair, rotor in rotors.items() if not known_zero(rotor)}
    for i, body in reversed(list(enumerate(model.bodies))):
        for rate, axis in enumerate(AXES[body.joint.kind], body.joint.rate):
            _column(entries, model, motions, i, rate, A[i][axis] * body.joint.multiplier)
        if (j := body.parent) >= 0:
            A[j] = A[j] + at_parent(A[i], turns_of(body.joint, motions[i].R), motions[i].p)
    return entries


def rates_inward(model: Model) -> list[int]:
    """Return all rates, those of the tips first: an order in which M is factorised without further entries."""
    inward = reversed(model.bodies)
    return list(
        dict.fromkeys(joint.rate + k for joint in (b.joint for b in inward) for k in range(len(AXES[joint.kind])))
    )


def _column(entries: Entries, model: Model, motions: Sequence[Motion], i: int, rate: int, F: Array) -> None:
    """Adds what the wrench F about body i does along the axes of the joints from body i to the base."""
    own = True
    while i >= 0:
        joint = model.bodies[i].joint
        for other, axis in enumerate(AXES[joint.kind], joint.rate):
            share = joint.multiplier * F[axis]
            if own:
                if other >= rate:
                    add_entry(entries, rate, other, share)
            else:
                add_entry(entries, rate, other, share * 2.0 if other == rate else share)
        F, own, i = wrench_at_parent(F, motions[i].R, motions[i].p), False, model.bodies[i].parent
