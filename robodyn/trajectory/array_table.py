"""Tables whose columns are arrays in memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from robodyn.support.floats import Floats
from robodyn.trajectory.table import Rows, check_finite, common_length, less, spread

if TYPE_CHECKING:
    pass


class ArrayTable(Rows):
    """Named columns of equal length; see `Table`.

    Args:
        file: as messages name it, None if there is no file.
        columns: name -> (N,) array.

    Raises:
        TrajectoryError: the columns differ in length.
    """

    def __init__(self, file: str | None, columns: Mapping[str, Floats]) -> None:
        self._rows = common_length({name: len(values) for name, values in columns.items()}, file)
        super().__init__(file)
        self.names = tuple(columns)
        self._arrays = list(columns.values())

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[Floats]:
        for start in range(0, self._rows, rows):
            values = self._slice(columns, slice(start, start + rows))
            check_finite(values, [self.names[i] for i in columns], start + 1, self.error_at)
            yield values

    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[Floats]:
        return [self._slice(columns, cut) for cut in spread(self._rows, count, rows)]

    def _slice(self, columns: Sequence[int], cut: slice) -> Floats:
        return np.array([less(self._arrays[i][cut], self.origins.get(i)) for i in columns]).T

    def first(self, columns: Sequence[int]) -> list[str | float]:
        return [self._arrays[i][0].item() for i in columns] if self._rows else []

    def close(self) -> None:
        """Nothing is kept open."""
