"""Files that are written whole or not at all."""

from __future__ import annotations

import os
from contextlib import suppress

from robodyn.errors import InputError


def write_whole(path: str, content: bytes) -> None:
    """Write a file by way of one of another name beside it.

    Raises:
        InputError: it cannot be written; nothing is left then, and an older file of that name stays.
    """
    temporary = f"{path}.{os.urandom(4).hex()}.part"
    try:
        with open(temporary, "xb") as stream:
            stream.write(content)
        os.replace(temporary, path)
    except (OSError, ValueError) as error:
        with suppress(OSError, ValueError):
            os.unlink(temporary)
        why = (error.strerror or str(error)).lower() if isinstance(error, OSError) else str(error)
        raise InputError(f"cannot be written: {why}", remedy="name another file", file=path) from None
