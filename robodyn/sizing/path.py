"""Paths through way-points: what a table says of positions alone, and the curve that leads through them."""

from __future__ import annotations

import os
from contextlib import closing
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import TrajectoryError
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.trajectory.columns.layout import ABSENT, Header, resolve
from robodyn.trajectory.columns.signals import is_time
from robodyn.trajectory.options import Reading, hold_of
from robodyn.trajectory.read import open_table, signals

DWELL = "dwell"
MOST_ROWS = 100_000
_SAME = 1e-9  # of the whole way: rows that are nearer to each other are one way-point
_LEAST, _FARTHEST = 1e-12, 1e6  # rad or m: what is no way at all, and what is none that a robot goes


class WayPoints(NamedTuple):
    """Positions (M, n) [rad or m], the row of the table of each, from 1, and how long the robot waits there [s]."""

    q: Floats
    rows: NDArray[np.int64]
    dwell: Floats


def read_path(source: Any, model: Model, scene: Scene, **reading: Any) -> WayPoints:
    """Return the way-points of a table of positions: columns as of a motion; time and rates are not used, and need not
    be there; `dwell` [s] is how long the robot waits in a row. Rows without a way between them are one.

    Args:
        source: a file as of `read_motion`, or positions (M, n); reading: as of `read_motion`.

    Raises:
        TrajectoryError: the columns do not fit the robot, a cell is no number, fewer than two places are left.
    """
    if isinstance(source, (str, os.PathLike)):
        file, q, dwell = _table(source, model, scene, reading)
    else:
        q = np.array(source, dtype=float)
        if q.ndim != 2 or q.shape[1] != model.n:
            raise TrajectoryError(f"the path has shape {q.shape}", remedy=f"(M, {model.n})")
        file, dwell = None, np.zeros(len(q))
    if (wrong := ~(np.abs(q) <= _FARTHEST)).any():
        row, i = np.argwhere(wrong)[0].tolist()
        what = f"row {row + 1}: {model.joint_names[i]} is at {q[row, i]:g}"
        raise TrajectoryError(what, remedy="finite numbers, rad or m", file=file)
    if (dwell < 0.0).any():
        row = int(np.argmax(dwell < 0.0)) + 1
        raise TrajectoryError(f"row {row}: dwell is {dwell[row - 1]:g} s", remedy="0 or more", file=file)
    steps = np.linalg.norm(np.diff(q, axis=0), axis=1)
    apart = np.concatenate(([True], steps > max(_SAME * float(steps.sum()), _LEAST)))
    if apart.sum() < 2:
        what = "is no path: it has fewer than two places" if len(q) else "has no rows"
        raise TrajectoryError(what, remedy="give two way-points at least", file=file)
    at = np.flatnonzero(apart)
    return WayPoints(q[at], at + 1, np.add.reduceat(dwell, at))


def _table(source: str | os.PathLike[str], model: Model, scene: Scene, given: dict[str, Any]) -> tuple[str, Any, Any]:
    reading = Reading(**{**given, "hold": hold_of(given.get("hold")), "columns": given.get("columns") or {}})
    with closing(open_table(source, reading.topic)) as table:
        called = {*table.names, *reading.columns}
        names = table.names if any(map(is_time, called)) else (*table.names, "time")
        header = Header(names, table.file, table.header_line)
        if header.labels:
            header = header.labelled(table.texts([*header.labels]))
        layout = resolve(header, signals(model, scene), (DWELL,) if DWELL in called else (), reading)
        needed = sorted({*layout.q, *layout.extra.values()} - {ABSENT})
        table.choose(needed)
        blocks = [np.array(block) for block in table.blocks(needed, 1 << 15)]
    cells = np.concatenate([np.empty((0, len(needed))), *blocks])
    if len(cells) > MOST_ROWS:
        what = f"has more than {MOST_ROWS} rows"
        raise TrajectoryError(what, remedy="a path needs fewer: leave rows out", file=table.file)
    q = np.zeros((len(cells), model.n))
    for i, column in enumerate(layout.q):
        if column != ABSENT:
            q[:, i] = cells[:, needed.index(column)] / layout.parts.get(column, 1.0)
    for i, position in layout.held.items():
        q[:, i] = position
    dwell = cells[:, needed.index(layout.extra[DWELL])] if layout.extra else np.zeros(len(cells))
    return table.file or str(source), q, dwell


