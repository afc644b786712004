"""Parquet tables, through polars."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from typing import BinaryIO, TypeVar

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.trajectory.table import FloatArray, check_finite, spread

T = TypeVar("T")
_MARK = b"PAR1"


class ParquetTable:
    """A Parquet file of columns of numbers; see `Table`. Integers and float32 become float64."""

    header_line = None

    def __init__(self, path: str) -> None:
        import polars as pl

        self.file = path
        with open(path, "rb") as stream:
            self.size_bytes = stream.seek(0, os.SEEK_END)
            if self.size_bytes < 12 or not _is_parquet(stream, self.size_bytes):
                raise TrajectoryError("is not a Parquet file, or is cut short", remedy="write it again", file=path)
        self._scan = self._guard(lambda: pl.scan_parquet(path, glob=False))
        self._schema = self._guard(self._scan.collect_schema)
        self.names = tuple(self._schema)
        self._rows = int(self._guard(lambda: self._scan.select(pl.len()).collect()).item())
        self.position_bytes = 0

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[FloatArray]:
        for start in range(0, self._rows, rows):
            values = self._read(columns, start, min(rows, self._rows - start))
            check_finite(values, [self.names[i] for i in columns], start + 1, self.error_at)
            self.position_bytes = self.size_bytes * (start + len(values)) // self._rows
            yield values

    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[FloatArray]:
        cuts = spread(self._rows, count, rows)
        return [self._read(columns, cut.start, cut.stop - cut.start) for cut in cuts]

    def _read(self, columns: Sequence[int], start: int, rows: int) -> FloatArray:
        import polars as pl

        names = [self.names[i] for i in columns]
        for name in names:
            if not self._schema[name].is_numeric():
                what = f"column {name!r} holds {self._schema[name]}, not numbers"
                raise TrajectoryError(what, remedy="store it as float64", file=self.file)
        part = self._scan.slice(start, rows).select(pl.col(names).cast(pl.Float64))
        values: FloatArray = np.asarray(self._guard(lambda: part.collect().to_numpy()), dtype=np.float64)
        if len(values) != rows:
            raise TrajectoryError("holds fewer rows than it says", remedy="write it again", file=self.file)
        return values

    def _guard(self, act: Callable[[], T]) -> T:
        """What `act` returns; whatever a damaged file makes polars raise becomes one TrajectoryError."""
        import polars as pl

        damage = (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError, ValueError, MemoryError)
        try:
            return act()
        except damage as error:
            first = str(error).strip().partition("\n")[0]
            what = f"cannot be read as Parquet: {first}"
            raise TrajectoryError(what, remedy="write it again", file=self.file) from None

    def error_at(self, row: int, what: str, remedy: str | None = None) -> TrajectoryError:
        return TrajectoryError(f"row {row}: {what}", remedy=remedy, file=self.file)

    def close(self) -> None:
        """Nothing is kept open."""


def _is_parquet(stream: BinaryIO, size: int) -> bool:
    stream.seek(0)
    first = stream.read(4)
    stream.seek(size - 4)
    return first == stream.read(4) == _MARK
