"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import shutil
import stat
from contextlib import suppress

from robodyn.errors import InputError


def write_whole(path: str, data: bytes, remedy: str = "nothing was written") -> None:
    """Give a file this content, by way of a temporary one beside it; its mode stays, and so does a link to it.

    Raises:
        InputError: it cannot be written; then it is as it was.
    """
    if "\0" in path:
        raise InputError("cannot be written: the name has a null character", remedy=remedy, file=path)
    target = os.path.realpath(path)
    temporary = f"{target}.{os.urandom(4).hex()}.part"
    try:
        if os.path.exists(target) and not (stat.S_ISREG(os.stat(target).st_mode) and os.access(target, os.W_OK)):
            raise PermissionError(0, "it is no file, or read-only")
        with open(temporary, "xb") as stream:
            stream.write(data)
        if os.path.exists(target):
            shutil.copymode(target, temporary)
        os.replace(temporary, target)
    except OSError as error:
        why = (error.strerror or str(error)).lower()
        raise InputError(f"cannot be written: {why}", remedy=remedy, file=path) from None
    finally:
        with suppress(OSError):
            os.unlink(temporary)
