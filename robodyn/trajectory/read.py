"""Motions of a robot from files and arrays: the door to this room.

`read_motion` and `motion` say what the robot requires (`signals`; its `find` in `columns/signals.py` tells a column),
open the table by its suffix (`readers/`) and hand it to `reader.py`, which tells the steps of a block. `reading.py` is
how a person wants it read, `motion.py` what comes out, `write.py` writes tables.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import TrajectoryError
from robodyn.robot.model import Joint, Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT as EMPTY
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.trajectory.columns.signals import AngleUnit, Kind, Signal, Signals, TimeUnit, matrix_column
from robodyn.trajectory.motion import Trajectory, join
from robodyn.trajectory.reader import BLOCK_ROWS, TrajectoryReader
from robodyn.trajectory.readers.table import FILE_TYPES, READABLE, ArrayTable, Table, log_kind, reason
from robodyn.trajectory.reading import DEFAULT, Derivatives, HoldGiven, Reading, hold_of


def signals(model: Model, scene: Scene = EMPTY) -> Signals:
    """What the model wants to read from a trajectory."""
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


def sources_of(block: Trajectory, scene: Scene) -> dict[str, Floats]:
    """The arrays of a block as programs read them."""
    extra = [block.extra[name] for name in scene.columns]
    columns = np.stack(extra, axis=1) if extra else np.empty((len(block), 0))
    return {"q": block.q, "qd": block.qd, "qdd": block.qdd, "columns": columns}


def open_trajectory(
    path: str | os.PathLike[str],
    signals: Signals,
    *,
    file_type: str | None = None,
    extra: Sequence[str] = (),
    reading: Reading = DEFAULT,
    block_rows: int = BLOCK_ROWS,
) -> TrajectoryReader:
    """A reader of the trajectory in a file of `open_table`, with the columns `extra` that the scene names; raises if it
    cannot be read or its columns do not fit the robot."""
    table = open_table(path, file_type, reading.topic)
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


def open_table(path: str | os.PathLike[str], file_type: str | None = None, topic: str | None = None) -> Table:
    """The table in a file (`FILE_TYPES`, by its suffix if None), a bag of ROS with this topic or a file of messages;
    `-` is standard input (CSV). Raises where it cannot be opened, or is not of that type."""
    name = os.fspath(path)
    log = log_kind(name) if file_type is None else None
    if topic is not None and log != "bag":
        raise TrajectoryError("has no topics", remedy="--topic is for bags: .db3, .mcap, .bag", file=name)
    kind = file_type or ("csv" if name == "-" else FILE_TYPES.get(os.path.splitext(name)[1].lower()))
    known = sorted(set(FILE_TYPES.values()))
    if kind not in known and log is None:
        what = f"unknown type of table {file_type!r}" if file_type else "unknown type of table by this suffix"
        remedy = f"types: {', '.join(known)}" if file_type else f"suffixes: {' '.join(READABLE)}"
        raise TrajectoryError(what, remedy=remedy, file=name)
    try:
        if log == "bag":
            from robodyn.trajectory.readers.bags import bag_table

            return bag_table(name, topic)
        if log == "messages":
            from robodyn.trajectory.readers.messages import LogTable, read_messages

            return LogTable(name, read_messages(name))
        if os.path.isdir(name):
            raise TrajectoryError("is a directory", remedy="name a file", file=name)
        if kind == "csv":
            from robodyn.trajectory.readers.csv_table import CsvTable

            return CsvTable(name)
        if kind == "parquet":
            from robodyn.trajectory.readers.binary_tables import ParquetTable

            return ParquetTable(name)
        from robodyn.trajectory.readers.binary_tables import NpzTable

        return NpzTable(name)
    except OSError as error:
        raise TrajectoryError(f"cannot be read: {reason(error)}", file=name) from None
    except ValueError as error:  # an embedded null character in the name
        raise TrajectoryError(f"cannot be read: {error}", file=name) from None
