"""The bytes of a mesh, a file, standard input or memory; and in which unit its coordinates are."""

from __future__ import annotations

import io
import os
import stat
import sys
import weakref
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from typing import BinaryIO

from robodyn.errors import MeshError
from robodyn.support.input_file import copied, open_input

METRES = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254}
"""Metres per unit, by the names that `unit` may have."""


@dataclass(frozen=True, eq=False)
class Source:
    """Bytes that can be read again and again.

    name: for messages; size: bytes; path: of the file, None if the bytes are not in one that has a name.
    """

    name: str
    size: int
    path: str | None
    _held: BinaryIO | None = field(repr=False)

    @contextmanager
    def opened(self) -> Iterator[BinaryIO]:
        """A stream at its beginning; the same one every time where the bytes are not in a named file."""
        if self._held is not None:
            self._held.seek(0)
            yield self._held
            return
        with closing(_opened(self.path or "")) as stream, reading(self.name):
            if os.fstat(stream.fileno()).st_size != self.size:
                raise MeshError("has changed since it was opened", remedy="run again", file=self.name)
            yield stream

    def memory(self) -> bytes | None:
        """Return all bytes where they are in memory anyway, without a copy."""
        return self._held.getvalue() if isinstance(self._held, io.BytesIO) else None

    def data(self, most: int = -1) -> bytes:
        """Return all bytes, or the first ones."""
        with self.opened() as stream:
            return stream.read(self.size if most < 0 else most)

    def error(self, what: str, remedy: str | None = None, line: int | None = None) -> MeshError:
        return MeshError(what, remedy=remedy, file=self.name, line=line)


def open_source(source: str | os.PathLike[str] | bytes, typed: bool = False) -> Source:
    """Return the bytes of a file, of standard input (`-`), or these bytes; pipes are copied to a temporary file. A name
    that stands in a file is not `typed`; see `open_input`."""
    if isinstance(source, bytes):
        found = Source("<bytes>", len(source), None, io.BytesIO(source))
    elif (path := os.fspath(source)) == "-":
        if sys.stdin is None:
            raise MeshError("standard input is closed", remedy="name a file", file="<stdin>")
        found = _copied(sys.stdin.buffer, "<stdin>")
    else:
        with closing(_opened(path, typed)) as stream, reading(path):
            status = os.fstat(stream.fileno())
            found = Source(path, status.st_size, path, None) if stat.S_ISREG(status.st_mode) else _copied(stream, path)
    if not found.size:
        raise MeshError("is empty", remedy="a mesh is needed", file=found.name)
    return found


def _opened(path: str, typed: bool = False) -> BinaryIO:
    try:
        with reading(path):
            return open_input(path, typed)
    except ValueError as error:
        raise MeshError(f"is not the name of a file: {error}", remedy="check the name", file=path) from None


def _copied(stream: BinaryIO, name: str) -> Source:
    with reading(name):
        copy = copied(stream, name)
    found = Source(name, copy.tell(), None, copy)
    weakref.finalize(found, copy.close)
    return found


@contextmanager
def reading(name: str) -> Iterator[None]:
    """Tells what the system says about a file as a MeshError."""
    try:
        yield
    except FileNotFoundError:
        raise MeshError("there is no such file", remedy="check the name", file=name) from None
    except IsADirectoryError:
        raise MeshError("is a folder, not a file", remedy="name a mesh in it", file=name) from None
    except PermissionError:
        raise MeshError("no permission to read the file", remedy="change its mode", file=name) from None
    except OSError as error:
        what = f"cannot be read: {(error.strerror or str(error)).lower()}"
        raise MeshError(what, remedy="check the name and the disk", file=name) from None


def scale_of(unit: str | None, own: float | None, name: str) -> tuple[float, str]:
    """Metres per unit of the file, and the note about it: `unit`, a key of METRES that the caller says, counts more
    than `own`, what the file says, if it does."""
    if unit is not None and unit not in METRES:
        raise MeshError(f"unknown unit {unit!r}", remedy=f"units: {', '.join(METRES)}", file=name)
    if unit is None:
        return (1.0, "unit: metres, as the file says none") if own is None else (own, f"unit: {_unit(own)} by the file")
    given = METRES[unit]
    contrary = own is not None and abs(own - given) > 1e-9 * given
    return given, f"unit: {unit} as asked" + (f", though the file says {_unit(own or 0.0)}" if contrary else "")


def _unit(metres: float) -> str:
    return next((name for name, value in METRES.items() if value == metres), f"{metres:g} m")
