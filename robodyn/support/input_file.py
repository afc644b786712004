"""The one place where input files are opened: regular files, and what the user gives as standard input.

A robot's folder may come from anybody, and git stores links: a name in it may lead to a pipe that never ends, or to a
device. So a name that was found, in a file, a folder or a pattern, is opened only if it is that of a regular file. A
name that the user typed may besides be that of a descriptor of this process, as `<(zcat log.csv.gz)` of shells is.
"""

from __future__ import annotations

import errno
import os
import re
import stat
import sys
from io import BufferedReader
from typing import Any, BinaryIO

from robodyn.errors import InputError
from robodyn.support.input_limits import beyond, limits

LFS_POINTER = b"version https://git-lfs.github.com/spec/"
"""How a file begins that stands for another, which Git LFS has not fetched."""

_PART = 1 << 20
_DESCRIPTOR = re.compile(r"/dev/(stdin|fd/\d+)|/proc/self/fd/\d+")
_KINDS = {stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device", stat.S_IFBLK: "a device"}


def open_input(path: str | os.PathLike[str], typed: bool = False) -> BufferedReader:
    """Return a regular file opened for reading; nothing that this opens can block or never end.

    Args:
        typed: the user gave this very name, so that a descriptor of this process (`/dev/stdin`, `/dev/fd/63`), which
            may be a pipe, is meant.

    Raises:
        OSError, ValueError: it cannot be opened, or is a folder, a pipe or a device; this is not the name of a file.
    """
    stream = open(path, "rb", opener=_at_once)  # noqa: SIM115
    try:
        mode = os.fstat(stream.fileno()).st_mode
        if not stat.S_ISREG(mode):
            if not (typed and _DESCRIPTOR.fullmatch(os.fspath(path)) and stat.S_ISFIFO(mode)):
                what = f"this is {_KINDS.get(stat.S_IFMT(mode), 'no file')}, not a file"
                raise OSError(errno.EINVAL, what)
            os.set_blocking(stream.fileno(), True)
    except OSError:
        stream.close()
        raise
    return stream


def read_input(path: str | os.PathLike[str], most: int | None = None, typed: bool = False) -> bytes:
    """Return all bytes of a file, or the first `most`; InputError where all are more than are held in memory."""
    with open_input(path, typed) as stream:
        return _all_of(stream, os.fspath(path)) if most is None else stream.read(most) or b""


def read_standard_input() -> bytes:
    """Return all bytes of standard input; InputError where it is closed, or they are more than are held in memory."""
    if sys.stdin is None:
        raise InputError("standard input is closed", remedy="name a file, or pipe one in", file="<stdin>")
    return _all_of(sys.stdin.buffer, "<stdin>")


def parse_json(text: bytes, file: str) -> Any:
    """Return what JSON says; InputError if there are more values than are read, before each a comma or a bracket."""
    import json

    if sum(map(text.count, (b",", b"[", b"{"))) > limits().message_values:
        raise beyond("message_values", "too many values", InputError, file=file)
    return json.loads(text)


def vetted(path: str | os.PathLike[str]) -> str:
    """Return the name of a regular file, for a library that has to open it itself; see `open_input`."""
    open_input(path).close()
    return os.fspath(path)


def copied(stream: BinaryIO, file: str) -> BinaryIO:
    """Return a temporary file with all that comes out of a pipe; InputError beyond the limit."""
    import tempfile

    most = limits().stream_bytes
    copy = tempfile.TemporaryFile()  # noqa: SIM115
    try:
        while part := stream.read(_PART):
            if copy.tell() + len(part) > most:
                raise beyond("stream_bytes", "too many bytes", InputError, file=file)
            copy.write(part)
    except BaseException:
        copy.close()
        raise
    return copy


def _at_once(path: str, flags: int) -> int:
    """Open without waiting for the other end of a pipe; this also never waits for what special files may bring."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0))


def _all_of(stream: BinaryIO, file: str) -> bytes:
    """Return all bytes, read by parts: asked for 1 GiB at once, Python makes the room before it reads."""
    most, parts, size = limits().file_bytes, [], 0
    while part := stream.read(_PART):
        size += len(part)
        if size > most:
            raise beyond("file_bytes", "too many bytes", InputError, file=file)
        parts.append(part)
    return b"".join(parts)
