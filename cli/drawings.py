"""Drawings to a folder, each file written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterable

from robodyn.errors import InputError
from robodyn.support.files import write_whole

_REMEDY = "name another folder"


def write_drawings(folder: str, files: Iterable[tuple[str, str]]) -> int:
    """Write files of text to a folder, which is made if there is none; how many.

    Raises:
        InputError: the folder cannot be made, or a file in it cannot be written.
    """
    try:
        os.makedirs(folder, exist_ok=True)
    except (OSError, ValueError) as error:
        why = (error.strerror or str(error)).lower() if isinstance(error, OSError) else str(error)
        raise InputError(f"cannot be written: {why}", remedy=_REMEDY, file=folder) from None
    drawings = list(files)
    for name, text in drawings:
        write_whole(os.path.join(folder, name), text.encode(), _REMEDY)
    return len(drawings)
