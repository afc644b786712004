"""Fractions of floats of any width, and their storage as sums of two floats."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import InputError
from robodyn.solids.inertia.laws import exact, fraction, rounded, two_floats


def test_every_kind_of_number_is_taken_as_it_is():
    third = Fraction(1, 3)
    assert exact([0.1, 2, third]).tolist() == [Fraction(3602879701896397, 2**55), 2, third]
    assert fraction(np.float32(0.1)) == Fraction(13421773, 2**27)
    wide = np.longdouble(1) + np.finfo(np.longdouble).eps
    assert fraction(wide) == 1 + Fraction(*np.finfo(np.longdouble).eps.as_integer_ratio())
    assert exact(np.eye(2, dtype=int)).shape == (2, 2)


@given(st.fractions(min_value=-(10**9), max_value=10**9).filter(lambda x: abs(x) > Fraction(1, 10**100)))
def test_two_floats_hold_106_bits(number):
    high, low = two_floats(np.array([number], dtype=object))
    assert high.dtype == low.dtype == float
    assert high[0] == float(number)
    assert abs(fraction(high[0]) + fraction(low[0]) - number) <= abs(number) / 2**106


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused(bad):
    with pytest.raises(InputError, match="infinite or not a number"):
        exact([1.0, bad])


def test_what_is_too_large_for_a_float_is_refused():
    with pytest.raises(InputError, match=r"exceeds 1\.8e308"):
        rounded(np.array([Fraction(10) ** 309], dtype=object))
