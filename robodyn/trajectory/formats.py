"""The formats of written tables."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import BinaryIO

import numpy as np

from robodyn.trajectory.table import FloatArray
from robodyn.trajectory.write_text import LARGE, lines_fast, lines_plain


class CsvFormat:
    """Comma-separated text with a header; through polars once the table is large."""

    def __init__(self) -> None:
        self._cells = 0

    def begin(self, stream: BinaryIO, names: Sequence[str]) -> None:
        header = io.StringIO()
        csv.writer(header, lineterminator="\n").writerow(names)
        stream.write(header.getvalue().encode())

    def add(self, stream: BinaryIO, values: FloatArray) -> None:
        self._cells += values.size
        stream.write(lines_fast(values) if self._cells > LARGE else lines_plain(values))

    def end(self, stream: BinaryIO) -> None:
        """All is written."""


class _Held:
    """Columns kept until the end."""

    def begin(self, stream: BinaryIO, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self._parts: list[FloatArray] = [np.empty((0, len(names)))]

    def add(self, stream: BinaryIO, values: FloatArray) -> None:
        self._parts.append(values)

    def columns(self) -> dict[str, FloatArray]:
        return {name: np.concatenate([part[:, i] for part in self._parts]) for i, name in enumerate(self._names)}


class ParquetFormat(_Held):
    """Parquet of float64 columns."""

    def end(self, stream: BinaryIO) -> None:
        import polars as pl

        try:
            pl.DataFrame(self.columns()).write_parquet(stream)
        except pl.exceptions.PolarsError as error:
            raise OSError(str(error).partition("\n")[0].rpartition("IO error: ")[2]) from None


class NpzFormat(_Held):
    """One float64 array per column."""

    def end(self, stream: BinaryIO) -> None:
        np.savez(stream, allow_pickle=False, **self.columns())
