"""Comma-, semicolon-, tab- or blank-separated tables, read in chunks of whole lines.

A cell is a decimal number with an optional sign, point and exponent, blanks around it; hexadecimal, `1_000`, quoted
numbers, `nan` and `inf` are refused. polars reads large files; what it cannot read without doubt is read line by line,
which finds what is wrong.
"""

from __future__ import annotations

import csv
import math
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from io import BytesIO
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats
from robodyn.support.input_file import beyond, copied, limits, open_input
from robodyn.support.wording import count
from robodyn.trajectory.formats.table import ALL_FINITE, Table

if TYPE_CHECKING:
    from decimal import Decimal

BLANK = b" "
LARGE = 4_000_000  # bytes of a file above which importing polars (0.1 s) costs less than reading without it
_PART = 1 << 20
_MARKS = {b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16", b"\x1f\x8b": "gzip", b"PK": "zip", b"PA": "Parquet"}


class CsvTable(Table):
    """A delimited text file whose first line names the columns; pipes are copied first, to be read twice."""

    file: str
    header_line: int

    def __init__(self, path: str) -> None:
        super().__init__("<stdin>" if path == "-" else path)
        self._stream: BinaryIO = copied(sys.stdin.buffer, "<stdin>") if path == "-" else open_input(path, typed=True)
        try:
            if not self._stream.seekable():
                with self._stream as pipe:
                    self._stream = copied(pipe, path)
            self.size_bytes = self._stream.seek(0, os.SEEK_END)
            self._read_header()
        except BaseException:
            self._stream.close()
            raise

    def _read_header(self) -> None:
        self._stream.seek(0)
        text, self.header_line, longest = b"", 0, limits().csv_line_bytes
        while not text.strip():
            text = self._stream.readline(longest + 1)
            self._check_lines(text, lambda: self.header_line + 1)
            self.header_line += 1
            if self._stream.tell() - len(text) > longest:
                raise beyond("csv_line_bytes", "too many blank lines at the beginning", TrajectoryError, file=self.file)
            if not text:
                raise TrajectoryError("is empty", remedy="a header line and rows of numbers are needed", file=self.file)
        self._start = self.position_bytes = self._stream.tell()
        self.names, self._delimiter = self._columns(text)

    def _columns(self, first: bytes) -> tuple[tuple[str, ...], bytes]:
        """Names and delimiter from the header line: the first of , ; tab that makes several cells, else blanks."""
        mark = next((name for start, name in _MARKS.items() if first.startswith(start)), None)
        if (mark and not first.isascii()) or b"\0" in first:
            remedy = "give a CSV table in UTF-8, or name its type by the suffix"
            raise self.error_at(0, f"is {mark or 'binary'} data, not text", remedy)
        try:
            text = first.decode("utf-8-sig").strip().removeprefix("#").strip()
        except UnicodeDecodeError:
            raise self.error_at(0, "the header is not UTF-8 text", "save the table as UTF-8") from None
        delimiter = next((mark for mark in ",;\t" if mark in text), " ")
        try:
            cells = text.split() if delimiter == " " else next(csv.reader([text], delimiter=delimiter, strict=True))
        except (csv.Error, StopIteration) as error:
            remedy = "name the columns, quoted where a name has a comma"
            raise self.error_at(0, f"the header cannot be read: {error}", remedy) from None
        names = tuple(cell.strip() for cell in cells)
        with suppress(ValueError):
            if [*map(float, names)]:
                remedy = "begin with a line of names, e.g. time,q_<joint>,..."
                raise self.error_at(0, "no header: the first line holds numbers", remedy)
        return names, delimiter.encode()

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[Floats]:
        self._stream.seek(self._start)
        size, longest = max(_PART // 16, rows * 16 * len(self.names)), limits().csv_line_bytes
        while data := self._stream.read(size):
            offset = self._stream.tell() - len(data)
            if not data.endswith(b"\n"):
                data += self._stream.readline(longest + 1)
            after = self._stream.tell()
            self._check_lines(data, partial(self._line_at, offset))
            values = self._parsed(data, columns, offset)
            self.position_bytes = after
            for start in range(0, len(values), rows):
                yield values[start : start + rows]

    def _check_lines(self, data: bytes, first: Callable[[], int]) -> None:
        """Raise if one of these lines, the first of this number, is too long; in leaps from end to end."""
        start, longest = 0, limits().csv_line_bytes
        while start + longest < len(data):
            end = data.rfind(b"\n", start, start + longest + 1)
            if end < start:
                line = first() + data.count(b"\n", 0, start)
                raise beyond("csv_line_bytes", "too many bytes in a line", TrajectoryError, file=self.file, line=line)
            start = end + 1

    def _line_at(self, offset: int) -> int:
        self._stream.seek(0)
        line = 1
        while offset > 0 and (data := self._stream.read(min(offset, _PART))):
            offset -= len(data)
            line += data.count(b"\n")
        return line

    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[Floats]:
        self._stream.seek(self._start)
        first = self._stream.read(1 << 16)
        size = rows * max(1, len(first) // max(1, first.count(b"\n")))
        if self.size_bytes - self._start <= count * size:
            starts, size = [self._start], self.size_bytes
        else:
            step = (self.size_bytes - self._start - size) // (count - 1)
            starts = [self._start + i * step for i in range(count)]
        found = []
        for start in starts:
            self._stream.seek(start)
            if start > self._start:
                self._stream.seek(start - 1)
                self._stream.readline(limits().csv_line_bytes)
            data = self._stream.read(size)
            data = data[: data.rfind(b"\n") + 1] if self._stream.tell() < self.size_bytes else data
            try:
                self._check_lines(data, lambda: 0)
                found.append(self._parsed(data, columns, start))
            except TrajectoryError:  # told with its line when the blocks are read
                continue
        return found

    def _cells(self, line: bytes) -> list[bytes]:
        return line.split() if self._delimiter == BLANK else line.split(self._delimiter)

    def _parsed(self, data: bytes, columns: Sequence[int], offset: int) -> Floats:
        """The chosen columns of whole lines of text, (rows, len(columns)), every cell finite."""
        values = self._parsed_by_polars(data, columns) if self.size_bytes > LARGE else None
        return self._parsed_lines(data, columns, offset) if values is None else values

    def _parsed_by_polars(self, data: bytes, columns: Sequence[int]) -> Floats | None:
        import polars as pl

        if not data.endswith(b"\n"):
            data += b"\n"  # polars overlooks a delimiter at the very end
        last = len(self.names) - 1
        if self._delimiter == BLANK:
            data = b"\n".join(b" ".join(line.split()) for line in data.split(b"\n"))
        if len(columns) <= last and data.count(self._delimiter) != last * (data.rstrip(b"\n").count(b"\n") + 1):
            return None
        schema: dict[str, pl.DataType] = {str(i): pl.Float64() for i in range(last + 1)}
        schema |= {str(i): pl.String() for i in ({last} - {*columns} | self.origins.keys())}
        chosen, mark = sorted({*columns, last}), self._delimiter.decode()
        try:
            frame = pl.read_csv(
                BytesIO(data), has_header=False, schema=schema, columns=chosen, separator=mark, quote_char=None
            )
        except pl.exceptions.PolarsError:
            return None
        if frame.to_series(-1).null_count():
            return None
        for i, origin in self.origins.items():
            found = _less([str(cell).encode() for cell in frame[str(i)]], origin)
            if found is None:
                return None
            frame = frame.with_columns(pl.Series(str(i), found))
        values: Floats = frame.select(str(i) for i in columns).to_numpy()
        return values if np.isfinite(values).all() else None

    def _parsed_lines(self, data: bytes, columns: Sequence[int], offset: int) -> Floats:
        far = [(columns.index(i), i, origin) for i, origin in self.origins.items()]
        rows: list[list[float]] = []
        underscore = b"_" in data
        for number, line in enumerate(data.split(b"\n")):
            cells = self._cells(line)
            try:
                row = [float(cells[i]) for i in columns]
            except (ValueError, IndexError):
                row = [math.nan]
            if len(cells) != len(self.names) or underscore or not all(map(math.isfinite, row)):
                if not line.strip():
                    continue
                if found := self._fault(cells, columns):
                    at = self._line_at(offset) + number
                    raise TrajectoryError(found[0], remedy=found[1], file=self.file, line=at)
            for place, i, origin in far:
                (row[place],) = _less([cells[i]], origin) or [row[place]]
            rows.append(row)
        return np.array(rows, dtype=np.float64).reshape(-1, len(columns))

    def _fault(self, cells: list[bytes], columns: Sequence[int]) -> tuple[str, str] | None:
        """What is wrong with a line and what to do, None if nothing is."""
        if len(cells) != len(self.names):
            what = f"{count(len(cells), 'cell')} where the header names {len(self.names)} columns"
            return what, "repair the row"
        for i in columns:
            name, cell = self.names[i], cells[i].strip()
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

    def first(self, columns: Sequence[int]) -> list[str | float]:
        cells = next(self._rows(), [])
        return [cells[i].decode("utf-8", "replace") for i in columns] if len(cells) == len(self.names) else []

    def texts(self, columns: Sequence[int]) -> dict[int, str]:
        found: dict[int, str] = {}
        for row, cells in enumerate(self._rows(), 1):
            for i in columns if len(cells) == len(self.names) else ():
                text = cells[i].strip().decode("utf-8", "replace")
                if text != found.setdefault(i, text):
                    what = f"column {self.names[i]!r} is {text!r}, and {found[i]!r} in the rows before"
                    raise self.error_at(row, what, "give a column per joint")
        return found

    def _rows(self) -> Iterator[list[bytes]]:
        """The cells of each line that is not blank."""
        self._stream.seek(self._start)
        for line in iter(lambda: self._stream.readline(limits().csv_line_bytes), b""):
            if line.strip():
                yield self._cells(line)

    def error_at(self, row: int, what: str, remedy: str | None = None) -> TrajectoryError:
        self._stream.seek(self._start)
        line, seen = self.header_line, 0
        while seen < row and (text := self._stream.readline()):
            line += 1
            seen += bool(text.strip())
        return TrajectoryError(what, remedy=remedy, file=self.file, line=line)

    def close(self) -> None:
        self._stream.close()


def _less(cells: Sequence[bytes], origin: Decimal) -> list[float] | None:
    """Numbers less an origin, each rounded once; None if a cell is none."""
    from decimal import Decimal, InvalidOperation

    try:
        found = None if any(b"_" in cell for cell in cells) else [Decimal(cell.decode().strip()) for cell in cells]
    except (InvalidOperation, ValueError):
        return None
    return None if found is None else [float(cell - origin) for cell in found]
