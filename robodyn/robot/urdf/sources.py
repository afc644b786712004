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
        raise DescriptionError("there is no such file", remedy=remedy, file=file) from None
    except IsADirectoryError:
        raise DescriptionError("this is a folder, not a file", remedy="give a URDF file", file=file) from None
    except PermissionError:
        raise DescriptionError("no permission to read the file", remedy="change its mode", file=file) from None
    except OSError as error:
        what = f"cannot read the file: {error.strerror}"
        raise DescriptionError(what, remedy="check the name and the disk", file=file) from None
    except ValueError as error:
        raise DescriptionError(f"this is not a file name: {error}", remedy="check the name", file=file) from None


def as_utf8(data: bytes) -> tuple[bytes, bool]:
    """Return UTF-16 transcoded to UTF-8, everything else as it is; and whether it was transcoded."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        encoding = "utf-16"
    elif data[:2] == b"<\0":
        encoding = "utf-16-le"
    elif data[:2] == b"\0<":
        encoding = "utf-16-be"
    else:
        return data, False
    return data.decode(encoding).encode(), True


LONGEST = 1 << 21
"""Bytes of the longest comment that is read, and the most from the beginning of one tag to that of the next.

expat scans a token that is not complete yet again with every further megabyte: 100 MB in one attribute take it half a
minute.
"""
_COMMENT, _COMMENT_END = b"<!--", b"-->"
_PIECE = re.compile(rb""">|"[^"]*(?:"|\Z)|'[^']*(?:'|\Z)""")


def long_token(data: bytes) -> tuple[int, int, str] | None:
    """Return the bytes [start, end) and the kind of the first token that makes it more than `LONGEST` from tag to tag.

    Method: two passes over the bytes, in leaps from comment to comment and, of each window of `LONGEST` bytes, to the
    last `<` in it.
    """
    comment, tag = _long_comment(data), _long_stretch(data)
    if tag is None or (comment is not None and comment <= tag):
        return None if comment is None else (comment, _until(data, _COMMENT_END, comment), "comment")
    for piece in _PIECE.finditer(data, tag):
        if piece.group() == b">":
            return piece.end(), _until(data, b"<", piece.end()), "text"
        if piece.end() - piece.start() > LONGEST // 2:
            return piece.start() + 1, piece.end() - 1, "attribute"
        if piece.end() - tag > LONGEST:
            break
    return tag, _until(data, b"<", tag + 1), "tag"


def _long_stretch(data: bytes) -> int | None:
    """Return the `<`, or the beginning of the file, that no other `<` follows within `LONGEST` bytes."""
    start = 0
    while start + LONGEST < len(data):
        last = data.rfind(b"<", start + 1, start + LONGEST + 1)
        if last < 0:
            return start
        start = last
    return None


def _long_comment(data: bytes) -> int | None:
    start = data.find(_COMMENT) if len(data) > LONGEST else -1
    while start >= 0:
        end = _until(data, _COMMENT_END, start)
        if end - start > LONGEST:
            return start
        start = data.find(_COMMENT, end)
    return None


def _until(data: bytes, closing: bytes, start: int) -> int:
    end = data.find(closing, start)
    return len(data) if end < 0 else end
