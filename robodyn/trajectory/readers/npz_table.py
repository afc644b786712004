"""NumPy archives: one 1-D array per column, or matrices `q`, `qd`, `qdd` in coordinate order beside `time`."""

from __future__ import annotations

import os
import zipfile
from contextlib import ExitStack
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import TrajectoryError
from robodyn.support.input_file import open_input
from robodyn.trajectory.columns.header import check_columns
from robodyn.trajectory.columns.signals import matrix_column
from robodyn.trajectory.readers.table import ArrayTable, Table, check_expansion, common_length, decoding

_MATRICES = ("q", "qd", "qdd")
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


class NpzTable(ArrayTable):
    """The table in an `.npz` archive, stored or deflated: an array is read as a whole when a column of it is needed."""

    def __init__(self, path: str) -> None:
        self._members: list[tuple[str, int | None]] = []
        self._loaded: dict[str, NDArray[Any]] = {}
        Table.__init__(self, path)
        lengths: dict[str, int] = {}
        names: list[str] = []
        with ExitStack() as opened:
            stream = opened.enter_context(open_input(path))
            with decoding(".npz", path):
                if stream.peek(6).startswith(b"\x93NUMPY"):
                    raise ValueError("a single array, not an archive")
                archive = opened.enter_context(zipfile.ZipFile(stream))
                check_columns(len(archive.infolist()), path)
                for info in archive.infolist():
                    name, shape = info.filename.removesuffix(".npy"), _shape(archive, info, path)
                    parts = [None] if len(shape) == 1 else [*range(shape[1])]
                    self._members += [(info.filename, part) for part in parts]
                    columns = [name if part is None else matrix_column(name, part) for part in parts]
                    lengths |= dict.fromkeys(columns, shape[0])
                    names += columns
                expanded = sum(info.file_size for info in archive.infolist())
            self.size_bytes = os.stat(path).st_size
            check_expansion(expanded, self.size_bytes, path)
            self.names, self._rows, self._archive = tuple(names), common_length(lengths, path), archive
            self._opened = opened.pop_all()

    def column(self, i: int) -> NDArray[Any]:
        name, part = self._members[i]
        if name not in self._loaded:
            with decoding(".npz", self.file), self._archive.open(name) as stream:
                self._loaded[name] = np.lib.format.read_array(stream, allow_pickle=False)
        values = self._loaded[name]
        return values if part is None else values[:, part]

    def close(self) -> None:
        self._opened.close()


def _shape(archive: zipfile.ZipFile, info: zipfile.ZipInfo, file: str) -> tuple[int, ...]:
    """The shape of a member, which holds as many numbers as that says.

    Raises:
        TrajectoryError: it is not a column, or matrix q, qd or qdd, of numbers.
        ValueError: it is not what NumPy writes; also all that `zipfile` raises.
    """
    if info.compress_type not in _METHODS:
        raise ValueError(f"{info.filename} is compressed by a method that NumPy does not use")
    with archive.open(info) as stream:
        version = np.lib.format.read_magic(stream)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, dtype = read(stream)
        head = stream.tell()
    name = info.filename.removesuffix(".npy")
    if dtype.hasobject:
        raise ValueError("Object arrays cannot be loaded")
    if dtype.kind not in "fiu":
        raise TrajectoryError(f"array {name!r} holds {dtype}, not numbers", remedy="store float64", file=file)
    if not (len(shape) == 1 or (len(shape) == 2 and name in _MATRICES)):
        remedy = "give one 1-D array per column, or time (N,) and matrices q, qd, qdd (N, n)"
        raise TrajectoryError(f"array {name!r} has shape {shape}", remedy=remedy, file=file)
    values = int(np.prod(shape, dtype=object))
    if info.file_size != head + values * dtype.itemsize or shape[-1] > info.file_size:
        raise ValueError(f"{info.filename} holds fewer or more values than it says")
    return tuple(shape)
