"""Text of meshes in chunks of whole lines, and its tokens as arrays."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.source import Source
from robodyn.support.floats import Floats

Integers = NDArray[np.signedinteger[Any]]

CHUNK = 1 << 18
_LONGEST_LINE = 1 << 24
_LONGEST_TOKEN = 64
_PAD = b"\n".ljust(_LONGEST_TOKEN)
_SLASH, _MINUS, _UNDERSCORE = b"/-_"
_FIRST_BLANK, _LAST_BLANK = b"\t "
_COMMENT = re.compile(rb"#[^\r\n]*")
_MARK = b"\xef\xbb\xbf"


def without_comments(text: bytes) -> bytes:
    """Return the text with blanks for comments from # to the end of a line, so that every word stays in its place."""
    return _COMMENT.sub(lambda found: b" " * len(found[0]), text) if b"#" in text else text


def last_line_end(text: bytes) -> int:
    """Just after the last line feed; after the last carriage return in the text of old systems."""
    return text.rfind(b"\n") + 1 or text.rfind(b"\r") + 1


@dataclass(frozen=True, eq=False)
class Tokens:
    """The words of a text, between blanks and control characters.

    starts, ends: (n,) of each word in `text`; offset: of the text in the file.
    """

    source: Source
    offset: int
    text: NDArray[np.uint8]
    starts: Integers
    ends: Integers

    @cached_property
    def first(self) -> Integers:
        """(k + 1,) index of the first word of every line that has one, and n at last."""
        feeds = np.flatnonzero((self.text == ord("\n")) | (self.text == ord("\r")))
        index = np.searchsorted(self.starts, feeds)
        return index[np.diff(index, prepend=-1) > 0]

    def word(self, index: int) -> bytes:
        return self.text[self.starts[index] : self.ends[index]].tobytes()

    def error(self, index: int, what: str, remedy: str | None = None) -> MeshError:
        """Return an error in the line of this word."""
        return self.source.error(what, remedy, offset=self.offset + int(self.starts[index]) - 1)

    def refuse(self, wrong: NDArray[np.bool_], index: Integers, what: str, remedy: str, *numbers: Integers) -> None:
        """Raise an error in the line of the first of these words that is wrong; `{}` in `what` is a number of it."""
        if wrong.any():
            at = int(wrong.argmax())
            message = what.format(*(column[at] for column in numbers)) if numbers else what
            raise self.error(int(index[at]), message, remedy)

    def begin_with(self, letter: bytes) -> NDArray[np.bool_]:
        """(k,) whether the first word of each line is this letter."""
        at = self.first[:-1]
        alone = self.ends[at] - self.starts[at] == 1
        found: NDArray[np.bool_] = alone & (self.text[self.starts[at]] == ord(letter))
        return found

    def equal(self, index: Integers | slice, word: bytes) -> bool:
        """Return whether all of these words are this one, of at most 8 letters."""
        starts = self.starts[index]
        if not (self.ends[index] - starts == len(word)).all():
            return False
        mask, wanted = (int.from_bytes(part, "little") for part in (b"\xff" * len(word), word))
        return bool((self._eight(starts) & np.uint64(mask) == np.uint64(wanted)).all())

    def _eight(self, starts: Integers) -> NDArray[np.uint64]:
        found: NDArray[np.uint64] = sliding_window_view(self.text, 8)[starts].view("<u8")[:, 0]
        return found

    def floats(self, index: Integers) -> Floats:
        """Return the numbers that these words are, correctly rounded; `nan` and `inf` are numbers.

        Raises:
            MeshError: one is not.
        """
        starts = self.starts[index]
        lengths = self.ends[index] - starts
        width = int(lengths.max(initial=1))
        if width > _LONGEST_TOKEN:
            raise self._no_number(index, int(lengths.argmax()))
        windows = sliding_window_view(self.text, width)[starts]
        windows *= np.arange(width, dtype=np.uint8) < lengths.astype(np.uint8)[:, None]
        words = windows.view(f"S{width}")[:, 0]
        try:
            found = words.astype(np.float64)
        except ValueError:
            raise self._no_number(
                index, next(i for i, word in enumerate(words.tolist()) if not _is_float(word))
            ) from None
        if (windows == _UNDERSCORE).any():
            raise self._no_number(index, int((windows == _UNDERSCORE).any(axis=1).argmax()))
        return found

    def _no_number(self, index: Integers, at: int) -> MeshError:
        word = self.word(int(index[at]))
        text = word[:40].decode("utf-8", "replace") + ("..." if len(word) > 40 else "")
        remedy = "write decimals with a point" if b"," in word else "a coordinate is a decimal number such as -1.5e-3"
        return self.error(int(index[at]), f"{text!r} is not a number", remedy)

    def integers(self, index: Integers, slash: bool = False) -> Integers:
        """Return the decimal integers that these words are or, with `slash`, that stand before the first `/` in them.

        Eight letters at a time as one 64-bit number: x ^ 0x30.. leaves digits below 10, adding 0x76 carries all others
        into the high bit, the lowest of which ends the digits; then pairs, fours and eights of digits are joined by
        multiplication (D. Lemire, "Quickly parsing eight digits").

        Raises:
            MeshError: one is not an integer.
        """
        starts = self.starts[index]
        negative = self.text[starts] == _MINUS
        starts = starts + negative
        x = self._eight(starts) ^ np.uint64(0x3030303030303030)
        others = (((x & np.uint64(0x7F7F7F7F7F7F7F7F)) + np.uint64(0x7676767676767676)) | x) & np.uint64(
            0x8080808080808080
        )
        lowest = others & (~others + np.uint64(1))
        exponent = (lowest.astype(np.float64).view(np.uint64) >> np.uint64(52)).astype(np.int64) - 1023
        digits = np.where(lowest > 0, exponent >> 3, 0)
        found = _joined(x << (64 - 8 * digits).astype(np.uint64))
        after = self.text[starts + digits]
        ended = (starts + digits == self.ends[index]) | (slash & (after == _SLASH))
        found[negative] *= -1
        for at in np.flatnonzero(~(ended & (digits > 0))):
            found[at] = self._integer(int(index[at]), slash)
        return found

    def _integer(self, index: int, slash: bool) -> int:
        word = self.word(index)
        text = word.partition(b"/")[0] if slash else word
        if not re.fullmatch(rb"[-+]?\d{1,18}", text):
            shown = word[:40].decode("utf-8", "replace")
            raise self.error(index, f"{shown!r} is not an index", remedy="indices are integers")
        return int(text)


