"""Equal keys and points have one number, in the order of their values, however many bits they take."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.solids.mesh.indexed import distinct, distinct_points, numbered, paired

RNG = np.random.default_rng(5)


@pytest.mark.parametrize(
    ("count", "most"), [(0, 30), (1, 1), (2, 2**40), (7, 2**53 + 1), (1000, 30), (1000, 2**63 - 1)]
)
def test_keys_by_their_values(count: int, most: int) -> None:
    keys = RNG.choice(RNG.integers(0, most, 100), count)
    keys[:1] = most - 1
    keys[1:2] = max(most - 2, 0)
    values = sorted(set(keys.tolist()))
    first, of = [keys.tolist().index(value) for value in values], [values.index(key) for key in keys.tolist()]
    found = distinct(keys)
    assert np.array_equal(found.first, first)
    assert np.array_equal(found.of, of)
    if most == 30:
        count, number = numbered(keys, most)
        assert count == len(first)
        assert np.array_equal(number, of)


def test_points_by_their_coordinates() -> None:
    points = RNG.integers(-3, 3, (500, 3)) / 7
    points[:5] = points[5:10] + 1e-16
    rows = [tuple(point) for point in points.tolist()]
    values = sorted(set(rows))
    first, of = [rows.index(value) for value in values], [values.index(row) for row in rows]
    found = distinct_points(points)
    assert np.array_equal(found.first, first)
    assert np.array_equal(found.of, of)


@pytest.mark.parametrize("bits", [5, 63])
def test_places_of_keys_that_two_have(bits: int) -> None:
    keys = RNG.choice(RNG.integers(0, 2**bits, 100, dtype=np.uint64), 150)
    places = [np.flatnonzero(keys == key) for key in dict.fromkeys(keys.tolist())]
    expected = np.array([place for place in places if len(place) == 2]).reshape(-1, 2)
    np.testing.assert_array_equal(np.stack(paired(keys), axis=1), expected)
