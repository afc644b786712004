"""Compiled code kept between processes, in the user's cache folder."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path

MARK = b"robodyn object 1\n"
LARGEST_FOLDER = 256 << 20
"""Bytes kept; the files used longest ago go first."""
FORGOTTEN = 3600.0
"""Seconds after which a file that was never finished is removed."""


@cache
def cache_folder() -> Path | None:
    """Where compiled code is kept: `ROBODYN_CACHE` if set, none if that is 0, else the user's cache folder."""
    named = os.environ.get("ROBODYN_CACHE")
    if named is not None:
        return None if named in ("", "0") else Path(named)
    import platformdirs

    return Path(platformdirs.user_cache_dir("robodyn", appauthor=False))


class ObjectCache:
    """Bytes by key, in one file each: written whole or not at all, ignored unless intact.

    A file holds a mark, the digest of key and content, and the content. Files or folders that belong to somebody else,
    or that others may write to, are ignored, for their content is run. No failure to read or write is an error: what is
    not kept is made again.
    """

    def __init__(self, folder: Path | None) -> None:
        """Args: folder: made when it is needed; None keeps nothing."""
        self._folder = folder

    def get(self, key: str) -> bytes | None:
        """What was kept under this key, or None."""
        if self._folder is None:
            return None
        path = self._path(key)
        try:
            with open(path, "rb") as stream:
                if not (_private(os.stat(path.parent)) and _private(os.fstat(stream.fileno()))):
                    return None
                data = stream.read()
        except OSError:
            return None
        head = len(MARK) + 32
        content = data[head:]
        if data[:head] != MARK + _digest(key, content):
            return None
        with suppress(OSError):
            os.utime(path)
        return content

    def put(self, key: str, content: bytes) -> bool:
        """Keep the content under this key; False if that cannot be."""
        if self._folder is None:
            return False
        path = self._path(key)
        kept = write_whole(path, MARK + _digest(key, content) + content)
        if kept:
            _prune(path.parent)
        return kept

    def has(self, key: str) -> bool:
        """Whether something, intact or not, is kept under this key."""
        return self._folder is not None and self._path(key).exists()

    def _path(self, key: str) -> Path:
        assert self._folder is not None
        return self._folder / "code" / hashlib.sha256(key.encode()).hexdigest()


def write_whole(path: Path, data: bytes) -> bool:
    """Write a file that is read whole or not at all, in a folder of this user; False if that cannot be."""
    part = path.with_name(f"{path.name}.{os.getpid()}.{os.urandom(4).hex()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        if not _private(path.parent.stat()):
            return False
        try:
            with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as stream:
                stream.write(data)
            os.replace(part, path)
        except OSError:
            part.unlink(missing_ok=True)
            return False
    except OSError:
        return False
    return True


def _prune(folder: Path) -> None:
    now, kept = time.time(), 0
    with suppress(OSError):
        for path, status in sorted(_files(folder), key=lambda file: -file[1].st_mtime):
            kept += status.st_size
            if kept > LARGEST_FOLDER or (path.suffix == ".part" and now - status.st_mtime > FORGOTTEN):
                path.unlink()


def _files(folder: Path) -> Iterator[tuple[Path, os.stat_result]]:
    for path in folder.iterdir():
        with suppress(OSError):
            yield path, path.stat()


def _digest(key: str, content: bytes) -> bytes:
    return hashlib.sha256(key.encode() + b"\0" + content).digest()


def _private(status: os.stat_result) -> bool:
    """Whether only this user may write to it; where a system has no owners, its folders for users are trusted."""
    if not hasattr(os, "getuid"):
        return True
    return status.st_uid == os.getuid() and not status.st_mode & 0o022
