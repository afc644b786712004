"""The least change that equations ask for: min |y - x| with A^T y = b, by rotations of single entries, for any scalar.

A = Q R by Givens' rotations, row after row of A into R (George and Heath, "Solution of sparse linear least squares
problems using Givens rotations", Lin. Alg. Appl. 34, 1980). Then `y = x + Q R^-T (b - A^T x)`. A^T A is not formed, so
that what rounding does grows with the condition of A and not with its square, which counts where a closed chain passes
a configuration at which its equations depend on each other. R begins as a small multiple of the unit matrix: there the
result is the least-squares one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from robodyn.dynamics.sparse import known_zero, total
from robodyn.spatial import Scalar, sqrt

Rows = list[dict[int, Scalar]]
"""A by its rows: entries by column; those left out are zero."""


class Rotation(NamedTuple):
    """Of row `row` of A with row `column` of R: ((c, s), (-s, c))."""

    row: int
    column: int
    c: Scalar
    s: Scalar


class LeastChange:
    """A = Q R, so far as its entries are not zero."""

    def __init__(self, A: Rows, softness: Sequence[float]) -> None:
        """Args: softness: by column, what the diagonal of R begins with."""
        self.A = [{k: value for k, value in row.items() if not known_zero(value)} for row in A]
        self.order = _order([set(row) for row in self.A], len(softness))
        place = {k: at for at, k in enumerate(self.order)}
        self.R: Rows = [{k: soft} for k, soft in enumerate(softness)]
        self.inverse: list[Scalar] = [1.0 / soft for soft in softness]
        self.rotations: list[Rotation] = []
        filled = [i for i, row in enumerate(self.A) if row]
        for i in sorted(filled, key=lambda i: min(place[k] for k in self.A[i])):
            self._take_in(i, dict(self.A[i]), place)

    def _take_in(self, i: int, row: dict[int, Scalar], place: dict[int, int]) -> None:
        """Rotates a row of A into R until nothing of it is left."""
        while row:
            k = min(row, key=lambda k: place[k])
            R, a = self.R[k], row.pop(k)
            r = sqrt(R[k] * R[k] + a * a)
            inverse = self.inverse[k] = 1.0 / r
            c, s = R[k] * inverse, a * inverse
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
            z[k] = z[k] * self.inverse[k]
            for j in self.R[k].keys() - {k}:
                z[j] = z[j] - self.R[k][j] * z[k]
        change: list[Scalar] = [0.0] * len(x)
        turned = list(z)
        for i, k, c, s in reversed(self.rotations):
            turned[k], change[i] = c * turned[k] - s * change[i], s * turned[k] + c * change[i]
        for k in reversed(self.order):
            rest = total(value * z[j] for j, value in self.R[k].items() if j != k)
            z[k] = (z[k] - rest) * self.inverse[k]
        return [old + more for old, more in zip(x, change, strict=True)], z


def _order(rows: Sequence[set[int]], count: int) -> list[int]:
    """Columns in an order that leaves few entries in R: each time the one that meets the fewest others."""
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
