"""The exponential of the numpy executor, in units in the last place (ulp)."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.programs.run.numpy_blocks import exponential


@pytest.mark.skipif(np.finfo(np.longdouble).nmant < 63, reason="long double has no more digits than double")
def test_within_an_ulp():
    rng = np.random.default_rng(2)
    around = np.arange(-1074, 1024) * np.log(2.0)
    for x in (rng.uniform(-745.0, 709.7, 50_000), rng.uniform(-1.0, 1.0, 50_000), around, around + 0.5 * np.log(2.0)):
        exact = np.exp(x.astype(np.longdouble))
        off = np.abs(exponential(x) - exact) / np.spacing(exact.astype(float))
        assert off.max() <= 1.0


@np.errstate(over="ignore")
def test_out_of_range():
    x = np.array([710.0, 1e300, np.inf, -746.0, -1e300, -np.inf, np.nan, 0.0, -0.0, -745.1332191019411])
    expected = [np.inf] * 3 + [0.0] * 3 + [np.nan, 1.0, 1.0, 5e-324]
    np.testing.assert_array_equal(exponential(x), expected)
    np.testing.assert_array_equal(exponential(x.astype(np.float32)), np.array(expected, np.float32))


def test_into_an_array():
    x, out = np.linspace(-3.0, 0.0, 7), np.empty(7)
    assert exponential(x, out) is out
    np.testing.assert_array_equal(out, exponential(x))
