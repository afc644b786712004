"""What pages show of a motion keeps every peak, in memory that does not grow, however the motion comes in blocks."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from robodyn.support.courses import MOST, Courses

RNG = np.random.default_rng(1)


def gathered(columns, curves, cuts, names=("time", "a", "b")):
    found = Courses(names, ("a", "b"))
    for first, last in pairwise([0, *cuts, len(columns[0])]):
        found.update([each[first:last] for each in columns], [each[first:last] for each in curves])
    return found


@pytest.mark.parametrize("cuts", [(), (7, 5000, 5001, 40_000), tuple(range(1, 50_000, 977))])
def test_buckets_hold_first_least_and_greatest(cuts):
    values = RNG.normal(size=(2, 50_001)).cumsum(axis=1)
    time = np.arange(values.shape[1]) * 1e-3
    found = gathered((time, *values), values, cuts)
    starts = np.arange(0, len(time), found.per)
    assert found.per == 8
    assert MOST / 2 < len(found.first) == len(starts) <= MOST
    np.testing.assert_array_equal(found.first.T, np.array((time, *values))[:, starts])
    for name, curve in zip("ab", values, strict=True):
        low, high = found.of(name)
        np.testing.assert_array_equal(low, np.minimum.reduceat(curve, starts))
        np.testing.assert_array_equal(high, np.maximum.reduceat(curve, starts))


def test_frames_have_the_rows_of_the_peaks():
    values = RNG.normal(size=(2, 50_001))
    values[0, 12_347], values[1, 40_001] = 9.0, -9.0
    numbers, frames = gathered((np.arange(50_001.0), *values), values, (20_000,)).frames()
    np.testing.assert_array_equal(frames[:, 0], numbers)
    assert (np.diff(numbers) > 0).all()
    assert {0, 12_347, 40_001, 50_000} <= set(numbers.tolist())
    np.testing.assert_array_equal(frames[:, 1:], values.T[numbers.astype(int)])


def test_all_rows_of_short_motions_are_kept():
    values = np.array([[1.0, 2.0, 3.0, -1.0], [0.0, 0.0, 0.0, 0.0]])
    found = gathered((np.arange(4.0), *values), values, (1, 2))
    np.testing.assert_array_equal(found.first[:, 1:], values.T)
    np.testing.assert_array_equal(found.of("a"), (values[0], values[0]))
    assert len(found.frames()[0]) == 4


def test_many_columns_leave_fewer_rows():
    columns = [np.arange(30_000.0)] * 400
    found = gathered(columns, columns[:2], (10_000,), tuple(map(str, range(400))))
    assert found.first.size + found.low.size + found.high.size <= 700_000
    assert found.per == 32