@dataclass(frozen=True, eq=False)
class Path:
    """A curve q(s), s from 0 on, of polynomials.

    Attributes:
        breaks: (P + 1,) where pieces begin and end; c: (degree + 1, P, n) coefficients of powers of s - breaks[p].
        marks: (M,) s of the way-points, or of the places nearest to them; rows: theirs in the table.
        stops: s at which the robot stands still, both ends among them; dwell: how long it waits there [s].
    """

    breaks: Floats
    c: Floats
    marks: Floats
    rows: NDArray[np.int64]
    stops: Floats
    dwell: Floats

    def at(self, s: Floats, piece: NDArray[np.int64]) -> tuple[Floats, Floats, Floats, Floats]:
        """Return q and its first three derivatives by s (..., n), by these pieces."""
        c = self.c[:, piece]
        t = (s - self.breaks[piece])[..., None]
        q, first, second, third = (np.zeros(c.shape[1:]) for _ in range(4))
        for each in c[::-1]:
            third = third * t + 3.0 * second
            second = second * t + 2.0 * first
            first = first * t + q
            q = q * t + each
        return q, first, second, third

    def pieces(self, s: Floats, leg: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the pieces at s, which is on these legs from stop to stop."""
        stops = np.abs(self.breaks[:, None] - self.stops).argmin(axis=0)
        return np.clip(np.searchsorted(self.breaks, s, side="right") - 1, stops[leg], stops[leg + 1] - 1)

    def row(self, s: Floats | float) -> Floats:
        """Return the place in the table: 2.5 is half-way between rows 2 and 3."""
        return np.asarray(np.interp(s, self.marks, self.rows.astype(float)))

    def grid(self, points: int) -> Floats:
        """Return places (N,), about so many, nearer to each other beside breaks, every break among them, and where
        joints turn back."""
        from scipy.interpolate import PPoly

        lengths = np.diff(self.breaks)
        least = max(min(20, points // len(lengths)), min(len(self.stops) - 1, 2))
        counts = np.maximum(np.ceil(points * lengths / lengths.sum()), least)
        parts = [
            a + h * 0.5 * (1.0 - np.cos(np.pi * np.arange(m) / m))
            for a, h, m in zip(self.breaks, lengths, counts, strict=False)
        ]
        s = np.concatenate([*parts, self.breaks[-1:]])
        found = PPoly(self.c[::-1], self.breaks).derivative().roots(discontinuity=False, extrapolate=False)
        roots = np.concatenate(found.tolist())
        roots = roots[np.isfinite(roots)]
        k = np.clip(np.searchsorted(s, roots) - 1, 0, len(s) - 2)
        near = 1e-6 * (s[k + 1] - s[k])
        return np.unique(np.concatenate((s, roots[(roots - s[k] > near) & (s[k + 1] - roots > near)])))


def spline(points: WayPoints) -> Path:
    """Return the cubic spline with continuous second derivatives through the way-points, over the centripetal parameter
    (the square roots of chords, Lee 1989), which turns uneven ways without loops; its third derivative is continuous in
    the second and the last but one. Two points are a line, three a parabola."""
    from scipy.interpolate import CubicSpline

    chords = np.sqrt(np.linalg.norm(np.diff(points.q, axis=0), axis=1))
    s = np.concatenate(([0.0], np.cumsum(chords)))
    c = CubicSpline(s, points.q).c[::-1]
    kept = np.concatenate(([True], points.dwell[1:-1] > 0.0, [True]))
    return Path(s, c, s, points.rows, s[kept], points.dwell[kept])


def lines(points: WayPoints, radius: float | None = None) -> Path:
    """Return straight lines between the way-points, over their length [rad, m]: each corner is left and joined again at
    this distance from its way-point, at half of a line at most, by a curve with a continuous second derivative,
    `q' = d0 + (d1 - d0) (3 t^2 - 2 t^3)`; where the radius is 0, or the robot waits, it stops in the corner;
    None: it stops at each way-point."""
    ways = np.diff(points.q, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    along, s = ways / lengths[:, None], np.concatenate(([0.0], np.cumsum(lengths)))
    turn = np.diff(along, axis=0)
    straight = np.linalg.norm(turn, axis=1) < 1e-9
    stopping = (points.dwell[1:-1] > 0.0) | (radius is None) | ((radius == 0.0) & ~straight)
    room = np.zeros(len(s))
    room[1:-1] = np.minimum(0.5 * np.minimum(lengths[:-1], lengths[1:]), radius or 0.0) * ~(stopping | straight)
    # lines and corners in turn, those of no length too
    c = np.zeros((5, 2 * len(lengths) - 1, points.q.shape[1]))
    c[0, ::2], c[1, ::2] = points.q[:-1] + room[:-1, None] * along, along
    r = np.where(room > 0.0, room, 1.0)[1:-1, None]
    c[0, 1::2], c[1, 1::2] = points.q[1:-1] - r * along[:-1], along[:-1]
    c[3, 1::2], c[4, 1::2] = turn / (2.0 * r) ** 2, -turn / (2.0 * (2.0 * r) ** 3)
    breaks = np.column_stack((s - room, s + room)).ravel()[1:-1]
    long = np.diff(breaks) > 1e-12 * s[-1]
    kept = np.concatenate(([True], stopping, [True]))
    return Path(np.append(breaks[:-1][long], s[-1]), c[:, long], s, points.rows, s[kept], points.dwell[kept])