def chunks(
    source: Source,
    start: int = 0,
    end: Callable[[bytes], int] = last_line_end,
    plain: Callable[[bytes], bytes] = bytes,
) -> Iterator[Tokens]:
    """The words of a file from a byte on, in chunks of whole lines.

    Args:
        end: how many bytes of a text can be taken by themselves; 0 if more are needed.
        plain: what a text says, with every word in its place.

    Raises:
        MeshError: a line, or what else `end` wants to keep together, is longer than 16 MB.
    """
    with source.opened() as stream:
        stream.seek(start)
        offset, rest = start, b""
        while data := stream.read(CHUNK):
            text = rest + data
            if not offset and text.startswith(_MARK):
                text = text.replace(_MARK, b"   ", 1)
            taken = end(text)
            if taken:
                yield tokens(source, offset, plain(text[:taken]))
            elif len(text) > _LONGEST_LINE:
                raise source.error("a line longer than 16 MB", remedy="is it the text of a mesh?", offset=offset)
            offset, rest = offset + taken, text[taken:]
        if rest:
            yield tokens(source, offset, plain(rest))


def tokens(source: Source, offset: int, text: bytes) -> Tokens:
    """Return the words of a text that stands at this offset of the file."""
    letters = np.frombuffer(b"\n" + text + _PAD, np.uint8)
    blank = (letters >= _FIRST_BLANK) & (letters <= _LAST_BLANK)
    edges = np.flatnonzero(blank[1:] != blank[:-1]) + 1
    return Tokens(source, offset, letters, edges[::2], edges[1::2])


def runs(first: Integers, sizes: Integers) -> Integers:
    """Return so many integers from each first one on: 5 and 8, 2 and 3 times, are 5 6 8 9 10."""
    found: Integers = np.repeat(first - (np.cumsum(sizes) - sizes), sizes) + np.arange(sizes.sum())
    return found


def _joined(x: NDArray[np.uint64]) -> NDArray[np.int64]:
    """Return the number of eight digits, the first in the lowest byte."""
    low = np.uint64(0x000000FF000000FF)
    x = x * np.uint64(10) + (x >> np.uint64(8))
    fours = (x & low) * np.uint64(0x000F424000000064) + ((x >> np.uint64(16)) & low) * np.uint64(0x0000271000000001)
    return (fours >> np.uint64(32)).astype(np.int64)


def _is_float(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
