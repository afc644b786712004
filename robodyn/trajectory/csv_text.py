"""Text of a delimited table -> numbers, by two readers that accept the same cells.

A cell is a decimal number: digits with an optional sign, point and exponent; blanks around it are allowed. Hexadecimal,
`1_000`, quoted numbers, `nan` and `inf` are refused. Blank lines are skipped.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import BytesIO

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.trajectory.table import FloatArray

BLANK = b" "
LARGE = 4_000_000
"""Bytes of a file above which importing polars (0.1 s) costs less than reading without it."""


@dataclass(frozen=True)
class Dialect:
    """How lines are cut into cells: the delimiter (BLANK: any run of blanks), the header, the name for messages."""

    delimiter: bytes
    names: tuple[str, ...]
    file: str

    def cells(self, line: bytes) -> list[bytes]:
        return line.split() if self.delimiter == BLANK else line.split(self.delimiter)


def parse(data: bytes, dialect: Dialect, columns: Sequence[int], line: Callable[[], int], fast: bool) -> FloatArray:
    """The chosen columns of whole lines of text, (rows, len(columns)), every cell finite.

    Args:
        columns: ascending indices of the columns to read.
        line: gives the line number of the first line, for messages.
        fast: through polars; what polars cannot read without doubt is read line by line.

    Raises:
        TrajectoryError: naming the line and the column of the first bad cell.
    """
    if fast:
        values = _parse_fast(data, dialect, columns)
        if values is not None:
            return values
    return _parse_lines(data, dialect, columns, line)


def _parse_fast(data: bytes, dialect: Dialect, columns: Sequence[int]) -> FloatArray | None:
    import polars as pl

    if not data.endswith(b"\n"):
        data += b"\n"  # polars overlooks a delimiter at the very end
    last = len(dialect.names) - 1
    if dialect.delimiter == BLANK:
        data = b"\n".join(b" ".join(line.split()) for line in data.split(b"\n"))
    if len(columns) <= last and data.count(dialect.delimiter) != last * (data.rstrip(b"\n").count(b"\n") + 1):
        return None
    schema: dict[str, pl.DataType] = {str(i): pl.Float64() for i in range(last + 1)}
    if last not in columns:
        schema[str(last)] = pl.String()
    try:
        frame = pl.read_csv(
            BytesIO(data),
            has_header=False,
            schema=schema,
            columns=sorted({*columns, last}),
            separator=dialect.delimiter.decode(),
            quote_char=None,
        )
    except pl.exceptions.PolarsError:
        return None
    if frame.to_series(-1).null_count():
        return None
    values: FloatArray = frame.select(str(i) for i in columns).to_numpy()
    return values if np.isfinite(values).all() else None


def _parse_lines(data: bytes, dialect: Dialect, columns: Sequence[int], first_line: Callable[[], int]) -> FloatArray:
    width = len(dialect.names)
    rows: list[list[float]] = []
    underscore = b"_" in data
    for number, line in enumerate(data.split(b"\n")):
        cells = dialect.cells(line)
        try:
            row = [float(cells[i]) for i in columns]
        except (ValueError, IndexError):
            row = [math.nan]
        if len(cells) != width or underscore or not all(map(math.isfinite, row)):
            if not line.strip():
                continue
            found = _diagnose(cells, dialect, columns)
            if found:
                raise TrajectoryError(found[0], remedy=found[1], file=dialect.file, line=first_line() + number)
        rows.append(row)
    return np.array(rows, dtype=np.float64).reshape(-1, len(columns))


def _diagnose(cells: list[bytes], dialect: Dialect, columns: Sequence[int]) -> tuple[str, str] | None:
    """What is wrong with a line and what to do, None if nothing is."""
    if len(cells) != len(dialect.names):
        what = f"{len(cells)} cell{'s' if len(cells) > 1 else ''} where the header names {len(dialect.names)} columns"
        return what, "repair the row"
    for i in columns:
        name, cell = dialect.names[i], cells[i].strip()
        shown = repr(cell[:40].decode("utf-8", "replace"))
        if not cell:
            return f"column {name!r} is empty", "give a number in every row"
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if cell.lower().lstrip(b"+-") in (b"nan", b"inf", b"infinity") or math.isinf(value):
            return f"column {name!r}: {shown} is not finite", "every cell must be finite"
        if math.isnan(value) or b"_" in cell:
            remedy = "write decimals with a point" if b"," in cell else "cells are decimal numbers such as -1.5e-3"
            return f"column {name!r}: {shown} is not a number", remedy
    return None
