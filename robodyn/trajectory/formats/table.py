"""A table of numbers: what every format offers to the reader, and tables whose columns are arrays in memory."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import InputError, TrajectoryError
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from decimal import Decimal

FILE_TYPES = {
    **dict.fromkeys((".csv", ".tsv", ".txt", ".dat"), "csv"),
    **dict.fromkeys((".parquet", ".pq"), "parquet"),
    ".npz": "npz",
}
"""The kind of table by the suffix of its file."""
BAGS, MESSAGES = (".db3", ".mcap", ".bag"), (".yaml", ".yml", ".json")  # of ROS
READABLE = (*FILE_TYPES, *BAGS, *MESSAGES)
METADATA = "metadata.yaml"  # what a folder has that is a bag of ROS 2

ALL_FINITE = "every cell must be finite: leave out such rows, or the whole column"

_EXPANDED, _RATIO = 1 << 28, 500  # bytes of numbers that are always read, and how many for each byte that is stored


class Table(ABC):
    """Columns of numbers, read a block of rows at a time, and what messages about them need.

    Attributes:
        file: as messages name it, None if there is no file.
        size_bytes, position_bytes: length of the file and how much of it has been read.
        origins: column -> number that is subtracted from it, exactly, before it becomes a double.
        leaves_out: whether columns that the robot does not know are left out, as those of a log of more than it.
        notes: on what was left out.
    """

    leaves_out = False
    notes: tuple[str, ...] = ()
    header_line: int | None = None
    size_bytes = position_bytes = 0
    names: tuple[str, ...]

    def __init__(self, file: str | None) -> None:
        self.file = file
        self.origins: Mapping[int, Decimal] = {}

    @abstractmethod
    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[Floats]:
        """Blocks (k, len(columns)) with 1 <= k <= rows, in order, every cell finite; columns contiguous but of text."""

    @abstractmethod
    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[Floats]:
        """Up to `count` runs of about `rows` consecutive rows, spread over the file; all of it where it is short."""

    @abstractmethod
    def first(self, columns: Sequence[int]) -> list[str | float]:
        """The first row of columns as it is written, with all digits; nothing if there is none."""

    def error_at(self, row: int, what: str, remedy: str | None = None) -> TrajectoryError:
        """An error about a data row, counted from 1, that says where the row stands in the file."""
        return TrajectoryError(f"row {row}: {what}", remedy=remedy, file=self.file)

    def texts(self, columns: Sequence[int]) -> dict[int, str]:
        """The text of columns that say the same in every row; nothing where there are numbers only."""
        return {}

    def choose(self, columns: Sequence[int]) -> None:  # noqa: B027
        """Hear which columns will be read; rows that lack one of them may be left out."""

    def close(self) -> None:  # noqa: B027
        """Give the file back, if one is open."""


class ArrayTable(Table):
    """Named columns (N,) in memory."""

    _at_once = 1  # rows that are read at once at least

    def __init__(self, file: str | None, columns: Mapping[str, Floats]) -> None:
        super().__init__(file)
        self._rows = common_length({name: len(values) for name, values in columns.items()}, file)
        self.names, self._arrays = tuple(columns), list(columns.values())

    def column(self, i: int) -> NDArray[Any]:
        """The values (N,) of a column, of any type of numbers."""
        return self._arrays[i]

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[Floats]:
        for begin in range(0, self._rows, max(rows, self._at_once)):
            part = self._slice(columns, slice(begin, begin + max(rows, self._at_once)))
            for start in range(0, len(part), rows):
                values, first = part[start : start + rows], begin + start + 1
                finite = np.isfinite(values)
                if not finite.all():
                    row, k = np.argwhere(~finite)[0]
                    said = "empty or NaN" if np.isnan(values[row, k]) else values[row, k]
                    what = f"column {self.names[columns[k]]!r} is {said}"
                    raise self.error_at(first + int(row), what, ALL_FINITE)
                self.position_bytes = self.size_bytes * (first - 1 + len(values)) // self._rows
                yield values

    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[Floats]:
        if not self._rows:
            return []
        starts, size = [0], self._rows
        if self._rows > count * rows:
            starts, size = np.linspace(0, self._rows - rows, count).astype(np.int64).tolist(), rows
        return [self._slice(columns, slice(start, start + size)) for start in starts]

    def _slice(self, columns: Sequence[int], cut: slice) -> Floats:
        """Rows of columns, each column contiguous."""
        values = np.empty((len(columns), len(range(*cut.indices(self._rows)))))
        with np.errstate(all="ignore"):
            for row, i in zip(values, columns, strict=True):
                row[:] = less(self.column(i)[cut], self.origins.get(i))
        return values.T

    def first(self, columns: Sequence[int]) -> list[str | float]:
        return [self.column(i)[0].item() for i in columns] if self._rows else []


def log_kind(name: str) -> Literal["bag", "messages"] | None:
    """Whether a name is that of a bag of ROS, as any folder may be that is not named like a table, or of messages."""
    lower = name.lower()
    if lower.endswith(BAGS) or os.path.isfile(os.path.join(name, METADATA)):
        return "bag"
    if os.path.isdir(name) and not lower.endswith((*FILE_TYPES,)):
        return "bag"
    return "messages" if lower.endswith(MESSAGES) else None


def reason(error: OSError) -> str:
    """What the system says, without the file name."""
    return (error.strerror or str(error)).lower()


@contextmanager
def decoding(format_name: str, file: str | None) -> Iterator[None]:
    """Tells what a library raises about a damaged file, of whatever class it is, as a TrajectoryError."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        first = str(error).strip().partition("\n")[0] or type(error).__name__
        what = f"cannot be read as {format_name}: {first}"
        raise TrajectoryError(what, remedy="write it again", file=file) from None


def check_expansion(held: int, stored: int, file: str) -> None:
    """Raise for a file that holds far more bytes than are stored: time alone, which never repeats, needs more."""
    if held > max(_EXPANDED, _RATIO * stored):
        what = f"{stored} bytes that hold {held} bytes of numbers, as only columns of one value do"
        raise TrajectoryError(what, remedy="is it a table of a motion?", file=file)


def common_length(lengths: Mapping[str, int], file: str | None) -> int:
    """The length of all columns, 0 if there are none; raises if they differ."""
    if not lengths:
        return 0
    longest, shortest = max(lengths, key=lengths.__getitem__), min(lengths, key=lengths.__getitem__)
    if lengths[longest] != lengths[shortest]:
        what = f"{longest!r} has {lengths[longest]} rows, {shortest!r} has {lengths[shortest]}"
        raise TrajectoryError(what, remedy="give every column the same length", file=file)
    return lengths[longest]


def less(values: NDArray[Any], origin: Decimal | None) -> NDArray[Any]:
    """Values less an origin, each rounded once."""
    if origin is None:
        return values
    return values.astype(np.int64) - int(origin) if values.dtype.kind in "iu" else values - float(origin)
