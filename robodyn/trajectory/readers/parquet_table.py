"""Parquet tables, through polars."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats
from robodyn.support.input_file import open_input
from robodyn.trajectory.readers.table import Table, check_expansion, check_finite, decoding, less, spread

if TYPE_CHECKING:
    import polars as pl

_MARK = b"PAR1"
_ROWS = 1 << 17
"""Rows that are decoded at once: polars begins every time with the pages before them."""


class ParquetTable(Table):
    """A Parquet file of columns of numbers; see `Table`. Integers, decimals and float32 become float64."""

    file: str

    def __init__(self, path: str) -> None:
        import polars as pl

        super().__init__(path)
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
        self.position_bytes = 0

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[Floats]:
        for begin in range(0, self._rows, max(rows, _ROWS)):
            part = self._values(columns, begin, min(max(rows, _ROWS), self._rows - begin))
            for start in range(0, len(part), rows):
                values = part[start : start + rows]
                check_finite(values, [self.names[i] for i in columns], begin + start + 1, self.error_at)
                self.position_bytes = self.size_bytes * (begin + start + len(values)) // self._rows
                yield values

    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[Floats]:
        cuts = spread(self._rows, count, rows) if self._rows else []
        return [self._values(columns, cut.start, cut.stop - cut.start) for cut in cuts]

    def _values(self, columns: Sequence[int], start: int, rows: int) -> Floats:
        import polars as pl

        frame, values = self._slice(columns, start, rows), np.empty((len(columns), rows))
        with _decoding(self.file):
            if len(frame) != rows:
                raise ValueError("it holds fewer rows than it says")
            for i, series in zip(columns, frame, strict=True):
                whole = series.dtype.is_integer() and i in self.origins
                numbers = (series if whole else series.cast(pl.Float64)).to_numpy()
                values[columns.index(i)] = less(numbers, self.origins.get(i))
        return values.T

    def _slice(self, columns: Sequence[int], start: int, rows: int) -> pl.DataFrame:
        """Some rows of columns, all of which hold numbers."""
        for i in columns:
            if not self._types[i].is_numeric():
                what = f"column {self.names[i]!r} holds {str(self._types[i]).partition('(')[0].lower()}, not numbers"
                raise TrajectoryError(what, remedy="store it as float64", file=self.file)
        with _decoding(self.file):
            return self._frame.select([self.names[i] for i in columns]).slice(start, rows).collect()

    def first(self, columns: Sequence[int]) -> list[str | float]:
        row = self._slice(columns, 0, 1).rows()
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
