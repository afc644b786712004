"""A table that drives a simulation: the columns that a scene names, between its rows, and where these divide steps."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robodyn.errors import InputError, SceneError
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.trajectory.columns.layout import listing
from robodyn.trajectory.columns.signals import Signals, TimeUnit
from robodyn.trajectory.formats.table import ArrayTable
from robodyn.trajectory.motion import join
from robodyn.trajectory.options import Reading
from robodyn.trajectory.read import TrajectoryReader, open_trajectory

LOAD, REFERENCE, RATE = "load", "reference", "rate"
NEAR = 8.0 * float(np.finfo(float).eps)
"""Times that differ by less than this part of them are the same: what rounding makes of a multiple of a step."""


class Curve(NamedTuple):
    """A function of time made of a column: a torque or a part of a wrench, a reference, or a reference's rate."""

    column: str
    kind: str


@dataclass(frozen=True, eq=False)
class Table:
    """Rows of time (N,) [s], increasing, and of the columns (N,) that a scene names; a simulation begins at the first.
    `origin` is the stamp [s] that time counts from; 0 where these are the stamps."""

    file: str | None
    time: Floats
    columns: Mapping[str, Floats]
    origin: float = 0.0

    @property
    def duration(self) -> float:
        return float(self.time[-1] - self.time[0])


Source = str | os.PathLike[str] | Mapping[str, ArrayLike] | Table


def read_table(
    source: Source, scene: Scene, columns: Mapping[str, str] | None = None, time_unit: TimeUnit | None = None
) -> Table:
    """The columns that a scene names, of a file that `robodyn torques` reads (`-` is standard input), of arrays by
    name with `time`, or as read already; raises where it names none, or one is wrong. `columns`: the scene's name ->
    the table's; `time_unit` of stamps whose column does not tell, s by default."""
    if isinstance(source, Table):
        return source
    names = scene.table_columns
    if not names:
        what = "the scene names no column of the table"
        raise SceneError(what, remedy='write e.g. reference = "q_elbow" for a joint of [drive]')
    reading = Reading(ignore_extra=True, columns=columns or {}, time_unit=time_unit)
    if isinstance(source, Mapping):
        table = ArrayTable(None, {name: np.asarray(x, float).ravel() for name, x in source.items()})
        reader = TrajectoryReader(table, Signals(()), names, reading)
    else:
        reader = open_trajectory(source, Signals(()), extra=names, reading=reading)
    with reader:
        whole = join(list(reader.blocks()))
    return Table(None if isinstance(source, Mapping) else os.fspath(source), whole.time, whole.extra, whole.origin)


def curves(scene: Scene) -> tuple[Curve, ...]:
    """What a scene takes from a table at every moment, each once."""
    found = [Curve(name, LOAD) for wrench in scene.wrenches for name in wrench.columns]
    for drive in scene.drive.values():
        if isinstance(drive.torque, str):
            found.append(Curve(drive.torque, LOAD))
        if isinstance(drive.reference, str):
            found += [Curve(drive.reference, REFERENCE)] if drive.kp else []
            found += [Curve(drive.reference, RATE)] if drive.kd and drive.speed is None else []
        if isinstance(drive.speed, str) and drive.kd:
            found.append(Curve(drive.speed, REFERENCE))
    return tuple(dict.fromkeys(found))


