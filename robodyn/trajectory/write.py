"""Tables of results to files, written whole or not at all, each format in memory that does not grow with the table."""

from __future__ import annotations

import io
import os
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any, BinaryIO

import numpy as np

from robodyn.errors import InputError
from robodyn.support.extras import need
from robodyn.support.floats import Floats
from robodyn.support.threads import in_threads
from robodyn.trajectory.formats.table import FILE_TYPES

LARGE = 150_000  # cells above which importing polars (0.1 s) costs less than writing without it
PARTS = 4  # parts of a block that are written at once
GROUP_ROWS = 1 << 17  # rows of a row group of Parquet
_PART = 1 << 10


def lines_plain(values: Floats) -> bytes:
    """Rows of values (N, k) as lines of CSV, without polars."""
    return "".join(",".join(map(shortest, row)) + "\n" for row in values.tolist()).encode()


def lines_fast(values: Floats) -> list[bytes]:
    """Rows of values (N, k) as lines of CSV, through polars: it works on so few rows in one thread only."""
    import polars as pl

    def lines(part: Floats) -> bytes:
        text = io.BytesIO()
        frame = pl.DataFrame({str(i): part[:, i] for i in range(part.shape[1])})
        frame.write_csv(text, include_header=False)
        return text.getvalue()

    return in_threads(lines, np.array_split(values, PARTS), PARTS)


def shortest(value: float) -> str:
    """The shortest decimal that reads back as `value`, in the notation of polars: 0.00001, 1.5e-7, 1e+16, NaN."""
    text = repr(value)
    mantissa, mark, exponent = text.partition("e")
    if not mark:
        return "NaN" if text == "nan" else text
    power = int(exponent)
    if power == -5:
        sign = "-" if value < 0 else ""
        return f"{sign}0.0000{mantissa.lstrip('-').replace('.', '')}"
    return f"{mantissa}e{power:+d}"


class Writer(ABC):
    """What appends rows to a table of `time` and named columns, in one format; see `open_writer`."""

    def __init__(self, path: str, names: Sequence[str], stream: BinaryIO) -> None:
        self._path, self._names, self._stream = path, ("time", *names), stream

    def write(self, time: Floats, columns: Floats) -> None:
        """Append rows: time (N,) and columns (N, k) in the order of the names; raises where these do not fit."""
        if columns.shape != (len(time), len(self._names) - 1):
            raise ValueError(f"columns {columns.shape} do not fit {len(self._names) - 1} names and {len(time)} times")
        from robodyn.support.files import cannot_be_written

        with cannot_be_written(self._path):
            self.add(time, columns)

    @abstractmethod
    def begin(self) -> None:
        """Write what stands before the rows."""

    @abstractmethod
    def add(self, time: Floats, columns: Floats) -> None:
        """Write rows, or keep them."""

    def end(self) -> None:  # noqa: B027
        """Write what is left, and what stands behind the rows."""

    def close(self) -> None:  # noqa: B027
        """Give back what is kept beside the stream."""


class CsvWriter(Writer):
    """Comma-separated text with a header; through polars once the table is large."""

    _cells = 0

    def begin(self) -> None:
        header = io.StringIO()
        import csv

        csv.writer(header, lineterminator="\n").writerow(self._names)
        self._stream.write(header.getvalue().encode())

    def add(self, time: Floats, columns: Floats) -> None:
        values = _joined(time, columns)
        self._cells += values.size
        self._stream.writelines(lines_fast(values) if self._cells > LARGE else [lines_plain(values)])


class ParquetWriter(Writer):
    """Parquet of float64 columns without nulls, compressed by zstd, a row group at a time."""

    def begin(self) -> None:
        import pyarrow as pa
        from pyarrow import parquet

        self._parts: list[Floats] = []
        self._rows = 0
        self._schema = pa.schema([pa.field(name, pa.float64(), nullable=False) for name in self._names])
        sink = _Sink(self._stream)
        self._arrow = parquet.ParquetWriter(sink, self._schema, compression="zstd", use_dictionary=False)

    def add(self, time: Floats, columns: Floats) -> None:
        self._parts.append(_joined(time, columns))
        self._rows += len(time)
        if self._rows >= GROUP_ROWS:
            self._write_group()

    def _write_group(self) -> None:
        import pyarrow as pa

        columns = [pa.chunked_array([pa.array(part[:, i]) for part in self._parts]) for i in range(len(self._schema))]
        self._arrow.write_table(pa.Table.from_arrays(columns, schema=self._schema))
        self._parts, self._rows = [], 0

    def end(self) -> None:
        if self._rows:
            self._write_group()
        self._arrow.close()


