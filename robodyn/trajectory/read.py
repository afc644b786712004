"""Motions of a robot from files and arrays: the door to this room.

`read_motion` and `motion` say what the robot requires (`signals`) and open the table by its suffix (`formats/`). Of
each block `columns/` says what its numbers are, `derivatives/` derives what is missing, compares what is given with the
positions and stops joints that stand still, and `plausible.py` judges the units. `options.py` is how a person wants a
table read, `motion.py` what comes out, `write.py` writes tables.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import Caveat, InputError, TrajectoryError
from robodyn.robot.kinematics import Values, configuration, rates
from robodyn.robot.model import Joint, Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT as EMPTY
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import count, listed
from robodyn.trajectory.columns.layout import ABSENT, Header, listing, resolve
from robodyn.trajectory.columns.signals import AngleUnit, Kind, Signal, Signals, TimeUnit, matrix_column
from robodyn.trajectory.derivatives.groups import anew, given, missing
from robodyn.trajectory.derivatives.standstill import REACH, Standstill
from robodyn.trajectory.formats.table import FILE_TYPES, READABLE, ArrayTable, Table, log_kind, reason
from robodyn.trajectory.motion import FEW, Sampling, Trajectory, cut, join, with_neighbours
from robodyn.trajectory.options import DEFAULT, MODES, Derivatives, HoldGiven, Reading, hold_of
from robodyn.trajectory.plausible import Plausibility

if TYPE_CHECKING:
    from robodyn.trajectory.derivatives.derive import Plan
    from robodyn.trajectory.derivatives.given_rates import GivenRates

BLOCK_ROWS = 1 << 15
NORM_TOLERANCE = 1e-3  # deviation of a quaternion's norm from 1 above which it is reported
_PIECES, _PIECE_ROWS = 16, 4096
_COMPARED = 4, 1024
_AT_REST = (
    "one row is no motion: velocities and accelerations that it does not give are 0, as at rest "
    "(robodyn fbd ROBOT --at Q shows the forces on each body)"
)


def signals(model: Model, scene: Scene = EMPTY) -> Signals:
    """What the model requires of a trajectory."""
    dependent = tuple(body.joint.name for body in model.bodies if body.joint.mimics is not None)
    constraints = (*(loop.name for loop in scene.loops), *(contact.name for contact in scene.contacts))
    joints = tuple(_signal(model, joint) for joint in model.independent)

    def carriers(link: str) -> set[int]:
        found, i = set[int](), model.links[link].body if link in model.links else -1
        while i >= 0:
            found.add(i)
            i = model.parents[i]
        return found

    # the joints between a loop's two links and what carries both move it
    between = {i for loop in scene.loops for i in carriers(loop.to) ^ carriers(loop.link)}
    moving = {model.bodies[i].joint.coordinate for i in between}
    looped = tuple(joint.name for joint in model.independent if joint.coordinate in moving)
    return Signals(joints, dependent, looped, constraints)


def _signal(model: Model, joint: Joint) -> Signal:
    """A joint as a signal; its limits are those of joints that mimic it, too, where all can be kept."""
    lower, upper = -inf, inf
    for each in (body.joint for body in model.bodies if body.joint.coordinate == joint.coordinate):
        ends = [-inf if each.lower is None else each.lower, inf if each.upper is None else each.upper]
        if each.multiplier and ends[0] < ends[1] and joint.kind != "floating":
            low, high = sorted((end - each.offset) / each.multiplier for end in ends)
            if max(low, lower) <= min(high, upper):
                lower, upper = max(low, lower), min(high, upper)
    kinds: dict[str, Kind] = {"floating": "floating", "prismatic": "length"}
    kind = kinds.get(joint.kind, "continuous" if joint.continuous else "angle")
    return Signal(joint.name, kind, lower, upper, joint.velocity or inf)


def read_motion(
    path: str | os.PathLike[str],
    model: Model,
    scene: Scene = EMPTY,
    *,
    derivatives: Derivatives = "auto",
    ignore_extra: bool = False,
    hold: HoldGiven | None = None,
    columns: Mapping[str, str] | None = None,
    time_unit: TimeUnit | None = None,
    angle_unit: AngleUnit | None = None,
    topic: str | None = None,
    measured: bool = False,
    encoder_error: float = 0.0,
) -> TrajectoryReader:
    """A reader of the motion of this robot in this scene, for `torques`; joints of loops may be without columns.

    Args:
        path: `.csv`, `.parquet` or `.npz`; a bag of ROS (`.db3`, `.mcap`, `.bag`, or a folder) or messages of ROS
            (`.yaml`, `.json`); `-` is standard input.
        derivatives: how missing velocities and accelerations are derived: "auto", "anew" (also those that are given),
            "given" (not at all), "spline", "savgol" or "central".
        ignore_extra: leave unknown columns out instead of refusing them.
        hold: where joints without columns are held: "rest" (nearest to zero within the limits), a position for all, or
            positions by joint; None refuses them. Those of loops are held only by name.
        columns: our name -> the table's, such as {"q_elbow": "Elbow angle"}.
        time_unit, angle_unit: of columns whose names do not tell; None assumes s and rad, and doubts them where the
            motion could hardly be so.
        topic: of a bag; None: the only one with messages about joints.
        measured: read the torques that a log gives too: `extra["tau_<joint>"]` of its blocks [N m].
        encoder_error: the largest error of encoders that repeats with the angle [rad; m of slides], for error bars.

    Raises:
        TrajectoryError: the file cannot be read or its columns do not fit the robot.
    """
    refuse_others(model, scene)
    reading = Reading(
        derivatives, ignore_extra, hold_of(hold), columns or {}, time_unit, angle_unit, topic, measured, encoder_error
    )
    return open_trajectory(path, signals(model, scene), extra=scene.motion_columns, reading=reading)


def motion(
    model: Model,
    time: ArrayLike,
    q: ArrayLike | Mapping[str, ArrayLike],
    qd: ArrayLike | Mapping[str, ArrayLike] | None = None,
    qdd: ArrayLike | Mapping[str, ArrayLike] | None = None,
    *,
    scene: Scene = EMPTY,
    columns: Mapping[str, ArrayLike] | None = None,
    derivatives: Derivatives = "auto",
    time_unit: TimeUnit | None = None,
    angle_unit: AngleUnit | None = None,
    encoder_error: float = 0.0,
) -> Trajectory:
    """A motion of this robot from arrays, for `torques`; velocities and accelerations that are left out are derived.

    Args:
        time: (N,) s, increasing.
        q: (N, nq) rad or m; qd, qdd: (N, n) per s and per s^2; in the order of `model.coordinates` and `model.rates`.
            Or (N,) by coordinate or rate: what is left out follows from the loops of the scene.
        scene: with the loops that tell what is left out.
        columns: (N,) values of the columns that the scene's wrenches and contacts name.
        derivatives, time_unit, angle_unit, encoder_error: as for `read_motion`.

    Raises:
        TrajectoryError: an array has the wrong shape or is not finite, or time does not increase.
    """
    refuse_others(model, scene)
    reading = Reading(derivatives, time_unit=time_unit, angle_unit=angle_unit, encoder_error=encoder_error)
    return from_arrays(signals(model, scene), time, q, qd, qdd, columns, reading)


def pose(model: Model, q: Values = (), qd: Values = (), qdd: Values = (), scene: Scene = EMPTY) -> Trajectory:
    """Return one state as a motion of one sample: values in order or by name [rad or m, per s, per s^2], 0 if left out.

    Raises:
        InputError: as `configuration` and `rates`; or the scene needs columns of a trajectory, which a pose has not.
    """
    if scene.motion_columns:
        what = f"the scene names columns of a trajectory, {listed(scene.motion_columns)}, which a pose has not"
        raise InputError(what, remedy="give numbers in the scene, or a trajectory")
    state = configuration(model, q), rates(model, qd or ()), rates(model, qdd or ())
    if isinstance(q, Mapping) and scene.loops:  # which tell the other joints
        parts = [dict(part) if isinstance(part, Mapping) else {} for part in (q, qd, qdd)]
        still = dict.fromkeys(parts[0], 0.0)
        given = [{name: [x] for name, x in part.items()} for part in (parts[0], still | parts[1], still | parts[2])]
        return motion(model, [0.0], *given, scene=scene)
    return motion(model, [0.0], *(each[None] for each in state), scene=scene)


def sources_of(block: Trajectory, scene: Scene) -> dict[str, Floats]:
    """The arrays of a block as programs read them."""
    extra = [block.extra[name] for name in scene.columns]
    columns = np.stack(extra, axis=1) if extra else np.empty((len(block), 0))
    return {"q": block.q, "qd": block.qd, "qdd": block.qdd, "columns": columns}


def open_trajectory(
    path: str | os.PathLike[str],
    signals: Signals,
    *,
    extra: Sequence[str] = (),
    reading: Reading = DEFAULT,
    block_rows: int = BLOCK_ROWS,
) -> TrajectoryReader:
    """A reader of a file of `open_table`, with the columns `extra` that the scene names; raises as `read_motion`."""
    table = open_table(path, reading.topic)
    try:
        return TrajectoryReader(table, signals, extra, reading, block_rows)
    except BaseException:
        table.close()
        raise


def from_arrays(
    signals: Signals,
    time: ArrayLike,
    q: ArrayLike | Mapping[str, ArrayLike],
    qd: ArrayLike | Mapping[str, ArrayLike] | None = None,
    qdd: ArrayLike | Mapping[str, ArrayLike] | None = None,
    extra: Mapping[str, ArrayLike] | None = None,
    reading: Reading = DEFAULT,
) -> Trajectory:
    """A trajectory from arrays as of `motion`, and columns that the scene names, checked and derived as from a file."""
    # stamps that are whole numbers stay such, for an origin to be subtracted exactly
    whole = isinstance(time, np.ndarray) and time.dtype.kind in "iu" and time.ndim == 1
    columns = {"time": np.asarray(time) if whole else _array("time", time, None)}
    widths = {"q": len(signals.positions), "qd": len(signals.velocities), "qdd": len(signals.velocities)}
    for (name, width), values in zip(widths.items(), (q, qd, qdd), strict=True):
        if isinstance(values, Mapping):
            columns |= {f"{name}_{stem}": _array(f"{name}[{stem!r}]", each, None) for stem, each in values.items()}
        elif values is not None:
            matrix = _array(name, values, width)
            columns |= {matrix_column(name, i): matrix[:, i] for i in range(width)}
    columns |= {name: _array(name, values, None) for name, values in (extra or {}).items()}
    with TrajectoryReader(ArrayTable(None, columns), signals, tuple(extra or ()), reading) as reader:
        return join(list(reader.blocks()))


def _array(name: str, values: ArrayLike, width: int | None) -> Floats:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise TrajectoryError(f"{name} is not an array of numbers", remedy="give floats") from None
    if array.shape[1:] != (() if width is None else (width,)) or array.ndim == 0:
        wanted = "(N,)" if width is None else f"(N, {width})"
        raise TrajectoryError(f"{name} has shape {array.shape}", remedy=f"it should be {wanted}")
    return array


def open_table(path: str | os.PathLike[str], topic: str | None = None) -> Table:
    """The table in a file, by its suffix, a bag of ROS with this topic or a file of messages; `-` and descriptors, as
    `<(zcat log.csv.gz)` of shells, are CSV. Raises where it cannot be opened, or is not of that type."""
    name = os.fspath(path)
    piped = name == "-" or name.startswith(("/dev/stdin", "/dev/fd/"))
    kind = "csv" if piped else log_kind(name) or FILE_TYPES.get(os.path.splitext(name)[1].lower())
    if topic is not None and kind != "bag":
        raise TrajectoryError("has no topics", remedy="--topic is for bags: .db3, .mcap, .bag", file=name)
    if kind is None:
        what = "unknown type of table by this suffix"
        raise TrajectoryError(what, remedy=f"suffixes: {' '.join(READABLE)}", file=name)
    try:
        if kind == "bag":
            from robodyn.trajectory.formats.bags import bag_table

            return bag_table(name, topic)
        if os.path.isdir(name):
            raise TrajectoryError("is a directory", remedy="name a file", file=name)
        if kind == "messages":
            from robodyn.trajectory.formats.messages import LogTable, read_messages

            return LogTable(name, read_messages(name))
        if kind == "csv":
            from robodyn.trajectory.formats.csv_table import CsvTable

            return CsvTable(name)
        from robodyn.trajectory.formats.binary_tables import NpzTable, ParquetTable

        return ParquetTable(name) if kind == "parquet" else NpzTable(name)
    except OSError as error:
        raise TrajectoryError(f"cannot be read: {reason(error)}", file=name) from None
    except ValueError as error:  # an embedded null character in the name
        raise TrajectoryError(f"cannot be read: {error}", file=name) from None


class TrajectoryReader:
    """Samples of a table, block by block; also a context manager that closes the file.

    Attributes:
        file: as messages name it, None for arrays; size_bytes: its length.
        notes: assumptions made so far; caveats: what makes the units doubtful, by all that has been read.
        missing: joints whose velocities or accelerations are not given; followed: joints that loops tell.
    """

    def __init__(
        self,
        table: Table,
        signals: Signals,
        extra: Sequence[str] = (),
        reading: Reading = DEFAULT,
        block_rows: int = BLOCK_ROWS,
    ) -> None:
        self._mode = mode = reading.derivatives
        if mode not in (*MODES, "none"):
            raise TrajectoryError(f"unknown way to differentiate {mode!r}", remedy=f"one of {listing(MODES)}")
        if table.leaves_out:
            from robodyn.trajectory.formats.messages import whole_joints

            reading = replace(reading, ignore_extra=True, columns=whole_joints(reading.columns, table.names))
        self._table, self._signals, self._rows = table, signals, block_rows
        self._encoder_error = reading.encoder_error
        self.file, self.size_bytes = table.file, table.size_bytes
        header = Header(table.names, table.file, table.header_line)
        if header.labels:
            header = header.labelled(table.texts([*header.labels]))
        layout = resolve(header, signals, extra, reading)
        layout = anew(signals, layout) if mode == "anew" else layout
        table.choose(layout.needed)
        clock = layout.clock.begun(table.first(layout.clock.columns))
        table.origins = dict(zip(clock.columns, clock.origin, strict=False))  # which it subtracts from now on
        self._layout = layout = replace(layout, clock=clock)
        self._groups, assumptions = missing(signals, layout)
        self.missing = tuple(group.name for group in self._groups)
        self._told = given(signals, layout)
        if mode == "none":
            self._groups = self._told = ()
        if mode == "given" and self._groups:
            what = f"velocity or acceleration of {listing(self.missing)} is not given"
            raise header.error(what, "--derivatives auto derives what is missing")
        self.notes, self.followed = (*table.notes, *layout.notes, *assumptions), layout.followed
        self.caveats: tuple[Caveat, ...] = ()
        self._plan: Plan | None = None
        self._check: GivenRates | None = None
        self._open: Floats | None = None

    @property
    def position_bytes(self) -> int:
        return self._table.position_bytes

    def blocks(self) -> Iterator[Trajectory]:
        """Consecutive samples, at most `block_rows` at a time; each pass starts anew.

        Raises:
            TrajectoryError: a cell, a row or the time is wrong, or there are too few rows to differentiate.

        Accuracy: the limits of blocks change a derivative by at most 3e-11 of the largest.
        """
        try:
            yield from self._blocks()
        except OSError as error:
            raise TrajectoryError(f"cannot be read: {reason(error)}", file=self.file) from None
        except TrajectoryError as error:
            if error.file is not None or self.file is None:
                raise
            raise TrajectoryError(error.what, remedy=error.remedy, file=self.file) from None

    def _blocks(self) -> Iterator[Trajectory]:
        pieces = self._pieces(*(_PIECES, _PIECE_ROWS) if self._groups else _COMPARED)
        if self._groups:
            from robodyn.trajectory.derivatives.derive import plan

            mode = "auto" if self._mode == "anew" else self._mode
            self._plan = plan(self._groups, pieces, mode, self._encoder_error)
            self.notes = _each_once(self.notes, self._plan.notes)
        self._check = self._open = None
        if self._told and max(map(len, pieces), default=0) >= FEW:
            from robodyn.trajectory.derivatives.given_rates import against_positions, consistent

            self._open = None if self._groups else consistent(self._told, pieces)
            if self._open is None:
                self._check = against_positions(self._told, pieces, self._plan, self._encoder_error)
        known = self._plan.resolutions if self._plan else {}
        still = Standstill(self._signals, self._layout, pieces, known) if self._mode != "none" else None
        halo = max(max(self._plan.halo, REACH) if self._plan else 0, self._check.halo if self._check else 0)
        needed = 1 + max((group.order for group in self._groups), default=0)  # one more than the highest derivative
        plausible = Plausibility(self._signals, self._layout)
        for samples, start, stop in with_neighbours(self._samples(), halo):
            if len(samples) == 1 < needed:
                self._plan = None
                self.notes = _each_once(self.notes, [_AT_REST])
            elif len(samples) < needed:
                what = f"has {count(len(samples), 'row')}, too few to differentiate"
                remedy = f"give at least {needed} rows, or velocities and accelerations"
                raise TrajectoryError(what, remedy=remedy, file=self.file)
            block = self._completed(samples, still, slice(start, stop))
            plausible.update(block, rough=self._plan is None and bool(self.missing))
            self.caveats = (*plausible.caveats(), *(self._check.caveats if self._check else ()))
            derivation = self._plan.derivation if self._plan else None
            yield replace(block, derivation=derivation, notes=self.notes, caveats=self.caveats)

    def _completed(self, samples: Trajectory, still: Standstill | None, rows: slice) -> Trajectory:
        """Some rows with the missing columns, speeds of 0 where joints stand still, and how far they can be trusted."""
        known = None
        if self._plan:
            from robodyn.trajectory.derivatives.derive import derive, sampling

            samples, noise, off = derive(samples, self._plan)
            known = sampling(samples, self._plan, noise, off, rows)
        if self._check:
            known = self._check.trusted(samples, known, rows)
        elif self._open is not None:
            qdd = samples.qdd[rows]
            known = Sampling(self._open + 0.0 * qdd, 0.0 * qdd, 0.0 * self._open, (qdd**2).sum(axis=0))
        elif known and self._told:
            known = replace(known, unknown=True)
        samples = still.stopped(samples) if still else samples
        return replace(cut(samples, rows.start, rows.stop), sampling=known)

    def _samples(self) -> Iterator[Trajectory]:
        row, last_time = 1, -math.inf
        for block in filter(len, self._table.blocks(self._layout.needed, self._rows)):
            samples = self._assembled(block, row, last_time)
            self.notes = _each_once(self.notes, samples.notes)
            row, last_time = row + len(block), float(samples.time[-1])
            yield samples
        if row == 1:
            raise TrajectoryError("has no rows", remedy="give rows of numbers", file=self.file)

    def _pieces(self, count: int, rows: int) -> list[Trajectory]:
        """Runs of samples that stand for the table; bad rows are left for `blocks` to report."""
        pieces: list[Trajectory] = []
        for block in self._table.pieces(self._layout.needed, count, rows) if self._groups or self._told else ():
            if len(block) and np.isfinite(block).all():
                with suppress(TrajectoryError):
                    pieces.append(self._assembled(block, 1, -math.inf))
        return pieces

    def _assembled(self, block: Floats, first_row: int, last_time: float) -> Trajectory:
        """The samples in a block (k, len(layout.needed)), finite; absent columns are 0, or the identity. Raises where
        time does not increase from that of the row before it, or a quaternion is zero."""
        layout = self._layout
        clock, place = layout.clock, {column: i for i, column in enumerate(layout.needed)}
        stamps, *nano = (block[:, place[column]] for column in clock.columns)
        time = clock.seconds(stamps, *nano)
        before = np.concatenate(([last_time], time[:-1]))
        if (late := time <= before).any():
            i = int(np.argmax(late))
            relation = "repeats" if time[i] == before[i] else "is before"
            since = " s after the first stamp" if clock.origin else ""
            what = f"time {float(time[i])!r}{since} {relation} {float(before[i])!r} of the row before"
            raise self._table.error_at(first_row + i, what, "time must increase from row to row")
        q, qd, qdd = arrays = [np.zeros((len(block), len(of)), order="F") for of in (layout.q, layout.qd, layout.qdd)]
        for values, of in zip(arrays, (layout.q, layout.qd, layout.qdd), strict=True):
            for i, column in enumerate(of):
                if column != ABSENT:
                    cells = block[:, place[column]]
                    values[:, i] = cells / layout.parts[column] if column in layout.parts else cells
        for i, position in layout.held.items():
            q[:, i] = position
        return Trajectory(
            time,
            q,
            qd,
            qdd,
            extra={name: block[:, place[column]] for name, column in layout.extra.items()},
            first_row=first_row,
            notes=self._normalised(q, first_row),
            stamps=clock.given(stamps, time),
            origin=float(clock.start),
            held={self._signals.positions[i]: position for i, position in layout.held.items()},
            followed=layout.followed,
        )

    def _normalised(self, q: Floats, first_row: int) -> tuple[str, ...]:
        """Give the quaternions in q a norm of 1, and tell where one was off."""
        notes: list[str] = []
        for name, (columns, _) in self._signals.spans.items():
            if len(columns) == 1:
                continue
            turn = q[:, columns[3] : columns[-1] + 1]
            if self._layout.q[columns[3]] == ABSENT:
                turn[:, 3] = 1.0
            largest = np.abs(turn).max(axis=1, initial=0.0)
            if not largest.all():
                row, what = first_row + int(np.argmin(largest)), f"the quaternion of {name!r} is zero"
                raise self._table.error_at(row, what, "give a unit quaternion x y z w")
            turn /= largest[:, None]
            length = np.sqrt((turn**2).sum(axis=1))
            turn /= length[:, None]
            off = np.abs(length * largest - 1.0)
            if off.max(initial=0.0) > NORM_TOLERANCE:
                i = int(np.argmax(off))
                norm = length[i] * largest[i]
                notes.append(f"{name}: quaternions normalised; row {first_row + i} has norm {norm:.6g}")
        return tuple(notes)

    def close(self) -> None:
        self._table.close()

    def __enter__(self) -> TrajectoryReader:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _each_once(notes: Sequence[str], more: Sequence[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*notes, *more)))


def row_at(
    reader: TrajectoryReader, time: float, complete: Callable[[Trajectory], Trajectory] = lambda block: block
) -> Trajectory:
    """The sample nearest to `time` [s], the earlier of two as near, of blocks that `complete` fills in; raises before
    the first row or after the last."""
    first, best, last = math.nan, None, math.nan
    for block in map(complete, reader.blocks()):
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
