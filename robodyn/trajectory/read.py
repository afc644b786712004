"""Trajectories from files and arrays: the door to this package."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import TrajectoryError
from robodyn.support.extras import need
from robodyn.support.floats import Floats
from robodyn.trajectory.assemble import join
from robodyn.trajectory.columns import Signals, matrix_column
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.reader import BLOCK_ROWS, TrajectoryReader
from robodyn.trajectory.reading import DEFAULT, Reading
from robodyn.trajectory.table import FILE_TYPES, READABLE, ArrayTable, Table, log_kind, reason


def open_trajectory(
    path: str | os.PathLike[str],
    signals: Signals,
    *,
    file_type: str | None = None,
    extra: Sequence[str] = (),
    reading: Reading = DEFAULT,
    block_rows: int = BLOCK_ROWS,
) -> TrajectoryReader:
    """A reader of the trajectory in a file.

    Args:
        path: `.csv .tsv .txt .dat`, `.parquet .pq` or `.npz`; a bag of ROS, `.db3 .mcap .bag` or a folder, or messages
            of ROS as `.yaml .yml .json`; `-` is standard input (CSV).
        signals: what the robot wants.
        file_type: "csv", "parquet" or "npz" if the suffix does not tell.
        extra: further columns to read, which the scene names.
        reading: how it is to be read.
        block_rows: samples held at a time.

    Raises:
        TrajectoryError: the file cannot be read or its columns do not fit the robot.
    """
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
    """A trajectory from arrays, checked and derived as one from a file.

    Args:
        time: (N,) s; q: (N, nq) rad, m; qd, qdd: (N, n), or (N,) by coordinate and rate; extra: (N,) columns that the
            scene names.

    Raises:
        TrajectoryError: an array has the wrong shape, is not finite, or time does not increase; a name is none.
    """
    columns = {"time": _stamps(time)}
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


def _stamps(time: ArrayLike) -> Floats:
    """Return stamps; whole numbers stay such, for an origin to be subtracted exactly."""
    stamps = np.asarray(time) if isinstance(time, np.ndarray) and time.dtype.kind in "iu" else None
    return _array("time", time, None) if stamps is None or stamps.ndim != 1 else stamps


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
    """The table in a file, a bag or a file of messages; `-` is standard input (CSV).

    Args:
        file_type: "csv", "parquet" or "npz"; by the suffix of the name if None.
        topic: of a bag; None: the only one that there is.

    Raises:
        TrajectoryError: there is no such file, it cannot be opened, or it is not of that type.
    """
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
            from robodyn.trajectory.read_bag import bag_table

            return bag_table(name, topic)
        if log == "messages":
            from robodyn.trajectory.read_message_text import message_table

            return message_table(name)
        if os.path.isdir(name):
            raise TrajectoryError("is a directory", remedy="name a file", file=name)
        if kind == "csv":
            from robodyn.trajectory.read_csv import CsvTable

            return CsvTable(name)
        if kind == "parquet":
            need("Parquet tables", "pyarrow", file=name)
            from robodyn.trajectory.read_parquet import ParquetTable

            return ParquetTable(name)
        from robodyn.trajectory.read_npz import NpzTable

        return NpzTable(name)
    except OSError as error:
        raise TrajectoryError(f"cannot be read: {reason(error)}", file=name) from None
    except ValueError as error:  # an embedded null character in the name
        raise TrajectoryError(f"cannot be read: {error}", file=name) from None
