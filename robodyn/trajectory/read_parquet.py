"""Parquet tables, through pyarrow, which refuses damaged files where other readers end the process."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats
from robodyn.support.input_file import open_input
from robodyn.trajectory.table import Table, changed, check_expansion, check_finite, decoding, less, spread

if TYPE_CHECKING:
    from decimal import Decimal

_MARK = b"PAR1"
_TEXTS = 1 << 14
_BUFFER = 1 << 16
"""Bytes of a column that are read at once; without it, and with buffering ahead, memory would grow with the file."""


class ParquetTable(Table):
    """A Parquet file of columns of numbers; see `Table`. Integers, decimals and float32 become float64.

    In memory are a block and a few pages of each column; where pages have less than 16 kB, a row group as it is stored.
    """

    def __init__(self, path: str) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        super().__init__(path)
        with open_input(path) as stream:
            self.size_bytes = stream.seek(0, os.SEEK_END)
            if self.size_bytes < 12 or not _is_parquet(stream, self.size_bytes):
                raise TrajectoryError("is not a Parquet file, or is cut short", remedy="write it again", file=path)
        with decoding("Parquet", self.file):
            self._source = pq.ParquetFile(pa.OSFile(path), buffer_size=_BUFFER, pre_buffer=False)
            schema, metadata = self._source.schema_arrow, self._source.metadata
            self.names: tuple[str, ...] = tuple(schema.names)
            self._types = schema.types
            self._groups = [metadata.row_group(i).num_rows for i in range(metadata.num_row_groups)]
            self._rows = sum(self._groups)
            if self._rows != metadata.num_rows:
                raise ValueError(f"it says {metadata.num_rows} rows, its row groups {self._rows}")
        check_expansion(8 * self._rows * len(self.names), self.size_bytes, path)
        self.position_bytes = 0

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[Floats]:
        names = self._numeric(columns)
        done = 0
        for batch in self._batches(names, rows):
            values = self._values(batch, names)
            check_finite(values, names, done + 1, self.error_at)
            done += len(values)
            self.position_bytes = self.size_bytes * done // max(done, self._rows)
            yield values
        if done != self._rows:
            raise TrajectoryError("holds fewer rows than it says", remedy="write it again", file=self.file)

    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[Floats]:
        """Each begins with a row group, or whole pieces after that, so that little else is decoded."""
        if self._rows <= 0:
            return []
        names, first_rows = self._numeric(columns), np.cumsum([0, *self._groups])
        cuts = spread(self._rows, count, rows)
        size = cuts[0].stop
        found = []
        for group, share in Counter(np.searchsorted(first_rows, [cut.start for cut in cuts], "right") - 1).items():
            wanted = {i * self._groups[group] // (share * size) for i in range(share)}
            batches = self._batches(names, size, range(group, len(self._groups)))
            numbered = zip(range(max(wanted) + 1), batches, strict=False)
            found += [self._values(batch, names) for number, batch in numbered if number in wanted]
        return found

    def _numeric(self, columns: Sequence[int]) -> list[str]:
        """The names of columns, all of which hold numbers."""
        from pyarrow import types

        for name, kind in ((self.names[i], self._types[i]) for i in columns):
            if not (types.is_integer(kind) or types.is_floating(kind) or types.is_decimal(kind)):
                shown = str(kind).removeprefix("large_").partition("<")[0]
                what = f"column {name!r} holds {shown}, not numbers"
                raise TrajectoryError(what, remedy="store it as float64", file=self.file)
        return [self.names[i] for i in columns]

    def _batches(self, names: list[str], rows: int, groups: Sequence[int] | None = None) -> Iterator[Any]:
        """Consecutive rows of these row groups, across their limits."""
        with decoding("Parquet", self.file):
            batches = self._source.iter_batches(batch_size=rows, row_groups=groups, columns=names)
        while True:
            with decoding("Parquet", self.file):
                batch = next(batches, None)
            if batch is None:
                return
            yield batch

    def first(self, columns: Sequence[int]) -> list[str | float]:
        names = self._numeric(columns)
        batch = next(self._batches(names, 1), None)
        row = [batch.column(name)[0].as_py() for name in names] if batch else []
        return [] if None in row else row

    def texts(self, columns: Sequence[int]) -> dict[int, str]:
        names = {i: self.names[i] for i in columns}
        found: dict[int, str] = {}
        row = 1
        for batch in self._batches([*names.values()], _TEXTS):
            for i, name in names.items():
                cells = [str(cell) for cell in batch.column(name).to_pylist()]
                if other := next((k for k, cell in enumerate(cells) if cell != found.setdefault(i, cells[0])), None):
                    raise self.error_at(row + other, *changed(name, cells[other], found[i]))
            row += len(batch)
        return found

    def _origin(self, name: str) -> Decimal | None:
        return self.origins.get(self.names.index(name)) if self.origins else None

    def _values(self, batch: Any, names: Sequence[str]) -> Floats:
        from pyarrow.types import is_integer

        values = np.empty((len(names), batch.num_rows))
        with decoding("Parquet", self.file):
            for i, name in enumerate(names):
                column, origin = batch.column(name), self._origin(name)
                if origin is None or not is_integer(column.type):
                    column = column.cast("float64", safe=False)
                values[i] = less(column.to_numpy(zero_copy_only=False), origin)
        return values.T

    def close(self) -> None:
        self._source.close(force=True)


def _is_parquet(stream: BinaryIO, size: int) -> bool:
    stream.seek(0)
    first = stream.read(4)
    stream.seek(size - 4)
    return first == stream.read(4) == _MARK
