"""Groups of points: each point once, none too large, neighbours together."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.solids.mesh.region.winding_tree import clusters


@pytest.mark.parametrize("count", [0, 1, 16, 17, 500])
@pytest.mark.parametrize("most", [1, 7, 16])
def test_every_point_once_in_groups_that_are_small(count, most):
    groups = clusters(np.random.default_rng(count).normal(size=(count, 3)), most)
    assert sorted(np.concatenate([np.empty(0, int), *groups])) == list(range(count))
    assert all(0 < len(group) <= most for group in groups)
    assert len(groups) <= max(4 * count / most, 1)


def test_points_in_one_place_are_divided_too():
    groups = clusters(np.ones((100, 3)), 16)
    assert sum(map(len, groups)) == 100
    assert max(map(len, groups)) <= 16


def test_groups_are_compact():
    points = np.random.default_rng(0).random((4096, 3))
    sides = [np.ptp(points[group], axis=0).max() for group in clusters(points, 16)]
    assert np.median(sides) < 0.4
    assert max(sides) < 0.7


@pytest.mark.parametrize("seed", range(5))
def test_twins_stay_together(seed):
    rng = np.random.default_rng(seed)
    points = rng.random((300, 3))
    twins = points + 1e-5 * rng.normal(size=points.shape)
    which = np.empty(600, int)
    for k, group in enumerate(clusters(np.concatenate([points, twins]), 12)):
        which[group] = k
    assert (which[:300] == which[300:]).all()
