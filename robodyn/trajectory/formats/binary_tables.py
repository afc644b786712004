"""NumPy archives, one array per column or matrices `q`, `qd`, `qdd` beside `time`; Parquet tables, by polars."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats
from robodyn.support.input_file import open_input
from robodyn.trajectory.columns.layout import check_columns
from robodyn.trajectory.columns.signals import matrix_column
from robodyn.trajectory.formats.table import ArrayTable, check_expansion, common_length, decoding, less

if TYPE_CHECKING:
    import polars as pl

_MATRICES = ("q", "qd", "qdd")
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_MARK = b"PAR1"


class NpzTable(ArrayTable):
    """The table in an `.npz` archive, stored or deflated: an array is read as a whole when a column of it is needed."""

    def __init__(self, path: str) -> None:
        super().__init__(path, {})
        self._members: list[tuple[str, int | None]] = []
        self._loaded: dict[str, NDArray[Any]] = {}
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
    """The shape of a member that is a column, or matrix q, qd or qdd, and holds as many numbers as that says."""
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


class ParquetTable(ArrayTable):
    """A Parquet file of columns of numbers. Integers, decimals and float32 become float64."""

    file: str
    _at_once = 1 << 17  # polars begins every time with the pages before

    def __init__(self, path: str) -> None:
        import polars as pl

        super().__init__(path, {})
        with open_input(path) as stream:
            first, self.size_bytes = stream.read(4), stream.seek(0, os.SEEK_END)
            stream.seek(max(0, self.size_bytes - 4))
            if self.size_bytes < 12 or not first == stream.read(4) == _MARK:
                raise TrajectoryError("is not a Parquet file, or is cut short", remedy="write it again", file=path)
        with _decoding(path):
            self._frame = pl.scan_parquet(os.path.abspath(path), glob=False, hive_partitioning=False)
            schema = self._frame.collect_schema()
            self.names, self._types = tuple(schema.names()), schema.dtypes()
            self._rows = int(self._frame.select(pl.len()).collect().item())
        check_expansion(8 * self._rows * len(self.names), self.size_bytes, path)

    def _slice(self, columns: Sequence[int], cut: slice) -> Floats:
        import polars as pl

        start, stop, _ = cut.indices(self._rows)
        rows = stop - start
        frame, values = self._frame_of(columns, start, rows), np.empty((len(columns), rows))
        with _decoding(self.file):
            if len(frame) != rows:
                raise ValueError("it holds fewer rows than it says")
            for i, series in zip(columns, frame, strict=True):
                whole = series.dtype.is_integer() and i in self.origins
                numbers = (series if whole else series.cast(pl.Float64)).to_numpy()
                values[columns.index(i)] = less(numbers, self.origins.get(i))
        return values.T

    def _frame_of(self, columns: Sequence[int], start: int, rows: int) -> pl.DataFrame:
        """Some rows of columns, all of which hold numbers."""
        for i in columns:
            if not self._types[i].is_numeric():
                what = f"column {self.names[i]!r} holds {str(self._types[i]).partition('(')[0].lower()}, not numbers"
                raise TrajectoryError(what, remedy="store it as float64", file=self.file)
        with _decoding(self.file):
            return self._frame.select([self.names[i] for i in columns]).slice(start, rows).collect()

    def first(self, columns: Sequence[int]) -> list[str | float]:
        row = self._frame_of(columns, 0, 1).rows()
        return [] if not row or None in row[0] else [*row[0]]


@contextmanager
def _decoding(file: str) -> Iterator[None]:
    """Tells whatever polars raises about a damaged file, panics too, as a TrajectoryError."""
    import polars as pl

    with decoding("Parquet", file):
        try:
            yield
        except pl.exceptions.PanicException:
            raise ValueError("its parts contradict each other") from None
