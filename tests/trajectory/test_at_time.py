"""The row nearest to a time, whatever the blocks are."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.motions import Pieces, waves
from helpers.oracles import robot

from robodyn.errors import TrajectoryError
from robodyn.trajectory.reader import row_at


def pieces(lengths):
    table = Pieces(waves(robot("scara"), np.arange(10) * 0.5), lengths)
    table.file = "table.csv"
    return table


@pytest.mark.parametrize("lengths", [[10], [1] * 10, [4, 5, 1]])
@pytest.mark.parametrize(("time", "row"), [(0.0, 0), (0.24, 0), (0.25, 0), (0.26, 1), (1.5, 3), (2.1, 4), (4.5, 9)])
def test_the_nearest_row(lengths, time, row):
    table = pieces(lengths)
    found = row_at(table, time)
    assert (len(found), found.first_row) == (1, row + 1)
    for name in ("time", "q", "qd", "qdd"):
        assert np.array_equal(getattr(found, name)[0], getattr(table.trajectory, name)[row])


@pytest.mark.parametrize("lengths", [[10], [3, 7]])
@pytest.mark.parametrize("time", [-0.1, 4.6, float("nan"), float("inf")])
def test_outside_the_motion(lengths, time):
    with pytest.raises(TrajectoryError, match=r"outside the motion \(it lasts from 0 s to 4\.5 s\)"):
        row_at(pieces(lengths), time)
