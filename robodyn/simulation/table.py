"""A table that drives a simulation: the columns that a scene names, and what they are between the rows."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import InputError, SceneError
from robodyn.robot.model import Model
from robodyn.scene.parts import Entry
from robodyn.scene.scene import Scene
from robodyn.simulation.rows import NEAR, Piece
from robodyn.support.floats import Floats
from robodyn.trajectory.columns.header import listing
from robodyn.trajectory.columns.signals import Signals
from robodyn.trajectory.columns.units import TimeUnit
from robodyn.trajectory.read import open_table
from robodyn.trajectory.reader import TrajectoryReader
from robodyn.trajectory.readers.table import ArrayTable
from robodyn.trajectory.reading import Reading

LOAD, REFERENCE, RATE = "load", "reference", "rate"


class Curve(NamedTuple):
    """A function of time made of a column: a torque or a part of a wrench, a reference, or a reference's rate."""

    column: str
    kind: str


@dataclass(frozen=True, eq=False)
class Table:
    """Rows of time and columns that a scene names.

    Attributes:
        time: (N,) s, increasing; a simulation begins at the first.
        columns: (N,) each.
        origin: the stamp [s] that time counts from; 0 where these are the stamps.
    """

    file: str | None
    time: Floats
    columns: Mapping[str, Floats]
    origin: float = 0.0

    @property
    def duration(self) -> float:
        return float(self.time[-1] - self.time[0])


Source = str | os.PathLike[str] | Mapping[str, ArrayLike] | Table


def read_table(
    source: Source,
    scene: Scene,
    columns: Mapping[str, str] | None = None,
    time_unit: TimeUnit | None = None,
) -> Table:
    """Return the columns that a scene names, of a file or of arrays.

    Args:
        source: a file that `robodyn torques` reads (`-` is standard input), arrays by name, `time` among them, or what
            has been read already.
        columns: the scene's name -> the table's; time_unit: of stamps whose column does not tell, s by default.

    Raises:
        TrajectoryError: the file cannot be read, a column is missing or not finite, or time does not increase.
        SceneError: the scene names no column.
    """
    if isinstance(source, Table):
        return source
    names = scene.table_columns
    if not names:
        what = "the scene names no column of the table"
        raise SceneError(what, remedy='write e.g. reference = "q_elbow" for a joint of [drive]')
    if isinstance(source, Mapping):
        file, table = None, ArrayTable(None, {name: np.asarray(x, float).ravel() for name, x in source.items()})
    else:
        table = open_table(source)  # type: ignore[assignment]
        file = os.fspath(source)
    reading = Reading(ignore_extra=True, columns=columns or {}, time_unit=time_unit)
    with TrajectoryReader(table, Signals(()), names, reading) as reader:
        blocks = list(reader.blocks())
    time = np.concatenate([block.time for block in blocks])
    found = {name: np.concatenate([block.extra[name] for block in blocks]) for name in names}
    return Table(file, time, found, blocks[0].origin)


def curves(scene: Scene) -> tuple[Curve, ...]:
    """Return what a scene takes from a table at every moment, each once."""
    return tuple(dict.fromkeys(_curves(scene)))


def _curves(scene: Scene) -> Iterator[Curve]:
    for wrench in scene.wrenches:
        yield from (Curve(name, LOAD) for name in wrench.columns)
    for drive in scene.drive.values():
        if isinstance(drive.torque, str):
            yield Curve(drive.torque, LOAD)
        if isinstance(drive.reference, str):
            if drive.kp:
                yield Curve(drive.reference, REFERENCE)
            if drive.kd and drive.speed is None:
                yield Curve(drive.reference, RATE)
        if isinstance(drive.speed, str) and drive.kd:
            yield Curve(drive.speed, REFERENCE)


def _begun(scene: Scene, table: Table) -> Scene:
    """Return the scene with the initial state in numbers."""

    def numbers(begun: Mapping[str, Entry]) -> Mapping[str, Entry]:
        return {name: float(table.columns[x][0]) if isinstance(x, str) else x for name, x in begun.items()}

    named = any(isinstance(x, str) for begun in (scene.initial_q, scene.initial_qd) for x in begun.values())
    return replace(scene, initial_q=numbers(scene.initial_q), initial_qd=numbers(scene.initial_qd)) if named else scene


