"""The bytes of a description, from a file or from memory, xacro files expanded; and tokens too long for a parser."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence

from robodyn.errors import DescriptionError, InputError
from robodyn.robot.urdf.packages import EXPANDED
from robodyn.support.input_file import read_input
from robodyn.support.wording import shown


def is_xacro(source: object) -> bool:
    """Return whether this is the path of a xacro file."""
    return isinstance(source, (str, os.PathLike)) and os.fspath(source).lower().endswith(".xacro")


def content_of(
    source: str | os.PathLike[str] | bytes,
    name: str | None = None,
    package_paths: Sequence[str] = (),
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
) -> tuple[str, bytes]:
    """Return the name to show in messages, and the bytes of a description; a xacro file is expanded, see `expanded`.

    Raises:
        InputError: the file cannot be read or expanded, or arguments are given to a file that is no xacro file.
    """
    if not isinstance(source, bytes) and is_xacro(source):
        from robodyn.robot.urdf.xacro import expanded

        path = os.fspath(source)
        return (name or path) + EXPANDED, expanded(path, package_paths, xacro_args, trust_xacro).text
    file, data = read_source(source, name)
    if xacro_args:
        what = f"the argument {shown(next(iter(xacro_args)))} is for a file that is xacro"
        raise InputError(what, remedy="xacro files end in .xacro", file=file)
    return file, data


def read_source(source: str | os.PathLike[str] | bytes, name: str | None) -> tuple[str, bytes]:
    """Return the name to show in messages, and the bytes."""
    if isinstance(source, bytes):
        return name or "<stdin>", source
    path = os.fspath(source)
    file = name or path
    try:
        return file, read_input(path, typed=True)
    except FileNotFoundError:
        remedy = "check the name" if os.path.isdir(os.path.dirname(path) or os.curdir) else "check the folder"
        remedy = "give a path, or the XML as bytes" if path.lstrip().startswith("<") else remedy
        what = "there is no such file"
    except IsADirectoryError:
        what, remedy = "this is a folder, not a file", "give a URDF file"
    except PermissionError:
        what, remedy = "no permission to read the file", "change its mode"
    except OSError as error:
        what, remedy = f"cannot read the file: {error.strerror}", "check the name and the disk"
    except ValueError as error:
        what, remedy = f"this is not a file name: {error}", "check the name"
    raise DescriptionError(what, remedy=remedy, file=file)


_UTF_16 = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"<\0": "utf-16-le", b"\0<": "utf-16-be"}


def as_utf8(data: bytes) -> tuple[bytes, bool]:
    """Return UTF-16 transcoded to UTF-8, everything else as it is; and whether it was transcoded."""
    encoding = _UTF_16.get(data[:2])
    return (data, False) if encoding is None else (data.decode(encoding).encode(), True)


LONGEST = 1 << 21
"""Bytes of the longest comment that is read, and the most from the beginning of one tag to that of the next.

expat scans a token that is not complete yet again with every further megabyte: 100 MB in one attribute take it half a
minute.
"""
_STRETCH = re.compile(rb"(<!--.*?(?:-->|\Z))[^<]*|<[^<]*|[^<]+", re.DOTALL)
"""A comment or a tag, with the text that follows it."""
_PIECE = re.compile(rb""">|"[^"]*(?:"|\Z)|'[^']*(?:'|\Z)""")


def long_token(data: bytes) -> tuple[int, int, str] | None:
    """Return bytes [start, end) and kind of the first token that makes it more than `LONGEST` to the next tag."""
    for stretch in _STRETCH.finditer(data) if len(data) > LONGEST else ():
        start, end = stretch.span()
        if end - start <= LONGEST:
            continue
        behind = max(start, stretch.end(1))
        if behind - start > LONGEST:
            return start, behind, "comment"
        if behind > start or not data.startswith(b"<", start):
            return behind, end, "text"
        for piece in _PIECE.finditer(data, start, end):
            if piece.group() == b">":
                return piece.end(), end, "text"
            if piece.end() - piece.start() > LONGEST // 2:
                closed = data[piece.end() - 1] == data[piece.start()]
                return piece.start() + 1, piece.end() - closed, "attribute"
            if piece.end() - start > LONGEST:
                break
        return start, end, "tag"
    return None
