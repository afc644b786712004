"""NumPy archives: one 1-D array per column, or matrices `q`, `qd`, `qdd` in coordinate order beside `time`."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats
from robodyn.support.input_file import open_input
from robodyn.trajectory.columns import matrix_column
from robodyn.trajectory.header import check_columns
from robodyn.trajectory.table import Table, check_expansion, check_finite, common_length, decoding, less, spread

_MATRICES = ("q", "qd", "qdd")
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_PART = 1 << 12
"""Rows of a matrix that are read and transposed at once, in the cache."""
_SKIPPED = 1 << 24
"""Bytes that are read at once to be left out."""


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
        """Leave out rows, by reading them: `seek` of Python 3.13 moves from where another member was read last."""
        self._left -= rows
        left = rows * self._width * self._member.dtype.itemsize if self._held is None else 0
        while left and (part := self._stream.read(min(left, _SKIPPED))):
            left -= len(part)

    def _read(self, rows: int) -> NDArray[Any]:
        size = rows * self._width * self._member.dtype.itemsize
        data = self._stream.read(size)
        if len(data) != size:
            raise EOFError(f"{self._member.info.filename} is cut short")
        return np.frombuffer(data, self._member.dtype)

    def close(self) -> None:
        self._stream.close()


_Sources = list[tuple[Values, list[tuple[int, int]]]]


class NpzTable(Table):
    """The table in an `.npz` archive, stored or deflated; see `Table`. Every number becomes float64."""

    def __init__(self, path: str) -> None:
        super().__init__(path)
        self.size_bytes, self.position_bytes = os.stat(path).st_size, 0
        with ExitStack() as opened:
            stream = opened.enter_context(open_input(path))
            with decoding(".npz", self.file):
                if stream.peek(6).startswith(b"\x93NUMPY"):
                    raise ValueError("a single array, not an archive")
                self._archive = opened.enter_context(zipfile.ZipFile(stream))
                check_columns(len(self._archive.infolist()), self.file)
                self._members = [member(self._archive, info, path) for info in self._archive.infolist()]
            self.names = tuple(name for each in self._members for name in each.names)
            check_expansion(sum(each.info.file_size for each in self._members), self.size_bytes, path)
            self._rows = common_length({name: each.rows for each in self._members for name in each.names}, path)
            self._opened = opened.pop_all()

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[Floats]:
        with ExitStack() as opened:
            sources = self._sources(columns, opened)
            for start in range(0, self._rows, rows):
                values = self._take(sources, min(rows, self._rows - start), columns)
                check_finite(values, [self.names[i] for i in columns], start + 1, self.error_at)
                self.position_bytes = self.size_bytes * (start + len(values)) // self._rows
                yield values

    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[Floats]:
        found, done = [], 0
        with ExitStack() as opened:
            sources = self._sources(columns, opened)
            for cut in spread(self._rows, count, rows):
                with decoding(".npz", self.file):
                    for values, _ in sources:
                        values.skip(cut.start - done)
                found.append(self._take(sources, cut.stop - cut.start, columns))
                done = cut.stop
        return found

    def _sources(self, columns: Sequence[int], opened: ExitStack) -> _Sources:
        """The members that hold the columns, each with pairs (column of the member, place in the block)."""
        places = {column: place for place, column in enumerate(columns)}
        sources: _Sources = []
        first = 0
        for each in self._members:
            pairs = [(i, places[first + i]) for i in range(len(each.names)) if first + i in places]
            first += len(each.names)
            if pairs:
                with decoding(".npz", self.file):
                    sources.append((opened.enter_context(closing(Values(self._archive, each))), pairs))
        return sources

    def first(self, columns: Sequence[int]) -> list[str | float]:
        found: dict[int, str | float] = {}
        with ExitStack() as opened:
            for values, pairs in self._sources(columns, opened) if self._rows else ():
                with decoding(".npz", self.file):
                    row = values.take(1)
                found |= {place: row[component, 0].item() for component, place in pairs}
        return [found[place] for place in sorted(found)]

    def _take(self, sources: _Sources, rows: int, columns: Sequence[int]) -> Floats:
        """The next rows of all sources."""
        block, origins = np.empty((len(columns), rows)), [self.origins.get(i) for i in columns]
        with decoding(".npz", self.file), np.errstate(all="ignore"):
            for values, pairs in sources:
                found = values.take(rows)
                for component, place in pairs:
                    block[place] = less(found[component], origins[place])
        return block.T

    def close(self) -> None:
        self._opened.close()
