"""Which columns tell the time, in which unit, and the stamps in them as seconds."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from robodyn.support.floats import Floats
from robodyn.trajectory.columns.units import TICKS, split_unit, unit_of

if TYPE_CHECKING:
    from decimal import Decimal

EPOCH = 1e8
"""Seconds from which a stamp is taken to count from a distant origin, as that of 1970."""
_NANO = TICKS["ns"]
_PATTERNS = (
    (r"_*time|t|time_?stamps?", None),
    (r"%time", "ns"),
    (r"(?:.*[./_])?time_from_start", None),
    (r"field\.header\.stamp", "ns"),
    (r"(?:.*[./_])?stamp", None),
)
"""Names of time, the best first, and the unit of those that have one: `%time` is what `rostopic echo -p` writes."""
_TIMES = tuple((re.compile(pattern, re.IGNORECASE), unit) for pattern, unit in _PATTERNS)
_PAIRED = re.compile(r"(?P<stem>.*?)[./_]?(?P<part>secs?|n(?:ano)?secs?)", re.IGNORECASE)


@dataclass(frozen=True)
class Clock:
    """Columns of time.

    Attributes:
        column: the stamps, or the whole seconds in them; ticks: how many of its unit make a second.
        nano: a column of nanoseconds to add, None if there is none.
        told: whether the unit is told by a name or an option, and not assumed to be seconds.
        origin: the first row of the columns, if it is far from zero; the table then subtracts it, exactly.
    """

    column: int
    ticks: int = 1
    nano: int | None = None
    told: bool = False
    origin: tuple[Decimal, ...] = ()

    @property
    def columns(self) -> tuple[int, ...]:
        return (self.column,) if self.nano is None else (self.column, self.nano)

    def seconds(self, stamps: Floats, nano: Floats | None = None) -> Floats:
        """Return stamps (N,) of the columns as seconds since the origin, rounded once if they are whole numbers."""
        return stamps / self.ticks if nano is None else (stamps * _NANO + nano) / _NANO

    def given(self, stamps: Floats, time: Floats) -> Floats | None:
        """Return stamps (N,) as the table gives them, of two columns in seconds; None if they are the `time`.

        Args:
            stamps: less the origin; time: in seconds, less the origin.
        """
        if self.origin:
            from decimal import Decimal

            first = self.origin[0] if self.nano is None else self.start
            high = float(first)
            return high + (float(first - Decimal(high)) + (stamps if self.nano is None else time))
        return None if self.ticks == 1 else stamps

    @property
    def start(self) -> Decimal | int:
        """The origin in seconds."""
        return self._seconds(self.origin) if self.origin else 0

    def _seconds(self, values: Sequence[Decimal]) -> Decimal:
        return values[0] / self.ticks if self.nano is None else values[0] + values[1] / _NANO

    def begun(self, first: Sequence[str | float]) -> Clock:
        """Return the clock with the first row of its columns as origin, if that is far from zero."""
        try:
            if not first or not EPOCH <= abs(float(first[0])) / self.ticks < math.inf:
                return self
        except ValueError:  # told with its line when the rows are read
            return self
        from decimal import Decimal, InvalidOperation

        try:
            return replace(self, origin=tuple(Decimal(x.strip() if isinstance(x, str) else x) for x in first))
        except InvalidOperation:
            return self

    def in_unit(self, unit: str | None) -> Clock:
        """Return the clock with the unit that an option tells; that of a name stays."""
        return self if unit is None or self.told else replace(self, ticks=TICKS[unit], told=True)


def clocks(names: Mapping[int, str], chosen: Collection[int] = ()) -> tuple[list[Clock], set[int]]:
    """Return what can tell the time by its name, only the best kind of it, and the columns of the other kinds.

    Args:
        names: of columns, by place; chosen: those that were named on purpose, which are better than all others.
    """
    ranked = [*_pairs(names)]
    paired = {i for _, clock in ranked for i in clock.columns}
    ranked += [single for i, name in names.items() if i not in paired and (single := _single(i, name))]
    found = [((clock.column in chosen, -rank), clock) for rank, clock in ranked]
    best = max((key for key, _ in found), default=None)
    others = {i for key, clock in found if key != best for i in clock.columns}
    return [clock for key, clock in found if key == best], others


def _pairs(names: Mapping[int, str]) -> Iterator[tuple[int, Clock]]:
    """Yield columns of seconds and nanoseconds of one stem: `header.stamp.sec`, `header.stamp.nanosec`."""
    stems: dict[str, dict[bool, int]] = {}
    for i, name in names.items():
        if found := _PAIRED.fullmatch(name):
            stems.setdefault(found["stem"], {})[found["part"][0] in "nN"] = i
    for stem, parts in stems.items():
        if len(parts) == 2:
            rank = _rank(stem or "time")
            yield len(_TIMES) if rank is None else rank, Clock(parts[False], nano=parts[True], told=True)


def _single(i: int, name: str) -> tuple[int, Clock] | None:
    if (rank := _rank(name)) is not None:
        unit = _TIMES[rank][1]
        return rank, Clock(i, TICKS[unit or "s"], told=unit is not None)
    for stem, text in split_unit(name):
        unit_told = unit_of(text)
        rank = _rank(stem)
        if rank is not None and unit_told and unit_told.dimension == "time" and not unit_told.order:
            return rank, Clock(i, int(unit_told.parts), told=True)
    return None


def _rank(name: str) -> int | None:
    return next((k for k, (pattern, _) in enumerate(_TIMES) if pattern.fullmatch(name)), None)


def is_time(name: str) -> bool:
    """Return whether a name is one for time."""
    return _single(0, name) is not None