class Signal:
    """The curves of a scene at any time of a simulation.

    References are cubic splines through the rows (not-a-knot), their rates the slopes of these. Torques and wrenches
    are straight between rows, or, where the scene holds them, those of the last row.

    Attributes:
        scene: with the initial state in numbers, those of the first row where columns are named.
        source: the table as arrays by name, where `scene` still names columns.
    """

    def __init__(self, scene: Scene, model: Model, table: Table | None) -> None:
        self.curves, self.table, self.held = curves(scene), table, scene.between_rows == "hold"
        self.scene, self.source = scene, None
        self._smooth = tuple(dict.fromkeys(curve.column for curve in self.curves if curve.kind != LOAD))
        endless = {joint.name for joint in model.independent if joint.continuous}
        self._wrapped = {drive.reference for name, drive in scene.drive.items() if name in endless}
        if table is None:
            if scene.table_columns:
                what = f"the scene names {listing(scene.table_columns)}, columns of a table"
                raise SceneError(what, remedy="give the table: --traj FILE")
            return
        if len(table.time) < 2:
            raise InputError("the table has one row", remedy="give two at least", file=table.file)
        self._rows = table.time - table.time[0]
        q, qd = (
            {name: float(table.columns[x][0]) if isinstance(x, str) else x for name, x in begun.items()}
            for begun in (scene.initial_q, scene.initial_qd)
        )
        if (q, qd) != (scene.initial_q, scene.initial_qd):
            self.scene = replace(scene, initial_q=q, initial_qd=qd)
        if self.scene.table_columns:
            self.source = {"time": table.time, **table.columns}

    @cached_property
    def _splines(self) -> Callable[..., Floats]:
        """Of the columns of references, in the order of `_smooth`."""
        from scipy.interpolate import CubicSpline

        columns = {name: self.table.columns[name] for name in self._smooth}  # type: ignore[union-attr]
        values = [np.unwrap(x) if name in self._wrapped else x for name, x in columns.items()]
        return CubicSpline(self._rows, np.column_stack(values))  # type: ignore[no-any-return]

    def check_duration(self, duration: float) -> None:
        if self.table is not None and duration > self.table.duration * (1.0 + 1e-9):
            what = f"the table lasts {self.table.duration:.9g} s, the simulation {duration:.9g} s"
            raise InputError(what, remedy="give a shorter --duration, or none", file=self.table.file)

    def corners(self, knots: int = 1) -> Floats:
        """(N,) s, increasing: rows at which steps have to end, as torques jump there or their slopes do; of references,
        whose splines are smooth, only every so many rows."""
        if self.table is None or not self.curves:
            return np.empty(0)
        rows, columns = self._rows, self.table.columns
        changes = np.zeros(len(rows), bool)
        for name in (curve.column for curve in self.curves if curve.kind == LOAD):
            if self.held:
                changes[1:] |= np.diff(columns[name]) != 0.0
            else:
                changes[1:-1] |= np.diff(np.diff(columns[name]) / np.diff(rows)) != 0.0
        if self._smooth:
            changes[knots::knots] = True
        return np.asarray(rows[changes])

    def at(self, time: Floats, within: Floats | None = None) -> Floats:
        """(N, curves) at N times [s] from the beginning; times `within` the rows that are meant tell what is held."""
        if self.table is None or not self.curves:
            return np.empty((len(time), 0))
        rows, meant = self._rows, time if within is None else within
        last = np.searchsorted(rows, meant * (1.0 + NEAR), side="right") - 1
        kinds = {curve.kind for curve in self.curves}
        smooth = {kind: self._splines(time, kind == RATE).T for kind in (REFERENCE, RATE) if kind in kinds}
        values: list[Floats] = []
        for name, kind in self.curves:
            column = self.table.columns[name]
            if kind != LOAD:
                values.append(smooth[kind][self._smooth.index(name)])
            else:
                values.append(column[last] if self.held else np.interp(time, rows, column))
        return np.column_stack(values)

    def in_steps(self, steps: Piece, nodes: tuple[float, ...]) -> Floats:
        """(N, nodes * curves + 1) for N steps: at each of their nodes (fractions of a step), and the step's length."""
        begin, length = steps.begin, steps.length
        curves = [self.at(begin + node * length, begin + 0.5 * length) for node in nodes]
        return np.hstack([*curves, length[:, None]])

    @property
    def assumptions(self) -> list[str]:
        """How the curves run between rows, for the report."""
        table = self.table
        if table is None:
            return []
        kinds = {curve.kind for curve in self.curves}
        parts = [f"table {table.file or 'of arrays'}: {len(table.time)} rows over {table.duration:.6g} s"]
        if first := table.origin + float(table.time[0]):
            parts.append(f"its first row, {first:.6g} s, is time 0")
        if kinds & {REFERENCE, RATE}:
            parts.append("references are cubic splines" + (", with their slopes for speeds" if RATE in kinds else ""))
        if LOAD in kinds:
            parts.append(f"torques and wrenches between rows are {'held until the next' if self.held else 'straight'}")
        return ["; ".join(parts)]


class Piece(NamedTuple):
    """N steps in a row [s], how many whole steps are done at the end of each (0 within one), and if that is a row."""

    begin: Floats
    end: Floats
    length: Floats
    whole: NDArray[np.int64]
    row: NDArray[np.bool_]

    def recorded(self, every: int) -> NDArray[np.intp]:
        """Which of the steps are recorded: those that end at rows, and every so many whole ones."""
        return np.flatnonzero(self.row | (self.whole % every == 0))


def pieces(rows: Floats, h: float, count: int, size: int) -> Iterator[Piece]:
    """Yield `count` whole steps of length h from 0 on, divided at increasing rows [s], `size` steps at a time."""
    nearest = np.rint(rows / h)
    apart = np.abs(rows - nearest * h) > NEAR * rows
    inner, outer = rows[apart], nearest[~apart].astype(np.int64)
    for first in range(0, count, size):
        numbers = np.arange(first, min(first + size, count))
        starts, last = numbers * h, (numbers[-1] + 1) * h
        inside = inner[slice(*np.searchsorted(inner, (starts[0], last)))]
        begin = np.sort(np.concatenate((starts, inside)))
        end = np.append(begin[1:], last)
        length, whole = end - begin, np.zeros(len(begin), np.int64)
        places = np.searchsorted(begin, starts)
        final = np.append(places[1:], len(begin)) - 1
        whole[final] = numbers + 1
        length[places[final == places]] = h
        row = whole == 0
        row[final[outer[slice(*np.searchsorted(outer, (first + 1, numbers[-1] + 2)))] - first - 1]] = True
        for k in range(0, len(begin), size):
            part = slice(k, k + size)
            yield Piece(begin[part], end[part], length[part], whole[part], row[part])
