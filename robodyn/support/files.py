"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import re
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from glob import escape, glob
from typing import BinaryIO

from robodyn.errors import InputError

_WINDOWS = os.name == "nt"
_PART = re.compile(r"\.[0-9a-f]{8}\.part")


def write_whole(path: str, data: bytes, remedy: str = "nothing was written") -> None:
    """Give a file this content; see `whole_file`."""
    with whole_file(path, remedy) as stream, cannot_be_written(path, remedy):
        stream.write(data)


@contextmanager
def whole_file(path: str, remedy: str = "nothing was written") -> Iterator[BinaryIO]:
    """Open a file that appears under its name, with all its content, when the block ends well.

    It is written under a temporary name beside it; on any error nothing is left, and an older file stays. The new file
    has the mode of the one that it replaces, and its owner and group where the user may give files away. A symbolic
    link is written through; another hard link to the old file keeps the old content. A pipe or a device is written to
    as it is, and so are standard output and standard error, by whatever name.

    Raises:
        InputError: it cannot be written.
    """
    old, name, lock = None, "", -1
    with cannot_be_written(path, remedy):
        if "\0" in path:
            raise OSError(0, "the name has a null character")
        with suppress(FileNotFoundError):
            old = os.stat(path)
        stream = None if old is None else _direct(path, old)
        target = os.path.realpath(path)
        if stream is None:
            remove_abandoned(path)
        while stream is None:
            name = f"{target}.{os.urandom(4).hex()}.part"
            stream = open(name, "xb", opener=None if old is None else partial(os.open, mode=0o600))  # noqa: SIM115
            if not _WINDOWS:  # it is locked for as long as it has that name
                lock = os.dup(stream.fileno())
                _locked(lock)
                if not os.path.exists(name):  # another process removed it as abandoned before it was locked
                    stream.close()
                    os.close(lock)
                    stream = None
    try:
        yield stream
        with cannot_be_written(path, remedy):
            stream.close()
            if name and old is not None:
                for owner in (old.st_uid, -1):  # or the group alone, as far as the user may
                    with suppress(AttributeError, OSError):
                        os.chown(name, owner, old.st_gid)
                        break
                shutil.copystat(target, name)
                os.utime(name)
            if name:
                os.replace(name, target)
    finally:
        with suppress(OSError):
            stream.close()
        if name:
            with suppress(OSError):
                os.unlink(name)
            with suppress(OSError):
                os.close(lock)


def _direct(path: str, old: os.stat_result) -> BinaryIO | None:
    """Return a pipe, a device or a standard stream, to which there is nothing but writing; None for a regular file."""
    if stat.S_ISDIR(old.st_mode):
        raise IsADirectoryError(0, "is a directory")
    for number in (1, 2):  # of this process, which a file opened by the name would begin anew
        with suppress(OSError):
            if os.path.samestat(os.fstat(number), old):
                return os.fdopen(os.dup(number), "wb")
    if not stat.S_ISREG(old.st_mode):
        return open(path, "wb")
    if not os.access(path, os.W_OK):
        raise PermissionError(0, "permission denied")
    return None


@contextmanager
def cannot_be_written(path: str, remedy: str = "nothing was written") -> Iterator[None]:
    """Turn what the system refuses meanwhile into an InputError of this file."""
    try:
        yield
    except OSError as error:
        why = (error.strerror or str(error)).lower()
        raise InputError(f"cannot be written: {why}", remedy=remedy, file=path) from None


def remove_abandoned(path: str) -> None:
    """Remove what killed processes have left of this file half-written; what a living one writes is locked or in
    use."""
    target = os.path.realpath(path)
    for part in glob(f"{escape(target)}.*.part"):
        if not _PART.fullmatch(part, len(target)):
            continue
        with suppress(OSError):
            if _WINDOWS:
                os.unlink(part)
                continue
            with open(part, "r+b") as stream:
                if _locked(stream.fileno()):
                    os.unlink(part)


def _locked(number: int) -> bool:
    """Lock an open file, unless another process has or files cannot be locked."""
    try:
        import fcntl

        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (ImportError, OSError):
        return False
    return True
