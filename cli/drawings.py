"""Drawings to a folder, each file written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import suppress

from robodyn.errors import InputError


def write_drawings(folder: str, files: Iterable[tuple[str, str]]) -> int:
    """Write files of text to a folder, which is made if there is none; how many.

    Raises:
        InputError: the folder cannot be made, or a file in it cannot be written.
    """
    path, count = folder, 0
    try:
        os.makedirs(folder, exist_ok=True)
        for name, text in files:
            path = os.path.join(folder, name)
            _write(path, text)
            count += 1
    except (OSError, ValueError) as error:
        why = (error.strerror or str(error)).lower() if isinstance(error, OSError) else str(error)
        raise InputError(f"cannot be written: {why}", remedy="name another folder", file=path) from None
    return count


def _write(path: str, text: str) -> None:
    """By way of a file of another name, which alone is removed if that fails."""
    temporary = f"{path}.{os.urandom(4).hex()}.part"
    stream = open(temporary, "x", encoding="utf-8")  # noqa: SIM115
    try:
        with stream:
            stream.write(text)
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(temporary)
        raise
