"""Moments of volume without any rounding."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from math import ceil
from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import Array, Scalar
from robodyn.solids.mesh.blocks import block_space, fill
from robodyn.solids.mesh.integrate.kernel import symmetric
from robodyn.solids.mesh.integrate.residues import Field, integer, moduli_for, residue, residue_kernel
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.floats import Floats

_LIMB = 26
"""Bits of the parts into which a coordinate is cut."""

_LOWEST = -1074

_PER_WIDTH = 24
"""In a box of width 1 tetrahedra have 6 V <= 2, and three products of two sums of two coordinates add up to 12."""


class Moments(NamedTuple):
    """Integrals over a volume of 1, x - r and (x - r)(x - r)^T about a point of reference r, as fractions."""

    volume: Scalar
    first: Array
    second: Array


@dataclass(frozen=True, eq=False)
class VolumeIntegrals:
    """Integrals over a volume, in units of the file.

    Attributes:
        volume: V, of 1.
        first: (3,) of x - reference.
        S: (3, 3) of (x - reference)(x - reference)^T.
        reference: (3,).
    """

    volume: float
    first: Floats
    S: Floats
    reference: Floats

    @property
    def moments(self) -> Moments:
        """Volume, first and S with all that is known of their digits."""
        return Moments(self.volume, self.first, self.S)


def exact_moments(triangles: Triangles, reference: Array, lo: Array, hi: Array) -> Moments:
    """Return the moments of the volume within triangles whose coordinates are taken as exact.

    The sums of `volume_kernel`, in integers, because coordinates are multiples of a common power of two.

    Args:
        reference: (3,) floats, in units of the file.
        lo, hi: (3,) corners of a box around the triangles and the reference.
    """
    from fractions import Fraction

    grid = _Grid.of(triangles, reference)
    unit = Fraction(2) ** grid.lowest
    width = ceil(max(Fraction(b) - Fraction(a) for a, b in zip(lo.tolist(), hi.tolist(), strict=True)) / unit)
    moduli = moduli_for(_PER_WIDTH * triangles.count * width**5)
    totals = _residues(triangles, grid, [int(Fraction(r) / unit) for r in reference.tolist()], moduli)
    volume, *sums = (integer(residues, moduli) for residues in totals.T.tolist())
    first, second = np.array([Fraction(x) for x in sums[:3]]), np.array([Fraction(x) for x in sums[3:]])
    return Moments(volume * unit**3 / 6, first * unit**4 / 24, symmetric(second * unit**5 / 120))


def _residues(triangles: Triangles, grid: _Grid, reference: list[int], moduli: list[int]) -> Array:
    """(moduli, 10) of 6 V, 24 first and 120 S in the unit of the grid."""
    space = block_space(triangles)
    parts = np.empty((grid.limbs, *space[:3].shape))
    field = Field(grid.limbs)
    steps, result = residue_kernel(parts, field)
    units = [[residue(1 << (_LIMB * k), m) for k in range(grid.limbs)] for m in moduli]
    references = [[residue(r, m) for r in reference] for m in moduli]
    totals = np.zeros((len(moduli), len(result)))
    for X in fill(space, triangles):
        grid.cut(X, parts)
        for i, modulus in enumerate(moduli):
            field.choose(modulus, units[i], references[i])
            for function, arguments in steps:
                function(*arguments)
            totals[i] += result
    return totals


@dataclass(frozen=True)
class _Grid:
    """All coordinates are multiples of 2^lowest and made of `limbs` parts."""

    lowest: int
    limbs: int

    @classmethod
    def of(cls, triangles: Triangles, reference: Array) -> _Grid:
        bounds = [_exponents(block) for block in chain((reference,), triangles.blocks())]
        lowest = max(min(low for low, _ in bounds), _LOWEST)
        highest = max(high for _, high in bounds)
        return cls(lowest, max(-(-(highest - lowest) // _LIMB), 1))

    def cut(self, numbers: Array, parts: Array) -> None:
        """Find integers c_k of at most 2^26 with numbers = 2^lowest sum c_k 2^(26 k).

        Args:
            numbers: lost; parts: (limbs, ...).
        """
        for k in reversed(range(self.limbs)):
            place = self.lowest + _LIMB * k
            np.rint(_scaled(numbers, -place), parts[k])
            numbers -= _scaled(parts[k], place)


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
