"""Boxes around bodies: placed, joined, and whether they overlap."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.programs.vectors import IDENTITY, ZERO, rotation_from_rpy
from robodyn.solids.inertia.validity import Box, around, counted_twice, overlaps

UNIT = Box(np.zeros(3), np.ones(3))


def at(x, y=0.0, z=0.0):
    return UNIT.placed(IDENTITY, np.array([x, y, z]))


@pytest.mark.parametrize("seed", range(10))
def test_the_placed_box_is_the_smallest_around_the_corners(seed):
    rng = np.random.default_rng(seed)
    box = Box(-rng.random(3), rng.random(3))
    R, p = rotation_from_rpy(*rng.uniform(-3, 3, 3)), rng.normal(size=3)
    corners = np.array([[(box.lo, box.hi)[bits[i]][i] for i in range(3)] for bits in np.ndindex(2, 2, 2)])
    expected = corners @ R.T + p
    found = box.placed(R, p)
    np.testing.assert_allclose(found.lo, expected.min(axis=0), rtol=0, atol=1e-15)
    np.testing.assert_allclose(found.hi, expected.max(axis=0), rtol=0, atol=1e-15)


def test_around():
    found = around([at(0), at(2, -1)])
    np.testing.assert_array_equal((found.lo, found.hi), ([0, -1, 0], [3, 1, 1]))


@pytest.mark.parametrize(
    ("boxes", "pairs"),
    [
        ([UNIT], 0),
        ([UNIT, at(1)], 0),
        ([UNIT, at(1 - 1e-9)], 0),
        ([UNIT, at(0.99)], 1),
        ([UNIT, at(0.5, 2)], 0),
        ([UNIT, UNIT, UNIT], 3),
        ([UNIT, at(0.5), at(1.2)], 2),
    ],
)
def test_overlaps(boxes, pairs):
    assert overlaps(boxes) == pairs
    assert len(counted_twice(boxes)) == (pairs > 0)


def test_words():
    assert counted_twice([UNIT, UNIT]) == ("boxes of 1 pair of bodies overlap: what bodies share counts twice",)
    assert counted_twice([UNIT] * 3)[0].startswith("boxes of 3 pairs of bodies overlap")
    assert UNIT.placed(IDENTITY, ZERO).hi.tolist() == [1, 1, 1]
