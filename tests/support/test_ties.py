"""Orders and choices that hold whatever the last digits are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robodyn.support.floats import HALF_UP, first_largest, first_of_ties, ranked

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
