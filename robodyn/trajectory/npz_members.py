"""The arrays of a NumPy archive: what each holds, and its values, read row after row."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns import matrix_column

_MATRICES = ("q", "qd", "qdd")
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_PART = 1 << 12
"""Rows of a matrix that are read and transposed at once, in the cache."""


@dataclass(frozen=True)
class Member:
    """An array of an archive: a column of the table, or several.

    Args:
        info: where it stands.
        names: of its columns.
        rows: values in each.
        head: bytes before the values.
        dtype: of the values.
        by_columns: the columns of a matrix stand one after another, not its rows.
    """

    info: zipfile.ZipInfo
    names: tuple[str, ...]
    rows: int
    head: int
    dtype: np.dtype[Any]
    by_columns: bool


def member(archive: zipfile.ZipFile, info: zipfile.ZipInfo, file: str) -> Member:
    """What one file of an archive holds. Pickled objects are refused.

    Raises:
        TrajectoryError: it is not a column, or matrix q, qd or qdd, of numbers.
        ValueError: it is not what NumPy writes; also all that `zipfile` raises.
    """
    if info.compress_type not in _METHODS:
        raise ValueError(f"{info.filename} is compressed by a method that NumPy does not use")
    with archive.open(info) as stream:
        version = np.lib.format.read_magic(stream)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, fortran, dtype = read(stream)
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
    names = (name,) if len(shape) == 1 else tuple(matrix_column(name, i) for i in range(shape[1]))
    return Member(info, names, shape[0], head, dtype, fortran and len(shape) == 2)


class Values:
    """The values of a member, from its first row on; with the last of them `zipfile` compares the check sum.

    A matrix that is stored by columns is held in memory.
    """

    def __init__(self, archive: zipfile.ZipFile, member: Member) -> None:
        self._member, self._left = member, member.rows
        self._width = len(member.names)
        self._stream = archive.open(member.info)
        self._stream.read(member.head)
        self._held = self._read(member.rows).reshape(self._width, member.rows) if member.by_columns else None

    def take(self, rows: int) -> NDArray[Any]:
        """The next rows of each column, (columns, rows)."""
        start = self._member.rows - self._left
        self._left -= rows
        if self._held is not None:
            return self._held[:, start : start + rows]
        if self._width == 1:
            return self._read(rows)[None]
        columns = np.empty((self._width, rows), self._member.dtype)
        for first in range(0, rows, _PART):
            part = columns[:, first : first + _PART]
            part[:] = self._read(part.shape[1]).reshape(-1, self._width).T
        return columns

    def skip(self, rows: int) -> None:
        """Leave out rows."""
        self._left -= rows
        if self._held is None:
            self._stream.seek(rows * self._width * self._member.dtype.itemsize, 1)

    def _read(self, rows: int) -> NDArray[Any]:
        size = rows * self._width * self._member.dtype.itemsize
        data = self._stream.read(size)
        if len(data) != size:
            raise EOFError(f"{self._member.info.filename} is cut short")
        return np.frombuffer(data, self._member.dtype)

    def close(self) -> None:
        self._stream.close()
