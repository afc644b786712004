"""Long integers by residues, against Python's own."""

from __future__ import annotations

from math import gcd, prod

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robodyn.solids.mesh.blocks import ROWS
from robodyn.solids.mesh.integrate.kernel import PAIRS
from robodyn.solids.mesh.integrate.residues import MODULUS_BITS, Field, integer, moduli_for, residue, residue_kernel


@given(st.integers(0, 10**400), st.data())
def test_every_integer_up_to_the_bound_comes_back(bound, data):
    moduli = moduli_for(bound)
    for number in (-bound, bound, data.draw(st.integers(-bound, bound))):
        assert integer([residue(number, m) for m in moduli], moduli) == number


@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_bound_at_the_limit_of_some_moduli(count):
    product = prod(moduli_for(10**100)[:count])
    for bound in (product // 2, product // 2 + 1):
        moduli = moduli_for(bound)
        assert integer([residue(-bound, m) for m in moduli], moduli) == -bound


def test_moduli_have_no_common_factors():
    moduli = moduli_for(2**4000)
    assert all(gcd(m, n) == 1 for i, m in enumerate(moduli) for n in moduli[:i])
    assert max(moduli) < 2**MODULUS_BITS


def test_residues_are_nearest_to_zero():
    assert [residue(n, 7) for n in range(-7, 8)] == [0, 1, 2, 3, -3, -2, -1, 0, 1, 2, 3, -3, -2, -1, 0]


def sums(triangle):
    """6 V, 24 first and 120 S of one triangle of integers."""
    a, b, c = triangle
    D = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    edges = [[x + y for x, y in zip(p, q, strict=True)] for p, q in ((a, b), (b, c), (c, a))]
    first = [D * (x + y + z) for x, y, z in zip(a, b, c, strict=True)]
    return [D, *first, *(D * sum(u[i] * u[j] for u in edges) for i, j in PAIRS)]


def largest_of(triangles, modulus):
    """The triangle whose products of residues are the largest of all."""

    def size(triangle):
        D, *_ = sums(triangle)
        u = [triangle[0][0] + triangle[1][0], triangle[1][0] + triangle[2][0], triangle[2][0] + triangle[0][0]]
        return abs(sum(residue(D * x, modulus) * x for x in u))

    return max(triangles, key=size)


@pytest.mark.parametrize("seed", range(4))
def test_a_full_block_of_the_largest_residues_has_no_rounding(seed):
    rng = np.random.default_rng(seed)
    (modulus,) = moduli_for(1)
    half = modulus // 2
    triangle = largest_of(rng.integers(-half, half + 1, (3000, 3, 3)).tolist(), modulus)
    field = Field(2)
    parts = np.zeros((2, 3, 3, ROWS))
    parts[0] = np.array(triangle)[:, :, None]
    parts[1] = 2**26
    steps, result = residue_kernel(parts, field)
    field.choose(modulus, [1, 5], [residue(5 * 2**26, modulus)] * 3)
    for function, arguments in steps:
        function(*arguments)
    assert [int(x) % modulus for x in result] == [ROWS * x % modulus for x in sums(triangle)]
    assert np.abs(result).max() < 2**53
