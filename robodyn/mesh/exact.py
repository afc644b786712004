"""Moments of volume without any rounding."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import NamedTuple

import numpy as np

from robodyn.mesh.residues import Residues
from robodyn.mesh.triangles import Triangles
from robodyn.spatial import Array, Scalar

_LIMB = 26
"""Bits of the parts into which a coordinate is cut."""

_RESIDUES, _MOST_ROWS, _LEAST_ROWS = 8192, 1024, 32
"""Triangles times moduli that are worked on at a time, and limits of the triangles; see `MODULUS_BITS` for the most."""

_LOWEST = -1074


class Moments(NamedTuple):
    """Integrals over a volume of 1, x - r and (x - r)(x - r)^T about a point of reference r, as fractions."""

    volume: Scalar
    first: Array
    second: Array


def exact_moments(triangles: Triangles, reference: Array, lo: Array, hi: Array) -> Moments:
    """The moments of the volume within triangles whose coordinates are taken as exact.

    The sums of `robodyn.mesh.kernel`, in integers: coordinates are multiples of a common power of two. The
    integers are computed by their residues, because arrays of these are much faster than long integers.

    Args:
        reference: (3,) floats, in units of the file.
        lo, hi: (3,) corners of a box around the triangles and the reference.
    """
    from fractions import Fraction

    grid = _Grid.of(triangles, reference)
    unit = Fraction(2) ** grid.lowest
    longest = ceil(max(Fraction(b) - Fraction(a) for a, b in zip(lo.tolist(), hi.tolist(), strict=True)) / unit)
    ring = Residues(300 * triangles.count * longest**5)
    sums = _Sums(ring, grid, [int(Fraction(r) / unit) for r in reference.tolist()])
    for block in triangles.blocks():
        for start in range(0, len(block), sums.rows):
            sums.add(block[start : start + sums.rows])
    volume, *rest = (ring.integer(residues) for residues in sums.total.T.tolist())
    table = np.array([Fraction(number) for number in rest]).reshape(3, 4)
    return Moments(volume * unit**3 / 6, table[:, 3] * unit**4 / 48, table[:, :3] * unit**5 / 120)


@dataclass(frozen=True)
class _Grid:
    """All coordinates are multiples of 2^lowest and made of `limbs` parts."""

    lowest: int
    limbs: int

    @classmethod
    def of(cls, triangles: Triangles, reference: Array) -> _Grid:
        bounds = [_exponents(block) for block in (reference, *triangles.blocks())]
        lowest = max(min(low for low, _ in bounds), _LOWEST)
        highest = max(high for _, high in bounds)
        return cls(lowest, max(-(-(highest - lowest) // _LIMB), 1))

    def parts(self, numbers: Array) -> Array:
        """(limbs, ...) integers c_k of at most 2^26 with numbers = 2^lowest sum c_k 2^(26 k)."""
        parts = np.empty((self.limbs, *numbers.shape))
        rest = numbers.astype(np.float64)
        for k in reversed(range(self.limbs)):
            place = self.lowest + _LIMB * k
            np.rint(_scaled(rest, -place), parts[k])
            rest -= _scaled(parts[k], place)
        return parts


def _exponents(numbers: Array) -> tuple[int, int]:
    """Numbers that are not zero are multiples of 2^low and below 2^high."""
    wide = numbers.astype(np.float64)
    with np.errstate(over="ignore"):
        digits = 24 if (wide == wide.astype(np.float32)).all() else 53
    _, exponents = np.frexp(wide[wide != 0])
    return (int(exponents.min()) - digits, int(exponents.max())) if exponents.size else (0, 0)


def _scaled(numbers: Array, exponent: int) -> Array:
    """numbers 2^exponent, in two steps that stay in the range of a float."""
    half = exponent // 2
    scaled: Array = numbers * 2.0**half * 2.0 ** (exponent - half)
    return scaled


class _Sums:
    """Residues of 6 V and of the table [120 S, 48 first], in the unit of the grid; see `robodyn.mesh.kernel`."""

    def __init__(self, ring: Residues, grid: _Grid, reference: list[int]) -> None:
        self.ring = ring
        self.rows = min(max(_RESIDUES // ring.count, _LEAST_ROWS), _MOST_ROWS)
        self.total = np.zeros((ring.count, 13))
        self._grid = grid
        self._reference = np.stack([ring.of(r) for r in reference], axis=1)[:, :, None, None]
        self._places = [ring.of(1 << (_LIMB * k))[:, None, None, None] for k in range(grid.limbs)]

    def add(self, corners: Array) -> None:
        """Add triangles (n, 3 corners, 3 coordinates), n <= rows."""
        ring = self.ring
        X = -self._reference
        for part, place in zip(self._grid.parts(corners.transpose(2, 1, 0)), self._places, strict=True):
            X = X + part * place
        spare = np.empty_like(X)
        ring.reduce(X, spare)
        e, f = X[:, :, 1] - X[:, :, 0], X[:, :, 2] - X[:, :, 0]
        normal = np.stack([e[:, i - 2] * f[:, i - 1] - e[:, i - 1] * f[:, i - 2] for i in range(3)], axis=1)
        ring.reduce(normal, spare[:, :, 0])
        D = (normal * X[:, :, 0]).sum(axis=1)
        ring.reduce(D, spare[:, 0, 0])
        u = np.ones((ring.count, 4, *X.shape[2:]))
        np.add(X, X[:, :, [1, 2, 0]], u[:, :3])
        weighted = u[:, :3] * D[:, None, None, :]
        ring.reduce(weighted, spare)
        table = weighted.reshape(ring.count, 3, -1) @ u.reshape(ring.count, 4, -1).transpose(0, 2, 1)
        sums = np.concatenate([D.sum(axis=1, keepdims=True), table.reshape(ring.count, 12)], axis=1)
        ring.reduce(sums, np.empty_like(sums))
        self.total += sums
