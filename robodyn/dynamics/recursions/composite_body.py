"""The mass matrix by composite rigid bodies (CRBA), entry by entry, and its sparse factors, for any scalar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from robodyn.dynamics.recursions.articulated_body import AXES, articulated, at_parent, unresisted, wrench_at_parent
from robodyn.errors import InputError
from robodyn.programs.vectors import Array, Scalar, sqrt, total
from robodyn.robot.kinematics import Motion
from robodyn.robot.model import Model
from robodyn.solids.inertia.laws import Inertia

Entries = dict[tuple[int, int], Scalar]
"""Of a symmetric matrix, by (i, j) with i <= j; those left out are zero."""


def known_zero(value: Scalar) -> bool:
    return isinstance(value, float) and value == 0.0


class Pivot(NamedTuple):
    """An unknown that was eliminated: 1 / sqrt(D), and what it takes of each unknown that is left."""

    unknown: int
    scale: Scalar
    shares: dict[int, Scalar]


class Root:
    """A = C C^T with `C = L sqrt(D)`, in a given order of unknowns. InputError if a pivot is exactly zero, or a float
    that is not positive; `names` are of the unknowns."""

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
    for the wrench `F = A S`, and carried on inward F has the entry `M_ij = S_j . F` along the axis of every joint met.

    Source: Featherstone, *Rigid Body Dynamics Algorithms* (2008), table 6.2. The model is of `aligned`; a floating
    joint's entries are along its body's axes. Accuracy: 1e-14 of the largest entry.
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
