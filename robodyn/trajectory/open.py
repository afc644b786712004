"""Which format a table in a file has, and the table."""

from __future__ import annotations

import os

from robodyn.errors import TrajectoryError
from robodyn.support.extras import need
from robodyn.trajectory.table import Table, reason

FILE_TYPES = {
    ".csv": "csv",
    ".tsv": "csv",
    ".txt": "csv",
    ".dat": "csv",
    ".parquet": "parquet",
    ".pq": "parquet",
    ".npz": "npz",
}


def open_table(path: str | os.PathLike[str], file_type: str | None = None) -> Table:
    """The table in a file; `-` is standard input (CSV).

    Args:
        file_type: "csv", "parquet" or "npz"; by the suffix of the name if None.

    Raises:
        TrajectoryError: there is no such file, it cannot be opened, or it is not of that type.
    """
    name = os.fspath(path)
    kind = file_type or ("csv" if name == "-" else FILE_TYPES.get(os.path.splitext(name)[1].lower()))
    known = sorted(set(FILE_TYPES.values()))
    if kind not in known:
        what = f"unknown type of table {file_type!r}" if file_type else "unknown type of table by this suffix"
        remedy = f"types: {', '.join(known)}" if file_type else f"suffixes: {' '.join(FILE_TYPES)}"
        raise TrajectoryError(what, remedy=remedy, file=name)
    try:
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
