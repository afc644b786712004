"""Exact arithmetic on arrays of integers of any size: by their residues for several moduli, kept in float64.

A float64 holds integers up to 2^53 exactly, and so does every sum and product below that. Sums and products of residues
are residues of sums and products; from enough of them the Chinese remainder theorem gives the integer back.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import gcd, prod

import numpy as np

from robodyn.spatial import Array

MODULUS_BITS = 21
"""Bits of the largest modulus: residues are at most half of it, and 4096 products of a residue with the sum of two
residues add up to less than 2^53."""


class Residues:
    """Moduli without common factors, whose product exceeds any given bound."""

    def __init__(self, bound: int) -> None:
        """
        Args:
            bound: the integers to be found are at most as large, and of either sign.
        """
        self.moduli: list[int] = []
        product, candidate = 1, (1 << MODULUS_BITS) - 1
        while product <= 2 * bound + 1:
            if gcd(candidate, product) == 1:
                self.moduli.append(candidate)
                product *= candidate
            candidate -= 2
        self.count = len(self.moduli)
        self._columns = {d: np.array(self.moduli, float).reshape(-1, *[1] * (d - 1)) for d in range(1, 5)}
        self._inverses = {d: 1.0 / column for d, column in self._columns.items()}

    def reduce(self, numbers: Array, spare: Array) -> None:
        """Replace integers below 2^53 by their residues nearest to zero, in place.

        Args:
            numbers: (count, ...) one row per modulus, of 1 to 4 dimensions.
            spare: of the same shape; overwritten.
        """
        np.multiply(numbers, self._inverses[numbers.ndim], spare)
        np.rint(spare, spare)
        np.multiply(spare, self._columns[numbers.ndim], spare)
        np.subtract(numbers, spare, numbers)

    def of(self, number: int) -> Array:
        """(count,) residues of an integer, nearest to zero."""
        return np.array([(number + m // 2) % m - m // 2 for m in self.moduli], float)

    def integer(self, residues: Sequence[float]) -> int:
        """The integer with these residues, one per modulus, by the Chinese remainder theorem."""
        product = prod(self.moduli)
        total = 0
        for residue, m in zip(residues, self.moduli, strict=True):
            rest = product // m
            total += int(residue) * pow(rest, -1, m) % m * rest
        total %= product
        return total - product if 2 * total > product else total
