"""Samples of a log, and the even grid that they are put on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from robodyn.support.floats import Floats

_HALO = 8
"""Rows on either side that an interpolated value sees."""


class Samples(NamedTuple):
    """Consecutive samples on an even grid.

    Attributes:
        time: (k,) s; q: (k, nq); qd, qdd: (k, n).
        tau: (k, n) N m, zero of joints that are not measured, NaN where a torque is left out.
        begins: whether a stretch begins with them.
    """

    time: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats
    begins: bool

    def cut(self, rows: slice, begins: bool) -> Samples:
        """Return some of the samples."""
        return Samples(self.time[rows], self.q[rows], self.qd[rows], self.qdd[rows], self.tau[rows], begins)


def joined(first: Samples, second: Samples) -> Samples:
    """Return consecutive samples as one."""
    time, q, qd, qdd, tau = (
        np.concatenate([getattr(part, name) for part in (first, second)]) for name in Samples._fields[:-1]
    )
    return Samples(time, q, qd, qdd, tau, first.begins)


class Grid:
    """Puts rows with uneven stamps onto an even grid: motion by cubic splines, torques by straight lines.

    Torques that are logged `delays` (n,) late [s] are put where they belong.
    """

    def __init__(self, step: float, delays: Floats) -> None:
        self._step, self._next, self._begins = step, 0.0, True
        self._delays = delays
        self._halo = _HALO + int(np.ceil(np.abs(delays).max(initial=0.0) / step))
        self._rows: Samples | None = None

    def feed(self, part: Samples) -> Iterator[Samples]:
        """Yield the samples up to some rows before the end of a part."""
        if part.begins:
            yield from self.finish()
            self._rows, self._next, self._begins = None, float(part.time[0]), True
        rows = part if self._rows is None else joined(self._rows, part)
        self._rows = rows
        if len(rows.time) > self._halo:
            yield from self._until(float(rows.time[-self._halo]))
            first = max(0, int(np.searchsorted(rows.time, self._next)) - self._halo)
            self._rows = rows.cut(slice(first, None), False)

    def finish(self) -> Iterator[Samples]:
        """Yield what is left of a stretch."""
        if self._rows is not None:
            yield from self._until(float(self._rows.time[-1]))

    def _until(self, stop: float) -> Iterator[Samples]:
        from scipy.interpolate import CubicSpline

        rows = self._rows
        count = int(np.floor((stop - self._next) / self._step * (1.0 + 1e-12))) + 1
        if rows is None or count < 1 or len(rows.time) < 4:
            return
        time: Floats = np.asarray(self._next + self._step * np.arange(count))
        motion = CubicSpline(rows.time, np.concatenate([rows.q, rows.qd, rows.qdd], axis=1))(time)
        q, qd, qdd = np.split(motion, [rows.q.shape[1], rows.q.shape[1] + rows.qd.shape[1]], axis=1)
        late = zip(self._delays.tolist(), rows.tau.T, strict=True)
        outside = {True: np.nan, False: None}
        tau = [np.interp(time + d, rows.time, of, outside[d != 0.0], outside[d != 0.0]) for d, of in late]
        yield Samples(time, q, qd, qdd, np.stack(tau, axis=1), self._begins)
        self._next, self._begins = float(time[-1]) + self._step, False
