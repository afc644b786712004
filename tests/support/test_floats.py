"""Orders and choices that hold whatever the last digits are; sums over named axes, where some have length zero and what
is new holds dirt."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.dirty_memory import soil
from hypothesis import given
from hypothesis import strategies as st

from robodyn.support.floats import HALF_UP, einsum, first_largest, first_of_ties, ranked

ROUNDING = 1e-14
"""What the last digits of numbers may be off, relatively."""
LEVELS = st.lists(st.sampled_from([0.0, 1e-300, 1e-7, 0.1, 0.25, 1.0, 1.001, 3.2, 87.0, 1e12]), min_size=1, max_size=8)


def shaken(values: list[float], seed: int) -> list[float]:
    """The same numbers with other last digits."""
    noise = np.random.default_rng(seed).uniform(-ROUNDING, ROUNDING, len(values))
    return (np.array(values) * (1.0 + noise)).tolist()


@given(values=LEVELS, seed=st.integers(0, 1000))
def test_last_digits_change_no_order(values: list[float], seed: int) -> None:
    other = shaken(values, seed)
    places = range(len(values))
    assert ranked(places, other.__getitem__) == ranked(places, values.__getitem__)
    assert first_largest(other) == first_largest(values)


@given(values=LEVELS)
def test_the_largest_comes_first_and_equal_ones_as_given(values: list[float]) -> None:
    order = ranked(range(len(values)), values.__getitem__)
    assert order == sorted(range(len(values)), key=lambda k: (-values[k], k))
    assert first_largest(values) == order[0]


@given(st.lists(st.sampled_from([0.0, -2.0, 1.0, 0.3, np.inf]), min_size=1, max_size=6), st.integers(0, 1000))
def test_rows_are_treated_as_single_lists(values: list[float], seed: int) -> None:
    other = np.random.default_rng(seed).uniform(-1.0, 1.0, len(values)).tolist()
    rows = np.array([values, shaken(values, seed), other])
    assert first_of_ties(rows).tolist() == [first_largest(row) for row in rows]


def test_differences_of_more_than_rounding_count() -> None:
    assert ranked("ab", {"a": 1.0, "b": 1.0 + 4e-9}.__getitem__) == ["b", "a"]
    assert first_largest([1.0, 1.0 + 4e-9]) == 1


def test_noise_is_a_tie_whatever_its_sign() -> None:
    noise = {"a": -3e-17, "b": 2e-16, "c": 0.0, "d": 0.5}
    assert ranked(noise, noise.__getitem__, noise=1e-12) == ["d", "a", "b", "c"]
    assert first_largest([-3e-17, 2e-16, 0.0], noise=1e-12) == 0


@pytest.mark.parametrize(("values", "first"), [([1.0, np.inf, np.inf], 1), ([-np.inf, -np.inf], 0), ([-2.0, -1.0], 1)])
def test_infinite_and_negative_numbers(values: list[float], first: int) -> None:
    assert first_largest(values) == first
    assert ranked(range(len(values)), values.__getitem__)[0] == first


@pytest.mark.parametrize(("x", "digits"), [(0.125, 2), (1.546875, 6), (2.5e-4, 1), (12345.5, 5)])
def test_half_way_is_printed_upwards(x: float, digits: int) -> None:
    found = {f"{x * (1 + k * 1e-15) * HALF_UP:.{digits}g}" for k in (-3, 0, 3)}
    assert len(found) == 1
    assert float(found.pop()) > x


@pytest.mark.parametrize(
    ("subscripts", "shapes"),
    [
        ("ij,j->i", [(2, 0), (0,)]),
        ("ij,jk->ik", [(0, 3), (3, 2)]),
        ("ij,j->", [(2, 3), (3,)]),
        ("abc,cb,a->", [(2, 0, 3), (3, 0), (2,)]),
        ("abc,cd->bd", [(2, 3, 2), (2, 3)]),
    ],
)
@pytest.mark.parametrize("order", ["C", "F"])
def test_sums_are_those_of_their_terms_whatever_stands_in_memory(subscripts, shapes, order, monkeypatch):
    rng = np.random.default_rng(1)
    factors = [np.asarray(rng.normal(size=shape) + 1j * rng.normal(size=shape), order=order) for shape in shapes]
    soil(monkeypatch)
    for parts in (factors, [factor.real for factor in factors]):
        found = einsum(subscripts, *parts)
        axes, kept = subscripts.split("->")
        lengths = dict(
            pair for names, x in zip(axes.split(","), parts, strict=True) for pair in zip(names, x.shape, strict=True)
        )
        expected = np.zeros([lengths[name] for name in kept], np.result_type(*parts))
        for place in np.ndindex(*lengths.values()):
            at = dict(zip(lengths, place, strict=True))
            terms = (x[tuple(at[name] for name in names)] for names, x in zip(axes.split(","), parts, strict=True))
            expected[tuple(at[name] for name in kept)] += np.prod([*terms])
        assert (found.shape, found.dtype) == (expected.shape, expected.dtype)
        np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-13)
