"""Integers of any size by their residues for several moduli.

A float64 holds integers up to 2^53 exactly, and so does every sum and product below that. Sums and products of residues
are residues of sums and products; from enough of them the Chinese remainder theorem gives the integer back. Arrays of
residues are much faster than arrays of long integers.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import gcd, prod

import numpy as np

from robodyn.programs.vectors import Array
from robodyn.solids.mesh.blocks import CHUNK, Step, workspace
from robodyn.solids.mesh.integrate.kernel import PAIRS, cross_steps

MODULUS_BITS = 20
"""Bits of the largest modulus: residues are at most half of it, and 2^14 products of a residue with the sum of two
residues add up to at most 2^53."""


def moduli_for(bound: int) -> list[int]:
    """Odd numbers without common factors whose residues tell apart all integers up to the bound, of either sign."""
    found: list[int] = []
    product, candidate = 1, (1 << MODULUS_BITS) - 1
    while product <= 2 * bound + 1:
        if gcd(candidate, product) == 1:
            found.append(candidate)
            product *= candidate
        candidate -= 2
    return found


def residue(number: int, modulus: int) -> int:
    """Return the residue nearest to zero."""
    half = modulus // 2
    return (number + half) % modulus - half


def integer(residues: Iterable[float], moduli: list[int]) -> int:
    """Return the integer nearest to zero with these residues, by the Chinese remainder theorem."""
    product = prod(moduli)
    total = 0
    for rest, modulus in zip(residues, moduli, strict=True):
        others = product // modulus
        total += int(rest) * pow(others, -1, modulus) % modulus * others
    return residue(total, product)


class Field:
    """A modulus that can be changed, and what makes residues of integers below 2^53."""

    def __init__(self, limbs: int) -> None:
        """
        Args:
            limbs: parts of a coordinate.
        """
        self._modulus, self._inverse = np.empty(()), np.empty(())
        self.places = np.empty((limbs, 1))
        self.reference = np.empty((3, 1))

    def choose(self, modulus: int, places: Sequence[int], reference: Sequence[int]) -> None:
        """Take a modulus, with the residues of the places of parts and of the point of reference."""
        self._modulus[...] = modulus
        self._inverse[...] = 1.0 / modulus
        self.places[:, 0] = places
        self.reference[:, 0] = reference

    def reduce(self, numbers: Array, spare: Array) -> list[Step]:
        """Replace numbers by their residues nearest to zero."""
        return [
            (np.multiply, (numbers, self._inverse, spare)),
            (np.rint, (spare, spare)),
            (np.multiply, (spare, self._modulus, spare)),
            (np.subtract, (numbers, spare, numbers)),
        ]


def residue_kernel(parts: Array, field: Field) -> tuple[list[Step], Array]:
    """Steps, and where they put integers with the residues of 6 V, 24 first (3) and 120 S (6) of the present block.

    Args:
        parts: (limbs, 3 corners, 3 coordinates, n) integers up to 2^26 with 3 n <= 2^14: coordinates are sums of parts
            times places.
    """
    n = parts.shape[-1]
    corners, spare, weighted, normal, weights = (workspace(rows, n) for rows in (12, 12, 9, 3, 1))
    X, sums, third, D = corners[:9].reshape(3, 3, n), corners[3:].reshape(3, 3, n), corners[9:], weights[0]
    a, b, c = X
    products, result = weighted.reshape(3, 3, n), np.empty(10)
    dots_first, first = _dots(normal.reshape(3, 1, n), weights.reshape(1, 1, n), [(i, 0) for i in range(3)])
    dots_second, second = _dots(products.swapaxes(0, 1), sums.swapaxes(0, 1), PAIRS)
    return [
        *_combined(parts, field, X, spare[:9].reshape(3, 3, n)),
        *field.reduce(corners[:9], spare[:9]),
        *cross_steps(X, spare, normal),
        *field.reduce(normal, spare[:3]),
        (np.multiply, (normal, a, normal)),
        (np.add, (normal[0], normal[1], D)),
        (np.add, (D, normal[2], D)),
        *field.reduce(D, spare[0]),
        (np.add.reduce, (D, None, None, result[0, ...])),
        (np.add, (a, b, third)),
        (np.add, (third, c, normal)),
        *dots_first,
        (np.add.reduce, (first, 1, None, result[1:4])),
        (np.add, (b, c, b)),
        (np.add, (c, a, c)),
        (np.multiply, (sums, D, products)),
        *field.reduce(weighted, spare[:9]),
        *dots_second,
        (np.add.reduce, (second, 1, None, result[4:])),
    ], result


def _combined(parts: Array, field: Field, X: Array, spare: Array) -> list[Step]:
    """X = sum of parts times places - reference."""
    steps: list[Step] = [(np.multiply, (parts[0], field.places[0], X)), (np.subtract, (X, field.reference, X))]
    for part, place in zip(parts[1:], field.places[1:], strict=True):
        steps += [(np.multiply, (part, place, spare)), (np.add, (X, spare, X))]
    return steps


def _dots(rows: Array, columns: Array, pairs: Sequence[tuple[int, int]]) -> tuple[list[Step], Array]:
    """Dot products of pairs of rows and columns, a chunk at a time.

    Args:
        rows, columns: (k, parts, n); a pair has an index of each.

    Returns:
        The steps, and where they put their results, (pairs, parts n / CHUNK).
    """
    chunks = rows.shape[-1] // CHUNK
    results = np.empty((len(pairs), rows.shape[1], chunks, 1, 1), rows.dtype)
    across = rows.reshape(*rows.shape[:2], chunks, 1, CHUNK)
    down = columns.reshape(*columns.shape[:2], chunks, CHUNK, 1)
    steps: list[Step] = [(np.matmul, (across[i], down[j], out)) for (i, j), out in zip(pairs, results, strict=True)]
    return steps, results.reshape(len(pairs), -1)
