"""Comma-, semicolon-, tab- or blank-separated tables, read in chunks of whole lines."""

from __future__ import annotations

import csv
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import BinaryIO

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats
from robodyn.support.input_file import copied, open_input
from robodyn.support.input_limits import beyond, limits
from robodyn.trajectory.readers.csv_text import BLANK, LARGE, Dialect, parse
from robodyn.trajectory.readers.table import Table, changed

_PART = 1 << 20
_MARKS = {b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16", b"\x1f\x8b": "gzip", b"PK": "zip", b"PA": "Parquet"}


class CsvTable(Table):
    """A delimited text file whose first line names the columns; see `Table`.

    Standard input (`-`) and pipes are copied to a temporary file first, because the reader looks at them twice.
    """

    file: str
    header_line: int

    def __init__(self, path: str) -> None:
        super().__init__("<stdin>" if path == "-" else path)
        self._stream = _seekable(path)
        try:
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
        self._dialect = _dialect(text, self.file, self.header_line)
        self.names = self._dialect.names

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[Floats]:
        self._stream.seek(self._start)
        size, longest = max(_PART // 16, rows * 16 * len(self.names)), limits().csv_line_bytes
        while data := self._stream.read(size):
            offset = self._stream.tell() - len(data)
            if not data.endswith(b"\n"):
                data += self._stream.readline(longest + 1)
            after = self._stream.tell()
            self._check_lines(data, partial(self._line_at, offset))
            values = self._parse(data, columns, offset)
            self.position_bytes = after
            for start in range(0, len(values), rows):
                yield values[start : start + rows]

    def _check_lines(self, data: bytes, first: Callable[[], int]) -> None:
        """Raise if one of these lines is longer than is read; in leaps from the end of a line to another.

        Args:
            first: gives the number of the first.
        """
        start, longest = 0, limits().csv_line_bytes
        while start + longest < len(data):
            end = data.rfind(b"\n", start, start + longest + 1)
            if end < start:
                line = first() + data.count(b"\n", 0, start)
                raise beyond("csv_line_bytes", "too many bytes in a line", TrajectoryError, file=self.file, line=line)
            start = end + 1

    def _line_at(self, offset: int) -> int:
        """The number of the line that begins at this byte."""
        self._stream.seek(0)
        line = 1
        while offset > 0 and (data := self._stream.read(min(offset, _PART))):
            offset -= len(data)
            line += data.count(b"\n")
        return line

    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[Floats]:
        size = rows * max(1, self._row_bytes())
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
                found.append(self._parse(data, columns, start))
            except TrajectoryError:  # told with its line when the blocks are read
                continue
        return found

    def _row_bytes(self) -> int:
        self._stream.seek(self._start)
        data = self._stream.read(1 << 16)
        return len(data) // max(1, data.count(b"\n"))

    def _parse(self, data: bytes, columns: Sequence[int], offset: int) -> Floats:
        fast = self.size_bytes > LARGE
        return parse(data, self._dialect, columns, lambda: self._line_at(offset), fast, self.origins)

    def first(self, columns: Sequence[int]) -> list[str | float]:
        cells = next(self._rows(), [])
        return [cells[i].decode("utf-8", "replace") for i in columns] if len(cells) == len(self.names) else []

    def texts(self, columns: Sequence[int]) -> dict[int, str]:
        found: dict[int, str] = {}
        for row, cells in enumerate(self._rows(), 1):
            for i in columns if len(cells) == len(self.names) else ():
                text = cells[i].strip().decode("utf-8", "replace")
                if text != found.setdefault(i, text):
                    raise self.error_at(row, *changed(self.names[i], text, found[i]))
        return found

    def _rows(self) -> Iterator[list[bytes]]:
        """Yield the cells of each line that is not blank."""
        self._stream.seek(self._start)
        for line in iter(lambda: self._stream.readline(limits().csv_line_bytes), b""):
            if line.strip():
                yield self._dialect.cells(line)

    def error_at(self, row: int, what: str, remedy: str | None = None) -> TrajectoryError:
        self._stream.seek(self._start)
        line, seen = self.header_line, 0
        while seen < row and (text := self._stream.readline()):
            line += 1
            seen += bool(text.strip())
        return TrajectoryError(what, remedy=remedy, file=self.file, line=line)

    def close(self) -> None:
        self._stream.close()


def _dialect(first: bytes, file: str, line: int) -> Dialect:
    """Names and delimiter from the header line: the first of , ; tab that makes several cells, else blanks."""

    def refuse(what: str, remedy: str) -> TrajectoryError:
        return TrajectoryError(what, remedy=remedy, file=file, line=line)

    mark = next((name for start, name in _MARKS.items() if first.startswith(start)), None)
    if (mark and not first.isascii()) or b"\0" in first:
        raise refuse(
            f"is {mark or 'binary'} data, not text", "give a CSV table in UTF-8, or name its type by the suffix"
        )
    try:
        text = first.decode("utf-8-sig").strip()
    except UnicodeDecodeError:
        raise refuse("the header is not UTF-8 text", "save the table as UTF-8") from None
    text = text.removeprefix("#").strip()
    delimiter = next((mark for mark in ",;\t" if mark in text), " ")
    try:
        cells = text.split() if delimiter == " " else next(csv.reader([text], delimiter=delimiter, strict=True))
    except (csv.Error, StopIteration) as error:
        raise refuse(
            f"the header cannot be read: {error}", "name the columns, quoted where a name has a comma"
        ) from None
    names = tuple(cell.strip() for cell in cells)
    if all(_is_number(name) for name in names):
        raise refuse("no header: the first line holds numbers", "begin with a line of names, e.g. time,q_<joint>,...")
    return Dialect(BLANK if delimiter == " " else delimiter.encode(), names, file)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _seekable(path: str) -> BinaryIO:
    stream = sys.stdin.buffer if path == "-" else open_input(path, typed=True)
    if path != "-" and stream.seekable():
        return stream
    try:
        return copied(stream, "<stdin>" if path == "-" else path)
    finally:
        if path != "-":
            stream.close()
