"""Columns: what the robot requires, the names that these may have, units in them, and columns of time as seconds."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple

from robodyn.errors import InputError
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from decimal import Decimal

TimeUnit = Literal["s", "ms", "us", "ns"]
AngleUnit = Literal["rad", "deg"]
TICKS = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}  # how many of a unit of time make a second
ANGLES = {"rad": 1.0, "deg": 180.0 / math.pi}  # how many of a unit of angle make a radian
RATES = ("", "/s", "/s^2")  # what follows the unit of a position, of a velocity and of an acceleration


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
    """The unit that a text stands for, None if it is not understood: `deg`, `rad/s`, `m/s^2`."""
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


EPOCH = 1e8  # seconds from which a stamp is taken to count from a distant origin, as that of 1970
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
    """Columns of time: the stamps (or the whole seconds in them), and nanoseconds to add if there are any. ticks: how
    many of the unit make a second; told: whether a name or an option tells that. origin: the first row of the columns,
    if it is far from zero; the table then subtracts it, exactly."""

    column: int
    ticks: int = 1
    nano: int | None = None
    told: bool = False
    origin: tuple[Decimal, ...] = ()

    @property
    def columns(self) -> tuple[int, ...]:
        return (self.column,) if self.nano is None else (self.column, self.nano)

    def seconds(self, stamps: Floats, nano: Floats | None = None) -> Floats:
        """Stamps (N,) of the columns as seconds since the origin, rounded once if they are whole numbers."""
        return stamps / self.ticks if nano is None else (stamps * _NANO + nano) / _NANO

    def given(self, stamps: Floats, time: Floats) -> Floats | None:
        """Stamps as the table gives them, of two columns in seconds, given less the origin; None if they are `time`."""
        if self.origin:
            from decimal import Decimal

            first = self.origin[0] if self.nano is None else self.start
            high = float(first)
            return high + (float(first - Decimal(high)) + (stamps if self.nano is None else time))
        return None if self.ticks == 1 else stamps

    @property
    def start(self) -> Decimal | int:
        """The origin in seconds."""
        if not self.origin:
            return 0
        return self.origin[0] / self.ticks if self.nano is None else self.origin[0] + self.origin[1] / _NANO

    def begun(self, first: Sequence[str | float]) -> Clock:
        """The clock with the first row of its columns as origin, if that is far from zero."""
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
        """The clock with the unit that an option tells; that of a name stays."""
        return self if unit is None or self.told else replace(self, ticks=TICKS[unit], told=True)


def clocks(names: Mapping[int, str], chosen: Collection[int] = ()) -> tuple[list[Clock], set[int]]:
    """What can tell the time by its name, only the best kind, `chosen` ones first; and columns of other kinds."""
    ranked: list[tuple[int, Clock]] = []
    stems: dict[str, dict[bool, int]] = {}  # of seconds and nanoseconds: `header.stamp.sec`, `header.stamp.nanosec`
    for i, name in names.items():
        if part := _PAIRED.fullmatch(name):
            stems.setdefault(part["stem"], {})[part["part"][0] in "nN"] = i
    for stem, parts in stems.items():
        if len(parts) == 2:
            rank = _rank(stem or "time")
            clock = Clock(parts[False], nano=parts[True], told=True)
            ranked.append((len(_TIMES) if rank is None else rank, clock))
    paired = {i for _, clock in ranked for i in clock.columns}
    ranked += [single for i, name in names.items() if i not in paired and (single := _single(i, name))]
    found = [((clock.column in chosen, -rank), clock) for rank, clock in ranked]
    best = max((key for key, _ in found), default=None)
    others = {i for key, clock in found if key != best for i in clock.columns}
    return [clock for key, clock in found if key == best], others


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
    return _single(0, name) is not None


Kind = Literal["angle", "continuous", "length", "floating"]
Quantity = Literal["q", "qd", "qdd", "tau"]
Place = tuple[Quantity, int]

POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
TWIST = ("wx", "wy", "wz", "vx", "vy", "vz")
TWIST_RATE = ("wdx", "wdy", "wdz", "ax", "ay", "az")
COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")  # of a wrench, in the order of its columns
TIME_NAMES = ("time", "t", "timestamp")
MEASURED: dict[Quantity, str] = {"q": "position", "qd": "velocity", "qdd": "acceleration", "tau": "torque"}
WORDS: dict[str, Quantity] = {
    **dict.fromkeys(("q", "pos", "position", "positions", "angle"), "q"),
    **dict.fromkeys(("qd", "dq", "vel", "velocity", "velocities"), "qd"),
    **dict.fromkeys(("qdd", "ddq", "acc", "acceleration", "accelerations"), "qdd"),
    **dict.fromkeys(("tau", "eff", "effort", "efforts", "torque"), "tau"),
}
"""Words before or behind a joint's name, with `_`, `.`, `/` or a blank between: `/states/elbow/velocity`."""
ANY_WORD = rf"(?P<word>(?i:{'|'.join(sorted(WORDS, key=len, reverse=True))}))"
_WORDED = (re.compile(rf"(?:.*[./])?{ANY_WORD}[_./ -](?P<stem>.+)"), re.compile(rf"(?P<stem>.+)[_./ -]{ANY_WORD}"))


