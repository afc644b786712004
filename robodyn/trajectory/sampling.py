"""What too few samples leave open about derived accelerations, judged by leaving out every second one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.trajectory.assemble import cut, every_second
from robodyn.trajectory.derivatives import Method
from robodyn.trajectory.derive import Plan, derive, straight
from robodyn.trajectory.motion import JointDerivation, Sampling, Trajectory
from robodyn.trajectory.table import FloatArray

FEW = 24
"""Rows of a table below which they are taken for way-points: what lies between them is anyone's guess."""
NOISY = 128
"""Rows of a table below which what looks like noise may as well be the motion."""
CHECKED, EVERY = 1 << 14, 1 << 18
"""The first of so many rows of every so many are looked at: all of most tables, and a little of long ones."""
FEWEST = 6
"""Rows of which half are enough for a second derivative."""
_MARGIN = 128
_NEAR = 3
_FACTOR = 2.0
_NOISE = 7.0
"""Standard deviations of derived noise: four of the change, whose noise is sqrt(3) times that of the derivative."""


def sampling(samples: Trajectory, plan: Plan, start: int, stop: int) -> Sampling | None:
    """Return by how much derived accelerations of the rows from start to stop may be off; None if none is looked at.

    The bar is twice the largest change within three rows that is made by deriving from every second row, the row itself
    among them, beyond what noise makes, which has bars of its own. That is 32 times the error of a smooth motion, and
    about the error at corners of the velocity. In a table of fewer than 24 rows, any motion that rests in every row is
    within it.

    Args:
        samples: a block, derived, with its neighbours.
    """
    wanted = (samples.first_row - 1 + np.arange(start, stop)) % EVERY < CHECKED
    if not wanted.any():
        return None
    low, high = start + int(np.argmax(wanted)), stop - int(np.argmax(wanted[::-1]))
    begin, margin = max(0, low - plan.halo), _MARGIN + plan.halo
    change = _change(cut(samples, begin, high + margin), plan)[low - begin : high - begin]
    if few := len(samples) < FEW:
        change = np.maximum(change, (_guess(samples, plan) + np.abs(samples.qdd))[low:high] / _FACTOR)
    off = np.full_like(samples.qdd, np.nan)
    off[low:high] = _FACTOR * change
    off[:, _given(plan, off.shape[1])] = 0.0
    with np.errstate(over="ignore"):
        off_squares, squares = ((values[low:high] ** 2).sum(axis=0) for values in (off, samples.qdd))
    guessed = few and any(group.velocity for group in plan.groups)
    return Sampling(off[start:stop], off_squares, squares, guessed)


def _given(plan: Plan, width: int) -> list[int]:
    """Return the columns of qdd that are not derived."""
    derived = {column for group in plan.groups for _, column in group.acceleration}
    return [column for column in range(width) if column not in derived]


def _change(samples: Trajectory, plan: Plan) -> FloatArray:
    """Return (N, n) by how much qdd changes if it is derived from every second sample, at most within three rows."""
    padded = np.zeros((len(samples) + 2 * _NEAR, samples.qdd.shape[1]))
    change, surely = padded[_NEAR : len(samples) + _NEAR], len(samples) >= NOISY
    coarse = replace(plan, methods=tuple(map(_halved, plan.methods))) if surely else plan
    for first in (0, 1) if len(samples) >= FEWEST else ():
        try:
            change[first::2] = np.abs(derive(every_second(samples, first), coarse).qdd - samples.qdd[first::2])
        except TrajectoryError:  # stamps so uneven that half of them tell nothing
            change[first::2] = np.abs(samples.qdd[first::2])
    for group, account in zip(plan.groups, plan.derivation.joints, strict=True):
        columns = [column for _, column in group.acceleration]
        if account.noise and columns and surely:
            change[:, columns] = np.maximum(change[:, columns] - _NOISE * _noise(account, len(samples))[:, None], 0.0)
    found: FloatArray = np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEAR + 1, axis=0).max(axis=-1)
    return found


def _halved(method: Method) -> Method:
    """Return the method for samples twice as far apart: a window lasts as long as before."""
    return replace(method, window=max(method.window // 2 | 1, method.order + 1)) if method.kind == "savgol" else method


def _noise(account: JointDerivation, count: int) -> FloatArray:
    """Return (count,) the standard deviation that noise gives an acceleration."""
    ends = account.noise * np.array(account.end_gains[: count // 2])
    return np.concatenate((ends, np.full(count - 2 * len(ends), account.std_acceleration), ends[::-1]))


def _guess(samples: Trajectory, plan: Plan) -> FloatArray:
    """Return (N, n) the largest accelerations of a motion that rests in every row: 6 |dq| / h^2, 2 |dqd| / h."""
    guess, steps = np.zeros_like(samples.qdd), np.diff(samples.time)[:, None]
    for group in plan.groups:
        moved = np.abs(np.diff(straight(group, samples), axis=0))
        if group.kind == "quaternion":
            moved = 2.0 * np.sqrt((moved**2).sum(axis=1, keepdims=True)) * np.ones(3)
        needed = 2.0 * moved / steps if group.source == "qd" else 6.0 * moved / steps**2
        for component, column in group.acceleration:
            guess[:-1, column] = needed[:, component]
            guess[1:, column] = np.maximum(guess[1:, column], needed[:, component])
    return guess
