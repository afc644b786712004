"""What is kept between processes, machine code above all, in the user's cache folder."""

from __future__ import annotations

import hashlib
import os
import re
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from robodyn.support.input_file import open_input

MARK = b"robodyn object 1\n"
FORGOTTEN = 3600.0
"""Seconds after which a file that was never finished is removed."""
NAME = re.compile(r"[0-9a-f]{32}-[0-9a-f]{32}(\.\w+\.part)?")


def cache_folder() -> Path | None:
    """Where things are kept: `ROBODYN_CACHE` if set, nowhere if that is 0, else the user's cache folder if there is."""
    named = os.environ.get("ROBODYN_CACHE")
    if named is not None:
        return None if named in ("", "0") else Path(os.path.expanduser(named))
    import platformdirs

    with suppress(RuntimeError):
        folder = Path(platformdirs.user_cache_dir("robodyn", appauthor=False))
        return folder if folder.is_absolute() else None
    return None


def code_digest(folder: Path, without: str = "") -> str:
    """Return a digest of all modules in a folder but those in a part of it, empty where there are none."""
    names = (path.relative_to(folder) for path in folder.rglob("*.py"))
    kept = sorted(name.as_posix() for name in names if name.parts[0] != without)
    digest = hashlib.sha256()
    for name in kept:
        data = (folder / name).read_bytes()
        digest.update(f"{name} {len(data)}\n".encode() + data)
    return digest.hexdigest() if kept else ""


class Key(NamedTuple):
    """What something kept is, and by what it was made: each text tells every difference that matters."""

    content: str
    maker: str


class ObjectCache:
    """Bytes by key, in one file each (mark, digest of key and content, and the content, which is run), up to `largest`.

    Files are written whole or not at all, and ignored unless intact; so are files and folders that others own or may
    write to, or under Windows outside the user's own folder. No failure is an error, no folder keeps nothing.
    """

    def __init__(self, folder: Path | None, largest: int = 256 << 20) -> None:
        self._folder = None if folder is None else folder / "objects"
        self._largest = largest

    def get(self, key: Key) -> bytes | None:
        """Return what was kept under this key, or None."""
        if self._folder is None:
            return None
        path = self._folder / _name(key)
        try:
            with open_input(path) as stream:
                if not (_private(path, os.fstat(stream.fileno())) and _private(self._folder)):
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

    def put(self, key: Key, content: bytes) -> None:
        """Keep the content under this key, if that can be; files used longest ago and those never finished go. Unlike
        `whole_file` this replaces a link or a pipe, as nothing may be written elsewhere."""
        if self._folder is None:
            return
        path = self._folder / _name(key)
        part = path.with_name(f"{path.name}.{os.urandom(8).hex()}.part")
        with suppress(OSError):
            self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            if not _private(self._folder):
                return
            try:
                with open(part, "xb", opener=lambda path, flags: os.open(path, flags, 0o600)) as stream:
                    stream.write(MARK + _digest(key, content) + content)
                os.replace(part, path)
            finally:
                part.unlink(missing_ok=True)
            now, kept = time.time(), 0
            for file, status in sorted(_files(self._folder), key=lambda file: -file[1].st_mtime):
                kept += status.st_size
                if kept > self._largest or (file.suffix == ".part" and now - status.st_mtime > FORGOTTEN):
                    with suppress(OSError):
                        file.unlink()

    def held(self) -> tuple[int, int]:
        """Return how many files are kept, and their bytes."""
        with suppress(OSError):
            sizes = [status.st_size for _, status in _files(self._folder)] if self._folder is not None else []
            return len(sizes), sum(sizes)
        return 0, 0


def _files(folder: Path) -> Iterator[tuple[Path, os.stat_result]]:
    for path in folder.iterdir():
        with suppress(OSError):
            if NAME.fullmatch(path.name):
                yield path, path.lstat()


def _name(key: Key) -> str:
    return "-".join(hashlib.sha256(text.encode()).hexdigest()[:32] for text in key)


def _digest(key: Key, content: bytes) -> bytes:
    return hashlib.sha256(b"\0".join((key.content.encode(), key.maker.encode(), content))).digest()


def _private(path: Path, status: os.stat_result | None = None) -> bool:
    """Return whether only this user may write there, as far as the system tells it."""
    if not hasattr(os, "getuid"):  # systems without owners keep the user's own folder from other users
        with suppress(OSError, RuntimeError):
            return path.resolve().is_relative_to(Path.home().resolve())
        return False
    status = status or path.stat()
    return status.st_uid == os.getuid() and not status.st_mode & 0o022
