"""Integers of any size by their residues for several moduli.

A float64 holds integers up to 2^53 exactly, and so does every sum and product below that. Sums and products of residues
are residues of sums and products; from enough of them the Chinese remainder theorem gives the integer back. Arrays of
residues are much faster than arrays of long integers.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import gcd, prod

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
    """The residue nearest to zero."""
    half = modulus // 2
    return (number + half) % modulus - half


def integer(residues: Iterable[float], moduli: list[int]) -> int:
    """The integer nearest to zero with these residues, by the Chinese remainder theorem."""
    product = prod(moduli)
    total = 0
    for rest, modulus in zip(residues, moduli, strict=True):
        others = product // modulus
        total += int(rest) * pow(others, -1, modulus) % modulus * others
    return residue(total, product)
