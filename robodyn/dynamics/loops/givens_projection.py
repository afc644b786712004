"""The least change that equations ask for: min |y - x| with A^T y = b, by rotations of single entries, for any scalar.

A = Q R by Givens' rotations, row after row of A into R (George and Heath, "Solution of sparse linear least squares
problems using Givens rotations", Lin. Alg. Appl. 34, 1980). Then `y = x + Q R^-T (b - A^T x)`. A^T A is not formed, so
that what rounding does grows with the condition of A and not with its square, which counts where a closed chain passes
a configuration at which its equations depend on each other. There an entry r of R's diagonal vanishes; its inverse is
taken for `r / (r^2 + soft^2)`, so that the equation that it belongs to asks for nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from robodyn.dynamics.recursions.composite_body import known_zero
from robodyn.programs.vectors import Scalar, sqrt, total

Rows = list[dict[int, Scalar]]
"""A by its rows: entries by column; those left out are zero."""
NUDGE = 1e-150
"""Keeps a rotation of nothing against nothing the one by no angle; its square is still a number."""


class Rotation(NamedTuple):
    """Of row `row` of A with row `column` of R: ((c, s), (-s, c))."""

    row: int
    column: int
    c: Scalar
    s: Scalar


class GivensProjection:
    """A = Q R, so far as its entries are not zero."""

    def __init__(self, A: Rows, softness: Sequence[float]) -> None:
        """Args: softness: by column."""
        self.A = [{k: value for k, value in row.items() if not known_zero(value)} for row in A]
        self.order = _order([set(row) for row in self.A], len(softness))
        place = {k: at for at, k in enumerate(self.order)}
        self.R: dict[int, dict[int, Scalar]] = {}
        self.rotations: list[Rotation] = []
        filled = [i for i, row in enumerate(self.A) if row]
        for i in sorted(filled, key=lambda i: min(place[k] for k in self.A[i])):
            self._take_in(i, dict(self.A[i]), place)
        self.inverse = {k: R[k] / (R[k] * R[k] + softness[k] ** 2) for k, R in self.R.items()}

    def _take_in(self, i: int, row: dict[int, Scalar], place: dict[int, int]) -> None:
        """Rotates a row of A into R until it fills a row of R that is empty, or nothing of it is left."""
        while row:
            k = min(row, key=lambda k: place[k])
            if k not in self.R:
                self.R[k] = row
                self.rotations.append(Rotation(i, k, 0.0, 1.0))
                return
            R, a = self.R[k], row.pop(k)
            top = R[k] + NUDGE
            r = sqrt(top * top + a * a)
            inverse = 1.0 / r
            c, s = top * inverse, a * inverse
            R[k] = r
            for j in sorted((R.keys() | row.keys()) - {k}):
                upper, lower = R.get(j, 0.0), row.get(j, 0.0)
                R[j], row[j] = c * upper + s * lower, c * lower - s * upper
            self.rotations.append(Rotation(i, k, c, s))

    def solve(self, x: Sequence[Scalar], b: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """y, and lambda of `y = x + A lambda`."""
        z = list(b)
        for i, row in enumerate(self.A):
            for k, value in row.items():
                z[k] = z[k] - value * x[i]
        for k in self.order:
            z[k] = z[k] * self.inverse.get(k, 0.0)
            for j, value in self.R.get(k, {}).items():
                if j != k:
                    z[j] = z[j] - value * z[k]
        change: list[Scalar] = [0.0] * len(x)
        turned = list(z)
        for i, k, c, s in reversed(self.rotations):
            turned[k], change[i] = c * turned[k] - s * change[i], s * turned[k] + c * change[i]
        for k in reversed(self.order):
            rest = total(value * z[j] for j, value in self.R.get(k, {}).items() if j != k)
            z[k] = (z[k] - rest) * self.inverse.get(k, 0.0)
        return [old + more for old, more in zip(x, change, strict=True)], z


def _order(rows: Sequence[set[int]], count: int) -> list[int]:
    """Return columns in an order that leaves few entries in R: each time the one that meets the fewest others."""
    meets: dict[int, set[int]] = {k: set() for k in range(count)}
    for row in rows:
        for k in row:
            meets[k] |= row - {k}
    order = []
    while meets:
        k = min(meets, key=lambda k: (len(meets[k]), k))
        others = meets.pop(k)
        for j in others:
            meets[j] = (meets[j] | others) - {j, k}
        order.append(k)
    return order
