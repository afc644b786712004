"""Units of columns, as their names tell them: `elbow [deg]`, `elbow (deg)`, `elbow_deg`, `time_ms`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Literal, NamedTuple

TimeUnit = Literal["s", "ms", "us", "ns"]
AngleUnit = Literal["rad", "deg"]
TICKS = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}
"""How many of a unit of time make a second."""
ANGLES = {"rad": 1.0, "deg": 180.0 / math.pi}
"""How many of a unit of angle make a radian."""
RATES = ("", "/s", "/s^2")
"""What follows the unit of a position, of a velocity and of an acceleration."""


class Unit(NamedTuple):
    """A unit: `parts` of it make one of SI (s, rad, m); `order` 1 is per second, 2 per second squared."""

    dimension: str
    parts: float
    order: int = 0


_BASES = {
    **{name: Unit("time", ticks) for name, ticks in TICKS.items()},
    **dict.fromkeys(("sec", "secs", "seconds"), Unit("time", 1)),
    **dict.fromkeys(("nsec", "nsecs", "nanosec", "nanoseconds"), Unit("time", 10**9)),
    **dict.fromkeys(("rad", "radian", "radians"), Unit("angle", ANGLES["rad"])),
    **dict.fromkeys(("deg", "degree", "degrees"), Unit("angle", ANGLES["deg"])),
    **{"m": Unit("length", 1.0), "cm": Unit("length", 100.0), "mm": Unit("length", 1000.0)},
}
_SPELLINGS = str.maketrans({"\u00b5": "u", "\u03bc": "u", "\u00b0": "deg", "\u00b2": "2", "^": None, " ": None})
_PER_SECOND = {"": 0, "/s": 1, "_s": 1, "_per_s": 1, "/s2": 2, "/s/s": 2, "_s2": 2, "_per_s2": 2}
_BRACKETS = re.compile(r"(.+?)\s*(?:\[(?!\d+\])([^\[\]]+)\]|\((?!\d+\))([^()]+)\))")
_SUFFIX = re.compile(rf"(.+?)_((?:{'|'.join(_BASES)})(?:(?:_per)?_s2?)?)", re.IGNORECASE)


def unit_of(text: str) -> Unit | None:
    """Return the unit that a text stands for, None if it is not understood: `deg`, `rad/s`, `m/s^2`."""
    text = text.translate(_SPELLINGS).lower()
    base = next((text[:end] for end in range(len(text), 0, -1) if text[:end] in _BASES), "")
    order = _PER_SECOND.get(text[len(base) :])
    return _BASES[base]._replace(order=order) if base and order is not None else None


def split_unit(column: str) -> Iterator[tuple[str, str]]:
    """Yield the name before a unit, and the unit's text: any text in brackets, what is known behind `_`."""
    if found := _BRACKETS.fullmatch(column):
        yield found[1], (found[2] or found[3]).strip()
    if found := _SUFFIX.fullmatch(column):
        yield found[1], found[2]
