"""Symmetric positive definite equations of which most entries are zero, factorised entry by entry, for any scalar."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from robodyn.programs.vectors import Scalar, sqrt

Entries = dict[tuple[int, int], Scalar]
"""Of a symmetric matrix, by (i, j) with i <= j; those left out are zero."""


def add_entry(entries: Entries, i: int, j: int, value: Scalar) -> None:
    """Adds to the entry (i, j), or (j, i); a zero that is known beforehand is left out."""
    if not known_zero(value):
        place = (i, j) if i <= j else (j, i)
        entries[place] = entries.get(place, 0.0) + value


def known_zero(value: Scalar) -> bool:
    return isinstance(value, float) and value == 0.0


class SingularError(ArithmeticError):
    """A pivot is exactly zero; `unknown` says which."""

    def __init__(self, unknown: int) -> None:
        super().__init__(f"unknown {unknown} has no equation")
        self.unknown = unknown


class Pivot(NamedTuple):
    """An unknown that was eliminated: 1 / sqrt(D), and what it takes of each unknown that is left."""

    unknown: int
    scale: Scalar
    shares: dict[int, Scalar]


class Root:
    """A = C C^T with `C = L sqrt(D)`, in a given order of unknowns."""

    def __init__(self, entries: Entries, order: Sequence[int]) -> None:
        """
        Args:
            entries: of A; order: of all its unknowns.

        Raises:
            SingularError: a pivot is zero.
        """
        rows: dict[int, dict[int, Scalar]] = {unknown: {} for unknown in order}
        for (i, j), value in entries.items():
            rows[i][j] = rows[j][i] = value
        self.pivots = [_eliminated(unknown, rows) for unknown in order]

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


def _eliminated(unknown: int, rows: dict[int, dict[int, Scalar]]) -> Pivot:
    """Takes an unknown out of the rows that are left."""
    row = rows.pop(unknown)
    D = row.pop(unknown, 0.0)
    if known_zero(D):
        raise SingularError(unknown)
    inverse = 1.0 / D
    shares = {j: row[j] * inverse for j in sorted(row)}
    for j, share in shares.items():
        own = rows[j]
        del own[unknown]
        for k in (k for k in shares if k >= j):
            own[k] = rows[k][j] = own.get(k, 0.0) - row[k] * share
    return Pivot(unknown, sqrt(inverse), shares)


def total(values: Iterable[Scalar]) -> Scalar:
    """Their sum, 0.0 for none."""
    out: Scalar = 0.0
    for value in values:
        out = out + value
    return out
