"""One sample of a table: the row nearest to a time."""

from __future__ import annotations

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.trajectory.assemble import cut
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.reader import TrajectoryReader


def row_at(reader: TrajectoryReader, time: float) -> Trajectory:
    """The sample nearest to `time` [s], the earlier of two that are as near; nothing is interpolated.

    Raises:
        TrajectoryError: the time is before the first row or after the last, or the table is wrong.
    """
    first, best, last = float("nan"), None, float("nan")
    for block in reader.blocks():
        k = int(np.argmin(np.abs(block.time - time)))
        first = float(block.time[0]) if best is None else first
        last = float(block.time[-1])
        if best is None or abs(block.time[k] - time) < abs(best.time[0] - time):
            best = cut(block, k, k + 1)
        if first <= time <= last:
            break
    if best is None or not first <= time <= last:
        what = f"time {time:.6g} s is outside the motion"
        raise TrajectoryError(what, remedy=f"it lasts from {first:.6g} s to {last:.6g} s", file=reader.file)
    return best
