"""Tables of results to files, written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from typing import BinaryIO

from robodyn.errors import InputError
from robodyn.support.extras import need
from robodyn.support.files import cannot_be_written, whole_file
from robodyn.support.floats import Floats
from robodyn.trajectory.formats import FORMATS, Format
from robodyn.trajectory.table import FILE_TYPES


class Writer:
    """What appends rows to a table of `time` and named columns; see `open_writer`."""

    def __init__(self, path: str, names: Sequence[str], form: Format, stream: BinaryIO) -> None:
        self._path, self._names, self._form, self._stream = path, ("time", *names), form, stream

    def write(self, time: Floats, columns: Floats) -> None:
        """Append rows: time (N,) and columns (N, k) in the order of the names.

        Raises:
            InputError: the file cannot be written.
            ValueError: the shapes do not fit the names.
        """
        if columns.shape != (len(time), len(self._names) - 1):
            raise ValueError(f"columns {columns.shape} do not fit {len(self._names) - 1} names and {len(time)} times")
        with cannot_be_written(self._path):
            self._form.add(self._stream, time, columns)


def format_of(path: str | os.PathLike[str]) -> type[Format]:
    """Return the format of a table by the suffix of its file, for what cannot be written to be said before long work.

    Raises:
        InputError: the suffix is not `.csv`, `.parquet` or `.npz`, or its library is not installed.
    """
    name = os.fspath(path)
    kind = FILE_TYPES.get(os.path.splitext(name)[1].lower(), "")
    if "\0" in name:
        raise InputError("cannot be written: the name has a null character", remedy="check the name", file=name)
    if kind not in FORMATS:
        raise InputError("unknown type of table by this suffix", remedy="name it .csv, .parquet or .npz", file=name)
    if kind == "parquet":
        need("Parquet tables", "pyarrow", file=name)
    return FORMATS[kind]


def open_writer(path: str | os.PathLike[str], names: Sequence[str]) -> AbstractContextManager[Writer]:
    """Return a context manager for a writer of `time` and these columns in the format of the suffix.

    The file appears under its name, with all its rows, when the block of the `with` ends well (see `whole_file`). CSV
    is written as it comes, Parquet a row group at a time, .npz by way of a second temporary file.

    Raises:
        InputError: as of `format_of`, or a name appears twice.
    """
    name, form = os.fspath(path), format_of(path)
    twice = sorted({column for column in names if [*names, "time"].count(column) > 1})
    if twice:
        raise InputError(f"column {twice[0]!r} would be written twice", remedy="name each column once", file=name)
    return _written(name, names, form())


@contextmanager
def _written(path: str, names: Sequence[str], form: Format) -> Iterator[Writer]:
    with whole_file(path) as stream:
        try:
            with cannot_be_written(path):
                form.begin(stream, ("time", *names))
            yield Writer(path, names, form, stream)
            with cannot_be_written(path):
                form.end(stream)
        finally:
            with suppress(OSError):
                form.close()
