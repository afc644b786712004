"""Measured torques that are exchanged, have the wrong sign, or are far too large or small."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from robodyn.identification.faults.faults import Evidence
from robodyn.support.floats import Floats, unit_columns

_CLEAR, _LESS = 0.25, 0.7
"""Of the residual's sum of squares with channels as they are, what the right ones leave at most: as geometric mean, and
each of them."""
_FAR = 10.0
"""Measured torques that are so many times the computed ones, or so small a part of them, are doubtful."""


class Channels(NamedTuple):
    """For each joint the channel that has its torque, and with which sign, 1 or -1."""

    source: tuple[int, ...]
    sign: tuple[int, ...]

    @property
    def exchanged(self) -> list[tuple[int, ...]]:
        """The joints that have each other's torques: in each group each of the next, the last of the first."""
        left, found = [j for j, source in enumerate(self.source) if source != j], []
        while left:
            group = [left[0]]
            while self.source[group[-1]] != group[0]:
                group.append(self.source[group[-1]])
            found.append(tuple(group))
            left = [j for j in left if j not in group]
        return found

    @property
    def reversed(self) -> list[int]:
        return [j for j, sign in enumerate(self.sign) if sign < 0]

    @property
    def faults(self) -> list[tuple[int, ...]]:
        """The joints of each fault, as `words` has them."""
        return [*self.exchanged, *((j,) for j in self.reversed)]

    def words(self, names: Sequence[str]) -> list[str]:
        return [
            f"the measured torques of {', '.join(names[j] for j in first)} and {names[last]} are exchanged"
            if first
            else f"the measured torque of {names[last]} has the wrong sign"
            for *first, last in self.faults
        ]


def channels(evidence: Evidence) -> Channels:
    parts = zip(evidence.own.swapaxes(0, 1), evidence.computed.T, strict=True)
    return told([np.column_stack((own, computed, evidence.measured)) for own, computed in parts])


def rerouted(evidence: Evidence, right: Channels) -> Evidence:
    """Return evidence whose measured torques are those of the right channels."""
    return replace(evidence, measured=evidence.measured[:, list(right.source)] * np.array(right.sign, dtype=float))


def told(rows: Sequence[Floats]) -> Channels:
    """Return which measured torque is that of which joint, and with which sign.

    Each measured torque is correlated with each computed one, with either sign, beside friction and rotor inertia,
    which cannot be negative. Channels are those for which the product of what is left is least (assignment problem).
    They differ from those of the log only where they leave less than `_CLEAR` of what the joints' own channels leave
    with their better signs, and a sign only where it does so beside the other one.

    Args:
        rows: of each joint (k, 4 + n), or their triangular factor: torques per unit of its viscous friction, Coulomb
            friction and rotor inertia, its computed torque, and all n measured ones.
    """
    from scipy.optimize import linear_sum_assignment

    n = len(rows)
    cost = np.empty((n, n, 2))
    for i, each in enumerate(rows):
        factor = np.asarray(np.linalg.qr(each, mode="r"))
        size = (factor * factor).sum(axis=0)
        for j in range(n):
            least = 1e-12 * (size[3] + size[4 + j]) + 1e-300
            lefts = [_fitted(factor[:, :3], sign * factor[:, 4 + j] - factor[:, 3])[1] for sign in (1.0, -1.0)]
            cost[i, j] = np.array(lefts) + least
    best, own = cost.min(axis=2), np.arange(n)
    source = linear_sum_assignment(np.log(best))[1]
    found = own.copy()
    for group in map(list, Channels(tuple(map(int, source)), ()).exchanged):
        ratio = best[group, source[group]] / best[group, group]
        if np.log(ratio).mean() < np.log(_CLEAR) and (ratio < _LESS).all():
            found[group] = source[group]
    plus, minus = cost[own, found].T
    sign = np.where(minus < _CLEAR * plus, -1, 1)
    return Channels(tuple(map(int, found)), tuple(map(int, sign)))


def magnitudes(rows: Sequence[Floats], names: Sequence[str]) -> list[str]:
    """Return a line if measured torques are a multiple of the computed ones that masses seldom make.

    Beside friction and rotor inertia the computed torque is fitted with a factor, which counts if it leaves less than
    `_CLEAR` of what is left without. Rows are those of `told`.
    """
    far = []
    for j, (each, name) in enumerate(zip(rows, names, strict=True)):
        factor = np.asarray(np.linalg.qr(each, mode="r"))
        own, computed = factor[:, 4 + j], factor[:, 3]
        values, left = _fitted(factor[:, :4], own)
        gain = float(values[3])
        if left < _CLEAR * _fitted(factor[:, :3], own - computed)[1] and gain > 0.0 and not 1 / _FAR < gain < _FAR:
            far.append(f"{gain:.2g} ({name})")
    what = f"measured torques are {', '.join(far)} times what the description makes beside friction"
    return [f"{what}: is their unit another, or a gear?"] if far else []


def _fitted(columns: Floats, right: Floats) -> tuple[Floats, float]:
    """Return the values of columns, none of them negative, and what they leave of the squares."""
    from scipy.optimize import nnls

    unit, lengths = unit_columns(columns)
    values, left = nnls(unit, right)
    return np.asarray(values / lengths), float(left) ** 2