class _Sink(io.RawIOBase):
    """A stream as pyarrow's writer wants it, which ends its file even if that was given up and the stream closed."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream, self._written = stream, 0

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        if not self._stream.closed:
            self._stream.write(data)
        self._written += len(data)
        return len(data)

    def tell(self) -> int:
        return self._written


class NpzWriter(Writer):
    """One float64 array per column, as `numpy.savez` stores them: an array begins with its length and stands in one
    piece, so blocks wait in a temporary file, beside the table if that is a file."""

    _waiting: Any = None

    def begin(self) -> None:
        from tempfile import TemporaryFile

        self._lengths: list[int] = []
        folder = os.path.dirname(os.path.abspath(self._stream.name)) if os.path.isfile(self._stream.name) else None
        self._waiting = TemporaryFile(dir=folder)  # noqa: SIM115

    def add(self, time: Floats, columns: Floats) -> None:
        for column in (time, *columns.T):
            self._waiting.write(np.ascontiguousarray(column).data)
        self._lengths.append(len(time))

    def end(self) -> None:
        from zipfile import ZipFile

        self._waiting.flush()
        values = np.memmap(self._waiting, np.float64, "r") if any(self._lengths) else np.empty(0)
        kind, shape = np.lib.format.dtype_to_descr(values.dtype), (sum(self._lengths),)
        with ZipFile(self._stream, "w") as archive:
            for i, name in enumerate(self._names):
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    head = {"descr": kind, "fortran_order": False, "shape": shape}
                    np.lib.format.write_array_header_1_0(member, head)
                    start = 0
                    for length in self._lengths:
                        member.write(values[start + i * length : start + (i + 1) * length].data)
                        start += length * len(self._names)

    def close(self) -> None:
        if self._waiting:
            self._waiting.close()


def _joined(time: Floats, columns: Floats) -> Floats:
    """(N, 1 + k), each column contiguous; copied in parts that stay in the cache, for rows may be contiguous."""
    values = np.empty((1 + columns.shape[1], len(time)))
    values[0] = time
    for start in range(0, len(time), _PART):
        values[1:, start : start + _PART] = columns[start : start + _PART].T
    return values.T


FORMATS: dict[str, type[Writer]] = {"csv": CsvWriter, "parquet": ParquetWriter, "npz": NpzWriter}


def format_of(path: str | os.PathLike[str]) -> type[Writer]:
    """The format of a table by the suffix of its file; raises if there is none, or if its library is not installed."""
    name = os.fspath(path)
    kind = FILE_TYPES.get(os.path.splitext(name)[1].lower(), "")
    if "\0" in name:
        raise InputError("cannot be written: the name has a null character", remedy="check the name", file=name)
    if kind not in FORMATS:
        raise InputError("unknown type of table by this suffix", remedy="name it .csv, .parquet or .npz", file=name)
    if kind == "parquet":
        need("tables written as Parquet", "pyarrow", file=name)
    return FORMATS[kind]


@contextmanager
def open_writer(path: str | os.PathLike[str], names: Sequence[str]) -> Iterator[Writer]:
    """A context manager for a writer of `time` and these columns in the format of the suffix.

    The file appears under its name, with all its rows, when the block of the `with` ends well (see `whole_file`).

    Raises:
        InputError: as of `format_of`, or a name appears twice.
    """
    name, form = os.fspath(path), format_of(path)
    twice = sorted({column for column in names if [*names, "time"].count(column) > 1})
    if twice:
        raise InputError(f"column {twice[0]!r} would be written twice", remedy="name each column once", file=name)
    from robodyn.support.files import cannot_be_written, whole_file

    with whole_file(name) as stream:
        writer = form(name, names, stream)
        try:
            with cannot_be_written(name):
                writer.begin()
            yield writer
            with cannot_be_written(name):
                writer.end()
        finally:
            with suppress(OSError):
                writer.close()
