"""To how many bits the numbers of a text are rounded."""

from __future__ import annotations

import math
from collections.abc import Sequence

from robodyn.solids.mesh.lines import Integers, Tokens

_SAMPLE, _MOST = 64, 1024
_FEW, _FLOAT32, _FLOAT64 = 5, 9, 16


def add_sample(words: list[bytes], tokens: Tokens, index: Integers) -> None:
    """Some of these words, evenly spread, until there are enough."""
    if len(words) < _MOST:
        step = max(1, index.size // _SAMPLE)
        words += [tokens.word(int(i)) for i in index.reshape(-1)[::step]]


def significand(words: Sequence[bytes]) -> int:
    """Bits of the numbers that these words are, from the most digits that one of them has, zeros at its ends left out.

    Numbers of fewer than 5 digits are taken as exact, as in a box drawn by hand: 53. Up to 9 digits are what programs
    write for float32: at most 24.
    """
    most = max((_digits(word) for word in words), default=0)
    if most < _FEW or most >= _FLOAT64:
        return 53
    bits = math.floor(most * math.log2(10.0))
    return min(bits, 24) if most <= _FLOAT32 else min(bits, 53)


def _digits(word: bytes) -> int:
    mantissa = word.lower().partition(b"e")[0].lstrip(b"+-")
    return len(mantissa.replace(b".", b"").strip(b"0"))
