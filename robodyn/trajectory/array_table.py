"""Tables whose columns are arrays in memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.trajectory.table import FloatArray, check_finite, spread


class ArrayTable:
    """Named columns of equal length; see `Table`.

    Args:
        file: as messages name it, None if there is no file.
        columns: name -> (N,) array.
        size_bytes: length of the file.

    Raises:
        TrajectoryError: the columns differ in length.
    """

    header_line = None

    def __init__(self, file: str | None, columns: Mapping[str, FloatArray], size_bytes: int = 0) -> None:
        lengths = {name: len(values) for name, values in columns.items()}
        if len(set(lengths.values())) > 1:
            longest, shortest = max(lengths, key=lengths.__getitem__), min(lengths, key=lengths.__getitem__)
            what = f"{longest!r} has {lengths[longest]} rows, {shortest!r} has {lengths[shortest]}"
            raise TrajectoryError(what, remedy="give every column the same length", file=file)
        self.file = file
        self.names = tuple(columns)
        self.size_bytes, self.position_bytes = size_bytes, 0
        self._arrays = list(columns.values())
        self._rows = max(lengths.values(), default=0)

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[FloatArray]:
        for start in range(0, self._rows, rows):
            values = self._slice(columns, slice(start, start + rows))
            check_finite(values, [self.names[i] for i in columns], start + 1, self.error_at)
            self.position_bytes = self.size_bytes * (start + len(values)) // self._rows
            yield values

    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[FloatArray]:
        return [self._slice(columns, cut) for cut in spread(self._rows, count, rows)]

    def _slice(self, columns: Sequence[int], cut: slice) -> FloatArray:
        return np.array([self._arrays[i][cut] for i in columns]).T

    def error_at(self, row: int, what: str, remedy: str | None = None) -> TrajectoryError:
        return TrajectoryError(f"row {row}: {what}", remedy=remedy, file=self.file)

    def close(self) -> None:
        """Nothing is kept open."""