@dataclass(frozen=True)
class Signal:
    """One coordinate of the robot: a scalar joint, or a floating joint (7 positions, 6 velocities), with limits of
    position and speed, infinite where there is none."""

    name: str
    kind: Kind
    lower: float = -math.inf
    upper: float = math.inf
    speed: float = math.inf


class Meaning(NamedTuple):
    """What a column holds: a quantity and an index, None without a coordinate; and the unit's text, if it is told."""

    place: Place | None
    unit: str | None = None


@dataclass(frozen=True)
class Signals:
    """The signals of a robot in coordinate order. dependent: joints that have no coordinate (mimic, fixed); their
    columns are accepted and not used. looped: joints that move a loop: those without columns follow from it.
    constraints: loops and contacts, whose wrenches may have columns, which are not used."""

    joints: tuple[Signal, ...]
    dependent: tuple[str, ...] = ()
    looped: tuple[str, ...] = ()
    constraints: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        stems = self.positions + self.velocities
        twice = sorted({stem for part in (self.positions, self.velocities) for stem in part if part.count(stem) > 1})
        if twice or any(not stem for stem in stems):
            raise InputError(f"two coordinates would share the column name {twice[0]!r}" if twice else "unnamed joint")

    @cached_property
    def positions(self) -> tuple[str, ...]:
        """Stems of the position columns, e.g. `elbow`; for a floating joint J `J_x J_y J_z J_qx J_qy J_qz J_qw`."""
        return self._stems(POSE)

    @cached_property
    def velocities(self) -> tuple[str, ...]:
        """Stems of the velocity columns; for a floating joint J `J_wx J_wy J_wz J_vx J_vy J_vz`, w in body axes, v the
        rate of the position in parent axes."""
        return self._stems(TWIST)

    @cached_property
    def accelerations(self) -> tuple[str, ...]:
        """Stems of the bare acceleration columns; for a floating joint J `J_wdx J_wdy J_wdz J_ax J_ay J_az`."""
        return self._stems(TWIST_RATE)

    def _stems(self, parts: Sequence[str]) -> tuple[str, ...]:
        stems: list[str] = []
        for joint in self.joints:
            stems += [f"{joint.name}_{part}" for part in parts] if joint.kind == "floating" else [joint.name]
        return tuple(stems)

    @cached_property
    def spans(self) -> dict[str, tuple[range, range]]:
        """Name of each joint -> its indices in q, and in qd and qdd."""
        found: dict[str, tuple[range, range]] = {}
        q = qd = 0
        for joint in self.joints:
            of = (len(POSE), len(TWIST)) if joint.kind == "floating" else (1, 1)
            found[joint.name] = range(q, q + of[0]), range(qd, qd + of[1])
            q, qd = q + of[0], qd + of[1]
        return found

    @cached_property
    def rest(self) -> tuple[float, ...]:
        """The position nearest to zero within the limits; of a floating joint at its place and not turned."""
        found: list[float] = []
        for joint in self.joints:
            found += (0.0,) * 6 + (1.0,) if joint.kind == "floating" else (min(max(0.0, joint.lower), joint.upper),)
        return tuple(found)

    @cached_property
    def kinds(self) -> dict[str, str]:
        """What each stem of a position or velocity measures: "angle", "length", or "" for parts of quaternions."""
        kinds = ("length",) * 3 + ("",) * 4 + ("angle",) * 3 + ("length",) * 3
        found: dict[str, str] = {}
        for joint in self.joints:
            if joint.kind == "floating":
                found |= {f"{joint.name}_{part}": kind for part, kind in zip((*POSE, *TWIST), kinds, strict=True)}
            else:
                found[joint.name] = "length" if joint.kind == "length" else "angle"
        return found

    @cached_property
    def names(self) -> dict[str, Meaning]:
        """Our own column names: `q_<joint>` wins over the joint's bare name, and both over `q<number>`."""
        found: dict[str, Meaning] = {}
        stems: dict[Quantity, tuple[str, ...]] = {"q": self.positions, "qd": self.velocities, "qdd": self.velocities}
        for quantity, of in stems.items():
            found |= {f"{quantity}_{stem}": Meaning((quantity, i)) for i, stem in enumerate(of)}
        for i, stem in enumerate(self.positions):
            found.setdefault(stem, Meaning(("q", i)))
        for i, stem in enumerate(self.velocities):
            if stem != self.accelerations[i]:  # of a floating joint
                found.setdefault(f"qdd_{self.accelerations[i]}", Meaning(("qdd", i)))
                found.setdefault(stem, Meaning(("qd", i)))
                found.setdefault(self.accelerations[i], Meaning(("qdd", i)))
        for quantity, of in stems.items():
            for i in range(len(of)):
                found.setdefault(f"{quantity}{i + 1}", Meaning((quantity, i)))
                found.setdefault(matrix_column(quantity, i), Meaning((quantity, i)))
        return found

    @cached_property
    def wrenches(self) -> frozenset[str]:
        """The columns of the constraints' wrenches."""
        return frozenset(f"{part}_{name}" for name in self.constraints for part in COMPONENTS)

    def find(self, column: str) -> Meaning | None:
        """What a column of this name holds, None if the robot does not know it: by our own names, by words beside a
        joint's name, then by the same before a unit that is not of time."""
        if found := self._find(column):
            return found
        for name, text in split_unit(column):
            unit = unit_of(text)
            if (unit is None or unit.dimension != "time") and (found := self._find(name)):
                return found._replace(unit=text)
        return None

    def _find(self, column: str) -> Meaning | None:
        if column in self.names:
            return self.names[column]
        if column in self.dependent:
            return Meaning(None)
        for quantity, stem in worded(column):
            stems = self.positions if quantity == "q" else self.velocities
            # with and without what stands before slashes and points
            for end in (stem, *(stem[found.end() :] for found in re.finditer(r"[/.]", stem))):
                if end in stems:
                    return Meaning((quantity, stems.index(end)))
                if end in self.dependent:
                    return Meaning(None)
        return None


def worded(column: str) -> Iterator[tuple[Quantity, str]]:
    """Yield the readings of a name as a word for a quantity and the rest, which should name a joint."""
    for pattern in _WORDED:
        if found := pattern.fullmatch(column):
            yield WORDS[found["word"].lower()], found["stem"]


def matrix_column(quantity: str, index: int) -> str:
    """The name of a column of a matrix in coordinate order, which no joint's name overrides in practice: `q[1]`."""
    return f"{quantity}[{index + 1}]"
