"""Tags, comments and texts that are longer than any robot needs, found before the parser sees them.

expat scans a token that is not complete yet again with every further megabyte: 100 MB in one attribute take it half a
minute.
"""

from __future__ import annotations

import re

LONGEST = 1 << 21
"""Bytes of the longest comment that is read, and the most from the beginning of one tag to that of the next."""
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
