"""Names of left and right."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator

_ALONE = r"(?<![A-Za-z]){}(?![A-Za-z])"
_ENDS = "FBHMR"
"""Front, back, hind, middle, rear."""
_SWAPS = tuple(
    (re.compile(pattern), replacement)
    for pattern, replacement in (
        ("left", "right"),
        ("Left", "Right"),
        ("LEFT", "RIGHT"),
        (_ALONE.format("l"), "r"),
        (_ALONE.format("L"), "R"),
        (_ALONE.format(f"([{_ENDS}])L"), r"\1R"),
        (_ALONE.format(f"([{_ENDS.lower()}])l"), r"\1r"),
        (_ALONE.format(f"L([{_ENDS}])"), r"R\1"),
        (_ALONE.format(f"l([{_ENDS.lower()}])"), r"r\1"),
        (r"(?<![A-Za-z])L(?=[A-Z][a-z])", "R"),
        (r"(?<![A-Za-z])l(?=[A-Z])", "r"),
        (r"(?<=[a-z0-9])L(?![A-Za-z])", "R"),
    )
)


_ROWS = tuple(
    (re.compile(pattern), replacement)
    for pattern, replacement in (
        (r"(?i)front|hind|rear|middle|back", "*"),
        (_ALONE.format(f"[{_ENDS}]L"), "*L"),
        (_ALONE.format(f"[{_ENDS.lower()}]l"), "*l"),
        (_ALONE.format(f"L[{_ENDS}]"), "L*"),
        (_ALONE.format(f"l[{_ENDS.lower()}]"), "l*"),
    )
)


def row_of(name: str) -> str:
    """Return the name of something on the left with `*` for front, hind and so on: FL_hip is of the row *L_hip."""
    for pattern, replacement in _ROWS:
        name = pattern.sub(replacement, name, count=1)
    return name


def named_pairs(names: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield (left, right) of the names that are each other's but for left and right.

    Understood are left and right, l and r, two letters such as FL, LF, RL or LH, all in lower and upper case, and L as
    the first letter of LHipYaw and the last of ElbowL.
    """
    known = frozenset(names)
    for name in names:
        other = _right_of(name, known)
        if other is not None:
            yield name, other


def _right_of(name: str, known: frozenset[str]) -> str | None:
    for pattern, replacement in _SWAPS:
        for count in (0, 1):
            other = pattern.sub(replacement, name, count=count)
            if other != name and other in known:
                return other
    return None
