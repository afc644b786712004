"""Text of a delimited table -> numbers, by two readers that accept the same cells.

A cell is a decimal number: digits with an optional sign, point and exponent; blanks around it are allowed. Hexadecimal,
`1_000`, quoted numbers, `nan` and `inf` are refused. Blank lines are skipped.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats
from robodyn.support.wording import count
from robodyn.trajectory.readers.table import ALL_FINITE

if TYPE_CHECKING:
    from decimal import Decimal

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


def parse(
    data: bytes,
    dialect: Dialect,
    columns: Sequence[int],
    line: Callable[[], int],
    fast: bool,
    origins: Mapping[int, Decimal],
) -> Floats:
    """The chosen columns of whole lines of text, (rows, len(columns)), every cell finite.

    Args:
        columns: ascending indices of the columns to read.
        line: gives the line number of the first line, for messages.
        fast: through polars; what polars cannot read without doubt is read line by line.
        origins: what to subtract from columns, exactly.

    Raises:
        TrajectoryError: naming the line and the column of the first bad cell.
    """
    if fast:
        values = _parse_fast(data, dialect, columns, origins)
        if values is not None:
            return values
    return _parse_lines(data, dialect, columns, line, origins)


def _less(cells: Sequence[bytes], origin: Decimal) -> list[float] | None:
    """Return numbers less an origin, each rounded once; None if a cell is none."""
    from decimal import Decimal, InvalidOperation

    try:
        found = None if any(b"_" in cell for cell in cells) else [Decimal(cell.decode().strip()) for cell in cells]
    except (InvalidOperation, ValueError):
        return None
    return None if found is None else [float(cell - origin) for cell in found]


def _parse_fast(data: bytes, dialect: Dialect, columns: Sequence[int], origins: Mapping[int, Decimal]) -> Floats | None:
    import polars as pl

    if not data.endswith(b"\n"):
        data += b"\n"  # polars overlooks a delimiter at the very end
    last = len(dialect.names) - 1
    if dialect.delimiter == BLANK:
        data = b"\n".join(b" ".join(line.split()) for line in data.split(b"\n"))
    if len(columns) <= last and data.count(dialect.delimiter) != last * (data.rstrip(b"\n").count(b"\n") + 1):
        return None
    schema: dict[str, pl.DataType] = {str(i): pl.Float64() for i in range(last + 1)}
    schema |= {str(i): pl.String() for i in ({last} - {*columns} | origins.keys())}
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
    for i, origin in origins.items():
        found = _less([str(cell).encode() for cell in frame[str(i)]], origin)
        if found is None:
            return None
        frame = frame.with_columns(pl.Series(str(i), found))
    values: Floats = frame.select(str(i) for i in columns).to_numpy()
    return values if np.isfinite(values).all() else None


def _parse_lines(
    data: bytes,
    dialect: Dialect,
    columns: Sequence[int],
    first_line: Callable[[], int],
    origins: Mapping[int, Decimal],
) -> Floats:
    width = len(dialect.names)
    far = [(columns.index(i), i, origin) for i, origin in origins.items()]
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
        for place, i, origin in far:
            (row[place],) = _less([cells[i]], origin) or [row[place]]
        rows.append(row)
    return np.array(rows, dtype=np.float64).reshape(-1, len(columns))


def _diagnose(cells: list[bytes], dialect: Dialect, columns: Sequence[int]) -> tuple[str, str] | None:
    """What is wrong with a line and what to do, None if nothing is."""
    if len(cells) != len(dialect.names):
        what = f"{count(len(cells), 'cell')} where the header names {len(dialect.names)} columns"
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
            return f"column {name!r}: {shown} is not finite", ALL_FINITE
        if math.isnan(value) or b"_" in cell:
            remedy = "write decimals with a point" if b"," in cell else "cells are decimal numbers such as -1.5e-3"
            return f"column {name!r}: {shown} is not a number", remedy
    return None
