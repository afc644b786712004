"""Files that are read: no devices, which may never end, and no pipe without a writer."""

from __future__ import annotations

import errno
import os
import select
import stat
from io import BufferedReader
from typing import BinaryIO

MOST = 1 << 30
"""Bytes of a file that is held in memory whole."""

MOST_PIPED = 1 << 34
"""Bytes that are taken from a pipe."""

_PART = 1 << 20
LFS_POINTER = b"version https://git-lfs.github.com/spec/"
"""How a file begins that stands for another, which Git LFS has not fetched."""

PATIENCE = 10.0
"""Seconds until somebody has to have begun to write to a pipe."""


def open_input(path: str | os.PathLike[str]) -> BufferedReader:
    """Return a file, or a pipe that somebody writes to, opened for reading.

    Raises:
        OSError: it cannot be opened, is a folder or a device, or a pipe without a writer.
    """
    stream = open(path, "rb", opener=_at_once)  # noqa: SIM115
    try:
        mode = os.fstat(stream.fileno()).st_mode
        if stat.S_ISCHR(mode) or stat.S_ISBLK(mode):
            raise OSError(errno.EINVAL, "this is a device, not a file")
        if stat.S_ISFIFO(mode):
            _wait(stream.fileno())
    except OSError:
        stream.close()
        raise
    return stream


def read_input(path: str | os.PathLike[str], most: int | None = None) -> bytes:
    """Return all bytes of a file or a pipe; see `open_input`.

    Raises:
        OSError: as `open_input`, or there are more than `most` bytes.
    """
    most = MOST if most is None else most
    with open_input(path) as stream:
        data = stream.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"it has more than {most} bytes")
    return data


def _at_once(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _wait(number: int) -> None:
    """Wait until there is something to be read from a pipe, for as long as somebody may write to it."""
    ready, _, _ = select.select([number], [], [], PATIENCE)
    if not ready:
        try:
            unwritten = os.read(number, 1) == b""
        except BlockingIOError:
            unwritten = False
        if unwritten:
            raise OSError(errno.EINVAL, f"it is a pipe that nobody has written to for {PATIENCE:g} s")
    os.set_blocking(number, True)


def copied(stream: BinaryIO) -> BinaryIO:
    """Return a temporary file with all that comes out of a pipe, up to `MOST_PIPED` bytes; see `read_input`."""
    import tempfile

    copy = tempfile.TemporaryFile()  # noqa: SIM115
    try:
        while part := stream.read(_PART):
            if copy.tell() + len(part) > MOST_PIPED:
                raise OSError(errno.EFBIG, f"more than {MOST_PIPED} bytes come out of this pipe")
            copy.write(part)
    except BaseException:
        copy.close()
        raise
    return copy
