"""Tables of results to files, written whole or not at all."""

from __future__ import annotations

import os
import stat
from collections.abc import Sequence
from contextlib import suppress
from types import TracebackType
from typing import BinaryIO, Protocol

from robodyn.errors import InputError
from robodyn.trajectory.formats import CsvFormat, NpzFormat, ParquetFormat
from robodyn.trajectory.table import FILE_TYPES, FloatArray, reason


class Format(Protocol):
    """What the writer asks of a file format."""

    def begin(self, stream: BinaryIO, names: Sequence[str]) -> None: ...

    def add(self, stream: BinaryIO, time: FloatArray, columns: FloatArray) -> None: ...

    def end(self, stream: BinaryIO) -> None: ...

    def close(self) -> None:
        """Give back what is kept beside the stream, whether the table came to its end or not."""
        ...


class Writer:
    """A table of `time` and named columns; use as a context manager.

    The file appears under its name, with all its rows, when the block of the `with` ends well; on any error nothing is
    left and an older file of that name stays. CSV is written as it comes, Parquet a row group at a time, .npz by way of
    a second temporary file.
    """

    def __init__(self, path: str, names: Sequence[str], form: Format) -> None:
        self._path, self._names, self._form = path, ("time", *names), form
        self._target = path
        self._temporary: str | None = None
        self._stream: BinaryIO | None = None

    def __enter__(self) -> Writer:
        try:
            self._stream = self._open()
            self._form.begin(self._stream, self._names)
        except OSError as error:
            self._discard()
            raise self._error(error) from None
        except BaseException:
            self._discard()
            raise
        return self

    def write(self, time: FloatArray, columns: FloatArray) -> None:
        """Append rows: time (N,) and columns (N, k) in the order of the names.

        Raises:
            InputError: the file cannot be written.
            ValueError: the shapes do not fit the names.
        """
        if self._stream is None or columns.shape != (len(time), len(self._names) - 1):
            raise ValueError(f"columns {columns.shape} do not fit {len(self._names) - 1} names and {len(time)} times")
        try:
            self._form.add(self._stream, time, columns)
        except OSError as error:
            raise self._error(error) from None

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        stream = self._stream
        if kind is not None or stream is None:
            self._discard()
            return
        try:
            self._form.end(stream)
            stream.close()
            if self._temporary:
                os.replace(self._temporary, self._target)
                self._temporary = None
        except OSError as failure:
            raise self._error(failure) from None
        finally:
            self._discard()

    def _open(self) -> BinaryIO:
        """A temporary file beside the target; the target itself where it is a device or a pipe."""
        with suppress(FileNotFoundError):
            mode = os.stat(self._path).st_mode
            if stat.S_ISDIR(mode):
                raise IsADirectoryError(0, "is a directory")
            if not stat.S_ISREG(mode):
                return open(self._path, "wb")
            self._target = os.path.realpath(self._path)
            if not os.access(self._target, os.W_OK):
                raise PermissionError(0, "permission denied")
        temporary = f"{self._target}.{os.urandom(4).hex()}.part"
        stream = open(temporary, "xb")  # noqa: SIM115
        self._temporary = temporary
        return stream

    def _discard(self) -> None:
        with suppress(OSError):
            self._form.close()
        with suppress(OSError):
            if self._stream:
                self._stream.close()
        with suppress(OSError):
            if self._temporary:
                os.unlink(self._temporary)
        self._stream = self._temporary = None

    def _error(self, error: OSError) -> InputError:
        return InputError(f"cannot be written: {reason(error)}", remedy="nothing was written", file=self._path)


FORMATS: dict[str, type[CsvFormat] | type[ParquetFormat] | type[NpzFormat]] = {
    "csv": CsvFormat,
    "parquet": ParquetFormat,
    "npz": NpzFormat,
}


def open_writer(path: str | os.PathLike[str], names: Sequence[str]) -> Writer:
    """A writer of `time` and these columns in the format of the suffix (`.csv`, `.parquet`, `.npz`).

    Raises:
        InputError: the suffix is not known, or a name appears twice.
    """
    name = os.fspath(path)
    form = FORMATS.get(FILE_TYPES.get(os.path.splitext(name)[1].lower(), ""))
    if "\0" in name:
        raise InputError("cannot be written: the name has a null character", remedy="check the name", file=name)
    if form is None:
        raise InputError("unknown type of table by this suffix", remedy="name it .csv, .parquet or .npz", file=name)
    twice = sorted({column for column in names if [*names, "time"].count(column) > 1})
    if twice:
        raise InputError(f"column {twice[0]!r} would be written twice", remedy="name each column once", file=name)
    return Writer(name, names, form())
