"""Where joints stand still within the resolution of their positions: speeds are 0 there, not noise of either sign, on
which friction, the losses of gears and the duty of a joint would depend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats
from robodyn.trajectory.columns.layout import ABSENT, Layout
from robodyn.trajectory.columns.signals import Signals
from robodyn.trajectory.derivatives.groups import turns_ahead
from robodyn.trajectory.motion import Trajectory, cut

Flags = NDArray[np.bool_]

SHORTEST, LONGEST = 4, 256  # rows of the windows looked at
SEEN = 1 << 12  # rows of the first block that stand for a table whose velocities are all given
REACH = 3 * LONGEST
"""Neighbours on either side that tell whether a row stands still; without them a block is judged for itself."""
SCATTER = 8.0  # standard deviations of noise over which positions that stand still are spread
GRID = 0.4  # of a step of the grid: noise up to this is that of rounding to it
LEAVES = 28.0
"""How many times its resolution a joint moves, within twice the length of a short standstill before and after it; at a
turning point of its motion it moves 24 times as far as in the time in which it seems to stand still."""
SLIGHT = 0.01  # of the largest speed in a table: what may be noise of speeds that are given
NEAR = 32  # rows within which noise changes its sign twice
SURE = 4.0  # standard errors of their mean, beyond which speeds that are given are no noise
_ROUNDING = 4.0 * float(np.finfo(np.float64).eps)


def resolution(quantum: float, noise: float, largest: float) -> float:
    """Within what positions that stand still are: a step of their grid, the noise (standard deviation), or rounding."""
    scatter = SCATTER * noise if noise > GRID * quantum else 0.0
    return max(quantum * (1.0 + 1e-6), scatter, _ROUNDING * largest)


def standing(positions: Floats, band: float, speeds: Floats | None = None, slight: float = 0.0) -> Flags:
    """Whether a joint stands still in each row (N,), by its positions and the band of `resolution`. It does in windows
    in which its positions stay within their resolution: of LONGEST rows, or of fewer where it leaves the place fast
    before and after, as where it stops between two moves; a slow motion does not, nor does a turning point. Speeds that
    are given must be `slight`, and 0 in the mean within their own scatter."""
    count = len(positions)
    found = np.zeros(count, dtype=bool)
    near = np.concatenate(([False], np.abs(np.diff(positions)) <= band, [False]))
    if not (near[1:-1] if speeds is None else near[1:-1] & (speeds[1:] != 0.0)).any():
        return found
    length, high, low = 1, positions, positions
    if speeds is not None:
        total, square, swift = speeds, speeds * speeds, np.abs(speeds)
    while length < LONGEST and 2 * length <= count:
        high, low = np.maximum(high[:-length], high[length:]), np.minimum(low[:-length], low[length:])
        if speeds is not None:
            total, square = total[:-length] + total[length:], square[:-length] + square[length:]
            swift = np.maximum(swift[:-length], swift[length:])
        length *= 2
        if length < SHORTEST:
            continue
        within = high - low <= band
        if not within.any():
            break
        if length < LONGEST:
            within &= _left(high, low, length, band) & _left(high[::-1], low[::-1], length, band)[::-1]
        if speeds is not None:
            within &= (swift <= slight) & (total * total <= SURE * SURE * square)
        marks = np.zeros(count + 1, dtype=np.int64)
        starts = np.flatnonzero(within)
        marks[starts] += 1
        np.subtract.at(marks, starts + length, 1)
        found |= np.cumsum(marks[:-1]) > 0
    return found


def _left(high: Floats, low: Floats, length: int, band: float) -> Flags:
    """Of each window whether the joint leaves it within twice its length after it, or stays to the table's end."""
    count = len(high)
    top, bottom = (np.pad(x, (0, 2 * length), mode="edge") for x in (high, low))
    top, bottom = np.maximum(top[length:], top[:-length]), np.minimum(bottom[length:], bottom[:-length])
    far = np.maximum(top[length : length + count] - low, high - bottom[length : length + count])
    whole = np.arange(count) < count - 2 * length
    return np.asarray((far > LEAVES * band) | (~whole & (far <= band)))


class Standstill:
    """The joints of a table, and the resolutions of their positions."""

    def __init__(
        self, signals: Signals, layout: Layout, pieces: Sequence[Trajectory], known: Mapping[int, tuple[float, float]]
    ) -> None:
        """Pieces stand for the table, without any the first block does; grids' steps and noises of q may be known."""
        self._joints = [
            (joint.kind, q, rate)
            for joint, ((q, *_), (rate, *_)) in zip(signals.joints, signals.spans.values(), strict=True)
            if joint.kind != "floating" and layout.q[q] != ABSENT
        ]
        self._given = {rate for _, _, rate in self._joints if layout.qd[rate] != ABSENT}
        self._pieces, self._known, self._bands = pieces, dict(known), dict[int, float]()
        self._spacing = self._top = 0.0

    @np.errstate(all="ignore")
    def stopped(self, samples: Trajectory) -> Trajectory:
        """A block with its neighbours, all velocities filled in, whose speeds become 0 where joints stand still."""
        if not self._spacing:
            self._pieces = self._pieces or [cut(samples, 0, SEEN)]
            steps = [np.diff(piece.time) for piece in self._pieces]
            ordered = np.sort(np.concatenate(steps))
            self._spacing = float(ordered[len(ordered) // 2]) if len(ordered) else 0.0
            self._top = max(float(np.abs(piece.qd).max(initial=0.0)) for piece in self._pieces)
        qd, slow = samples.qd, np.zeros(samples.qd.shape[1])
        for kind, q, rate in self._joints:
            if rate in self._given and q not in self._bands:
                speeds = qd[:, rate]
                rows = np.flatnonzero((speeds != 0.0) & (np.abs(speeds) <= SLIGHT * self._top))
                turns = rows[1:][(speeds[rows[1:]] > 0.0) != (speeds[rows[:-1]] > 0.0)]
                if not (np.diff(turns) <= NEAR).any():  # as noise changes its sign
                    continue
            places = _straight(kind, samples.q[:, [q]])[:, 0]
            band = self._band(kind, q)
            step_speed = band / self._spacing if self._spacing > 0.0 else 0.0
            slow[rate] = step_speed / LONGEST
            given = qd[:, rate] if rate in self._given else None
            still = standing(places, band, given, max(step_speed, SLIGHT * self._top))
            if still.any():
                qd = samples.qd.copy(order="F") if qd is samples.qd else qd
                qd[still, rate] = 0.0
        return replace(samples, qd=qd, slowest=slow)

    def _band(self, kind: str, q: int) -> float:
        from robodyn.trajectory.derivatives.derivative_selection import FINEST_ENCODER, estimate

        if q not in self._bands:
            if q not in self._known:
                runs = [(each.time, each.q[:, [q]]) for each in self._pieces if len(each) > 1]
                noise = estimate([(t, x, _straight(kind, x)) for t, x in runs])
                self._known[q] = noise.quantum, noise.sigma
            step, sigma = self._known[q]
            largest = max(float(np.abs(each.q[:, q]).max(initial=0.0)) for each in self._pieces)
            self._bands[q] = resolution(step if step <= FINEST_ENCODER else 0.0, sigma, largest)
        return self._bands[q]


def _straight(kind: str, places: Floats) -> Floats:
    return places - 2.0 * np.pi * turns_ahead(places) if kind == "continuous" else places