class Signal:
    """The curves of a scene at any time of a simulation.

    References are cubic splines through the rows (not-a-knot), their rates the slopes of these. Torques and wrenches
    are straight between rows, or, where the scene holds them, those of the last row.

    Attributes:
        scene: with the initial state in numbers, those of the first row where columns are named.
    """

    def __init__(self, scene: Scene, model: Model, table: Table | None) -> None:
        """
        Raises:
            SceneError: the scene names columns and there is no table, or one without rows between which to be.
        """
        self.curves, self.table, self.held = curves(scene), table, scene.between_rows == "hold"
        if scene.table_columns and table is None:
            what = f"the scene names {listing(scene.table_columns)}, columns of a table"
            raise SceneError(what, remedy="give the table: --traj FILE")
        if table is not None and len(table.time) < 2:
            raise InputError("the table has one row", remedy="give two at least", file=table.file)
        self.scene = scene if table is None else _begun(scene, table)
        endless = {joint.name for joint in model.independent if joint.continuous}
        self._wrapped = {drive.reference for name, drive in scene.drive.items() if name in endless}

    @property
    def source(self) -> Mapping[str, Floats] | None:
        """The table as arrays by name; None where `scene` needs none."""
        if self.table is None or not self.scene.table_columns:
            return None
        return {"time": self.table.time, **self.table.columns}

    @cached_property
    def _splines(self) -> Callable[..., Floats]:
        """Of the columns of references, in the order of `_smooth`."""
        from scipy.interpolate import CubicSpline

        time, columns = self._rows
        values = [np.unwrap(columns[name]) if name in self._wrapped else columns[name] for name in self._smooth]
        return CubicSpline(time, np.column_stack(values))  # type: ignore[no-any-return]

    @cached_property
    def _smooth(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(curve.column for curve in self.curves if curve.kind != LOAD))

    @cached_property
    def _rows(self) -> tuple[Floats, Mapping[str, Floats]]:
        assert self.table is not None
        return self.table.time - self.table.time[0], self.table.columns

    def check_duration(self, duration: float) -> None:
        """Raise if the table ends before the simulation."""
        if self.table is not None and duration > self.table.duration * (1.0 + 1e-9):
            what = f"the table lasts {self.table.duration:.9g} s, the simulation {duration:.9g} s"
            raise InputError(what, remedy="give a shorter --duration, or none", file=self.table.file)

    def corners(self, knots: int = 1) -> Floats:
        """Return (N,) s, increasing: rows at which steps have to end, as torques jump there or their slopes do.

        Args:
            knots: of references, whose splines are smooth, only every so many rows.
        """
        if not self.curves:
            return np.empty(0)
        rows, columns = self._rows
        changes = np.zeros(len(rows), bool)
        for name in (curve.column for curve in self.curves if curve.kind == LOAD):
            if self.held:
                changes[1:] |= np.diff(columns[name]) != 0.0
            else:
                changes[1:-1] |= np.diff(np.diff(columns[name]) / np.diff(rows)) != 0.0
        if self._smooth:
            changes[knots::knots] = True
        return rows[changes]

    def at(self, time: Floats, within: Floats | None = None) -> Floats:
        """Return (N, curves) at N times [s] since the simulation began.

        Args:
            within: (N,) s, times between the same rows as those that are meant: what is held jumps at rows.
        """
        if not self.curves:
            return np.empty((len(time), 0))
        kinds = {curve.kind for curve in self.curves}
        smooth = {kind: self._splines(time, kind == RATE).T for kind in (REFERENCE, RATE) if kind in kinds}
        (rows, columns), meant = self._rows, time if within is None else within
        last = np.searchsorted(rows, meant * (1.0 + NEAR), side="right") - 1 if self.held else None

        def values(curve: Curve) -> Floats:
            if curve.kind != LOAD:
                return np.asarray(smooth[curve.kind][self._smooth.index(curve.column)])
            column = columns[curve.column]
            return np.asarray(np.interp(time, rows, column)) if last is None else column[last]

        return np.column_stack([values(curve) for curve in self.curves])

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
        between = "held until the next" if self.held else "straight"
        parts = [f"table {table.file or 'of arrays'}: {len(table.time)} rows over {table.duration:.6g} s"]
        if first := table.origin + float(table.time[0]):
            parts.append(f"its first row, {first:.6g} s, is time 0")
        if kinds & {REFERENCE, RATE}:
            parts.append("references are cubic splines" + (", with their slopes for speeds" if RATE in kinds else ""))
        if LOAD in kinds:
            parts.append(f"torques and wrenches between rows are {between}")
        return ["; ".join(parts)]
