"""Header of a table + signals of a robot -> which column holds what."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from robodyn.errors import TrajectoryError
from robodyn.statistics import COMPONENTS
from robodyn.trajectory.columns import TIME_NAMES, Quantity, Signals
from robodyn.trajectory.loop_columns import loops_in

ABSENT = -1
_SHOWN = 8
Places = dict[tuple[Quantity, int], int]


@dataclass(frozen=True)
class Header:
    """The column names of a table and where they stand, for messages."""

    names: tuple[str, ...]
    file: str | None = None
    line: int | None = None

    def error(self, what: str, remedy: str) -> TrajectoryError:
        return TrajectoryError(what, remedy=remedy, file=self.file, line=self.line)


@dataclass(frozen=True)
class Layout:
    """Where each quantity stands in the table: the index of its column, ABSENT where there is none."""

    names: tuple[str, ...]
    time: int
    q: tuple[int, ...]
    qd: tuple[int, ...]
    qdd: tuple[int, ...]
    extra: dict[str, int]
    notes: tuple[str, ...] = ()

    @property
    def needed(self) -> tuple[int, ...]:
        """The columns to read, in the order of the table."""
        return tuple(sorted({self.time, *self.q, *self.qd, *self.qdd, *self.extra.values()} - {ABSENT}))


def resolve(header: Header, signals: Signals, extra: Sequence[str] = (), ignore_extra: bool = False) -> Layout:
    """The layout of a table.

    Args:
        header: the column names.
        signals: what the robot wants; every scalar joint needs its position, a floating joint any one of its columns.
        extra: columns that the scene names; they must exist.
        ignore_extra: leave unknown columns out instead of refusing them.

    Raises:
        TrajectoryError: a name is empty or appears twice, a quantity is given twice, a column is unknown or missing, or
            columns are those of loops, whether unknown ones are left out or not.
    """
    _check_header(header)
    time = _time(header)
    places, unknown = _meanings(header, signals, time, extra)
    _refuse_loops(header, signals, unknown)
    unused = [name for name in unknown if ignore_extra or signals.is_dependent(name)]
    unknown = [name for name in unknown if name not in unused]
    _check_complete(header, signals, places, unknown)
    absent = [name for name in extra if name not in header.names]
    if absent:
        raise header.error(f"no column {listing(absent)}, which the scene names", _hint(absent, header.names))
    if unknown:
        raise header.error(f"unknown column{'s' * (len(unknown) > 1)} {listing(unknown)}", _use(unknown, signals))
    return Layout(
        names=header.names,
        time=time,
        q=tuple(places.get(("q", i), ABSENT) for i in range(len(signals.positions))),
        qd=tuple(places.get(("qd", i), ABSENT) for i in range(len(signals.velocities))),
        qdd=tuple(places.get(("qdd", i), ABSENT) for i in range(len(signals.velocities))),
        extra={name: header.names.index(name) for name in extra},
        notes=(f"columns not used: {listing(unused)}",) if unused else (),
    )


def header_names(signals: Signals) -> tuple[str, ...]:
    """The usual column names of a robot's positions: `time`, `q_<joint>`; of a floating joint `<joint>_x`..."""
    floating = tuple(f"{joint.name}_" for joint in signals.joints if joint.kind == "floating")
    return ("time", *(stem if floating and stem.startswith(floating) else f"q_{stem}" for stem in signals.positions))


def listing(names: Iterable[str]) -> str:
    """Names in quotes, the first few of many."""
    names = list(names)
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(repr(name) for name in names[:_SHOWN]) + more


def _check_header(header: Header) -> None:
    for i, name in enumerate(header.names):
        if not name:
            raise header.error(f"column {i + 1} of {len(header.names)} has no name", "name every column in the header")
        if name in header.names[:i]:
            raise header.error(f"column {name!r} appears twice", "keep one of them")


def _time(header: Header) -> int:
    found = [i for i, name in enumerate(header.names) if name in TIME_NAMES]
    if not found:
        remedy = f"name it 'time', 't' or 'timestamp'; columns: {listing(header.names)}"
        raise header.error("no column of time", remedy)
    if len(found) > 1:
        both = listing(header.names[i] for i in found)
        raise header.error(f"time is given {len(found)} times, by {both}", "keep one of them")
    return found[0]


def _meanings(header: Header, signals: Signals, time: int, extra: Sequence[str]) -> tuple[Places, list[str]]:
    places: Places = {}
    unknown: list[str] = []
    for i, name in enumerate(header.names):
        meaning = signals.find(name)
        if i == time or (meaning is None and name in extra):
            continue
        if meaning is None:
            unknown.append(name)
        elif meaning in places:
            other = header.names[places[meaning]]
            raise header.error(f"columns {other!r} and {name!r} give the same quantity", "keep one of them")
        else:
            places[meaning] = i
    return places, unknown


def _refuse_loops(header: Header, signals: Signals, unknown: Sequence[str]) -> None:
    loops = loops_in(unknown, {*(joint.name for joint in signals.joints), *signals.dependent}) if signals.joints else []
    if loops:
        first, last = (f"{part}_{loops[0]}" for part in (COMPONENTS[0], COMPONENTS[-1]))
        what = (
            f"columns '{first}' to '{last}' are what simulate writes of a loop, and inverse dynamics of closed chains "
            "is not available: the torques would be those of the open tree"
        )
        remedy = f"the table's tau_ columns have the drives' torques; if {loops[0]!r} is no loop, rename its columns"
        raise header.error(what, remedy)


def _check_complete(header: Header, signals: Signals, places: Places, unknown: Sequence[str]) -> None:
    position = velocity = 0
    missing: list[str] = []
    for joint in signals.joints:
        width = (7, 6) if joint.kind == "floating" else (1, 1)
        of_joint: list[tuple[Quantity, int]] = [("q", i) for i in range(position, position + width[0])]
        if joint.kind == "floating":
            turn = [i for i in range(position + 3, position + 7) if ("q", i) in places]
            if turn and len(turn) < 4:
                there = listing(header.names[places[("q", i)]] for i in turn)
                remedy = f"give {joint.name}_qx, _qy, _qz and _qw, or none of them"
                raise header.error(f"the orientation of {joint.name!r} is incomplete: only {there}", remedy)
            of_joint += [("qd", i) for i in range(velocity, velocity + 6)]
            of_joint += [("qdd", i) for i in range(velocity, velocity + 6)]
        if not any(place in places for place in of_joint):
            missing.append(joint.name)
        position, velocity = position + width[0], velocity + width[1]
    if missing:
        wanted = [f"{name}_x" if f"{name}_x" in signals.positions else f"q_{name}" for name in missing]
        raise header.error(f"no position of joint {listing(missing)}", _hint(wanted, header.names, unknown))


def _use(unknown: Sequence[str], signals: Signals) -> str:
    """What to do about columns that mean nothing to the robot."""
    leave = f"--ignore-extra leaves {'them' if len(unknown) > 1 else 'it'} out"
    if any(name.startswith("base_") for name in unknown):
        return f'a scene with [base] motion = "moving" uses base_ columns; {leave}'
    return f"{_hint(unknown, header_names(signals))}; {leave}"


def _hint(wanted: Sequence[str], names: Sequence[str], candidates: Sequence[str] | None = None) -> str:
    """The candidate (of all names by default) closest to one that is wanted, and the names that exist."""
    from difflib import get_close_matches

    for name in wanted:
        close = get_close_matches(name, names if candidates is None else candidates, n=1, cutoff=0.7)
        if close:
            return f"did you mean {close[0]!r} for {name!r}? there is {listing(names)}"
    return f"there is {listing(names)}"
