"""NumPy archives: one 1-D array per column, or matrices `q`, `qd`, `qdd` in coordinate order beside `time`."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.support.input_file import open_input
from robodyn.trajectory.npz_members import Values, member
from robodyn.trajectory.table import FloatArray, check_expansion, check_finite, common_length, decoding, less, spread

if TYPE_CHECKING:
    from decimal import Decimal

_Sources = list[tuple[Values, list[tuple[int, int]]]]


class NpzTable:
    """The table in an `.npz` archive, stored or deflated; see `Table`. Every number becomes float64."""

    header_line = None

    def __init__(self, path: str) -> None:
        self.file = path
        self.size_bytes, self.position_bytes = os.stat(path).st_size, 0
        with ExitStack() as opened:
            stream = opened.enter_context(open_input(path))
            with decoding(".npz", self.file):
                if stream.peek(6).startswith(b"\x93NUMPY"):
                    raise ValueError("a single array, not an archive")
                self._archive = opened.enter_context(zipfile.ZipFile(stream))
                self._members = [member(self._archive, info, path) for info in self._archive.infolist()]
            self.names = tuple(name for each in self._members for name in each.names)
            check_expansion(sum(each.info.file_size for each in self._members), self.size_bytes, path)
            self._rows = common_length({name: each.rows for each in self._members for name in each.names}, path)
            self._opened = opened.pop_all()
        self.origins: Mapping[int, Decimal] = {}

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[FloatArray]:
        with ExitStack() as opened:
            sources = self._sources(columns, opened)
            for start in range(0, self._rows, rows):
                values = self._take(sources, min(rows, self._rows - start), columns)
                check_finite(values, [self.names[i] for i in columns], start + 1, self.error_at)
                self.position_bytes = self.size_bytes * (start + len(values)) // self._rows
                yield values

    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[FloatArray]:
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

    def texts(self, columns: Sequence[int]) -> dict[int, str]:
        """There are numbers only."""
        return {}

    def _take(self, sources: _Sources, rows: int, columns: Sequence[int]) -> FloatArray:
        """The next rows of all sources."""
        block, origins = np.empty((len(columns), rows)), [self.origins.get(i) for i in columns]
        with decoding(".npz", self.file), np.errstate(all="ignore"):
            for values, pairs in sources:
                found = values.take(rows)
                for component, place in pairs:
                    block[place] = less(found[component], origins[place])
        return block.T

    def error_at(self, row: int, what: str, remedy: str | None = None) -> TrajectoryError:
        return TrajectoryError(f"row {row}: {what}", remedy=remedy, file=self.file)

    def close(self) -> None:
        self._opened.close()
