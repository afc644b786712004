"""The names of a table's columns, which column holds what, and what is said of those that the robot does not know."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from typing import TypeVar

from robodyn.errors import TrajectoryError
from robodyn.support.input_file import beyond, limits
from robodyn.support.wording import alternatives, shown
from robodyn.trajectory.columns.signals import (
    ANGLES,
    ANY_WORD,
    COMPONENTS,
    MEASURED,
    POSE,
    RATES,
    TIME_NAMES,
    WORDS,
    AngleUnit,
    Clock,
    Meaning,
    Place,
    Quantity,
    Signals,
    clocks,
    is_time,
    split_unit,
    unit_of,
    worded,
)
from robodyn.trajectory.options import DEFAULT, REST, Reading

_INDEX = r"(?:\[(?P<index>\d+)\]|[._/]?(?P<behind>\d+))"
_ARRAY = re.compile(rf"(?P<path>(?:.*[./_])?)(?!q){ANY_WORD}{_INDEX}")
"""Entries of arrays; those called q, qd and qdd are ours, in the order of the description."""
_LABEL = re.compile(rf"(?P<path>(?:.*[./_])?)(?:joint_)?names?{_INDEX}", re.IGNORECASE)
_HEADER = re.compile(r"(?:.*[./_])?header[./_](?:seq|frame_id)")
_SHOWN = 8
ABSENT = -1
T = TypeVar("T")
_ALIKE = 0.7
_LETTERS = 3  # letters at least of a name that another may have in it
_COMPARED, _OPTIONS = 200, 8
"""So many unknown columns are compared with the names of joints, so many options written out."""


@dataclass(frozen=True)
class Header:
    """The column names of a table, where they stand, for messages, and what columns are called instead."""

    names: tuple[str, ...]
    file: str | None = None
    line: int | None = None
    aliases: Mapping[int, str] = field(default_factory=dict)

    @cached_property
    def called(self) -> tuple[str, ...]:
        return tuple(self.aliases.get(i, name) for i, name in enumerate(self.names))

    def error(self, what: str, remedy: str) -> TrajectoryError:
        return TrajectoryError(what, remedy=remedy, file=self.file, line=self.line)

    def check(self) -> None:
        """Raise if a column has no name, or two have the same; or if there are more, or longer names, than are read."""
        check_columns(len(self.names), self.file, self.line)
        longest = max(map(len, self.names), default=0)
        if longest > limits().name_characters:
            what = f"a column's name of {longest} characters"
            raise beyond("name_characters", what, TrajectoryError, file=self.file, line=self.line)
        first = {name: i for i, name in reversed([*enumerate(self.names)])}
        for i, name in enumerate(self.names):
            if not name:
                what = f"column {i + 1} of {len(self.names)} has no name"
                raise self.error(what, "name every column in the header")
            if first[name] < i:
                raise self.error(f"column {name!r} appears twice", "keep one of them")

    def renamed(self, columns: Mapping[str, str], signals: Signals, extra: Collection[str]) -> Header:
        """The header with columns called as a person wants it, our name -> the table's; raises if either is unknown."""
        aliases = dict(self.aliases)
        for ours, theirs in columns.items():
            found = signals.find(ours)
            if ours not in extra and not is_time(ours) and (found is None or found.place is None):
                known = ("time", *(f"{quantity}_{name}" for quantity in MEASURED for name in signals.spans))
                remedy = alternatives(ours, known, "the robot's columns")
                raise self.error(f"a column is called {shown(ours)}, which the robot does not know", remedy)
            if theirs not in self.names:
                remedy = alternatives(theirs, self.names, "columns")
                raise self.error(f"there is no column {shown(theirs)} to be called {shown(ours)}", remedy)
            aliases[self.names.index(theirs)] = ours
        return replace(self, aliases=aliases)

    @cached_property
    def labels(self) -> dict[int, tuple[str, int]]:
        """Columns with names of joints -> the path and the number of the entries that they name: `name[2]`."""
        return {i: (found["path"], _number(found)) for i, found in _matches(_LABEL, self.names)}

    def labelled(self, texts: Mapping[int, str]) -> Header:
        """The header with entries of arrays called after their joints; `texts` are what the columns of `labels` say."""
        joints = {self.labels[i]: text for i, text in texts.items()}
        aliases = {
            i: f"{joint}/{found['word']}"
            for i, found in _matches(_ARRAY, self.names)
            if (joint := joints.get((found["path"], _number(found))))
        }
        return replace(self, aliases={**aliases, **self.aliases})

    def is_of_message(self, i: int) -> bool:
        """Whether a column is of a message of ROS and needed for no motion."""
        return i in self.labels or self.entry(i) == "tau" or _HEADER.fullmatch(self.names[i]) is not None

    def entry(self, i: int) -> Quantity | None:
        """What a column measures of a joint that it does not name, None if it is no entry of an array."""
        found = _ARRAY.fullmatch(self.called[i])
        return WORDS[found["word"].lower()] if found else None


def check_columns(count: int, file: str | None, line: int | None = None) -> None:
    if count > limits().table_columns:
        raise beyond("table_columns", f"{count} columns", TrajectoryError, file=file, line=line)


def listing(names: Iterable[str]) -> str:
    """Names in quotes, the first few of many."""
    names = list(names)
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(repr(name) for name in names[:_SHOWN]) + more


def _matches(pattern: re.Pattern[str], names: tuple[str, ...]) -> list[tuple[int, re.Match[str]]]:
    return [(i, found) for i, name in enumerate(names) if (found := pattern.fullmatch(name))]


def _number(found: re.Match[str]) -> int:
    return int(found["index"] or found["behind"])


@dataclass(frozen=True)
class Layout:
    """Where each quantity stands in the table: the index of its column, ABSENT where there is none.

    Attributes:
        extra: name of a column that the scene requires, or `tau_<joint>` of a measured torque -> its index.
        parts: column -> how many of its unit make one of SI, where that is not 1.
        told: columns whose unit is told by a name or an option, and not only assumed.
        held: index in q -> position of what has no column and is held; followed: joints without that loops tell.
    """

    names: tuple[str, ...]
    clock: Clock
    q: tuple[int, ...]
    qd: tuple[int, ...]
    qdd: tuple[int, ...]
    extra: Mapping[str, int]
    parts: Mapping[int, float] = field(default_factory=dict)
    told: frozenset[int] = frozenset()
    held: Mapping[int, float] = field(default_factory=dict)
    followed: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def needed(self) -> tuple[int, ...]:
        """The columns to read, in the order of the table."""
        return tuple(sorted({*self.clock.columns, *self.q, *self.qd, *self.qdd, *self.extra.values()} - {ABSENT}))


def resolve(header: Header, signals: Signals, extra: Sequence[str] = (), reading: Reading = DEFAULT) -> Layout:
    """The layout of a table: every scalar joint requires its position, a floating joint any one of its columns, unless
    loops tell; the columns `extra` that the scene names must exist.

    Raises:
        TrajectoryError: a name is empty or appears twice, a quantity is given twice or in a unit that it cannot have, a
            column is unknown or missing, or columns are those of loops, whether unknown ones are left out or not.
    """
    header.check()
    header = header.renamed(reading.columns, signals, extra)
    called = header.called
    names = {i: name for i, name in enumerate(called) if name in TIME_NAMES or signals.find(name) is None}
    clocks_found, times = clocks(names, header.aliases)
    if not clocks_found:
        remedy = f"name it 'time', or say which it is: --map time=NAME; columns: {listing(header.names)}"
        raise header.error("no column of time", remedy)
    if len(clocks_found) > 1:
        both = listing(header.names[each.column] for each in clocks_found)
        what = f"time is given {len(clocks_found)} times, by {both}"
        raise header.error(what, "keep one of them, or --map time=NAME")
    clock = clocks_found[0].in_unit(reading.time_unit)
    meanings = {i: signals.find(name) for i, name in enumerate(called) if i not in clock.columns}
    places: dict[Place, int] = {}
    for i, meaning in meanings.items():
        if meaning and meaning.place and meaning.place[0] != "tau":
            _set(header, places, meaning.place, i)
    known = {*extra, *signals.wrenches}
    strange = [i for i, meaning in meanings.items() if meaning is None and called[i] not in known and i not in times]
    idle = {
        i: meaning for i, meaning in meanings.items() if meaning and (not meaning.place or meaning.place[0] == "tau")
    }
    measured = _measured(header, signals, idle) if reading.measured else {}
    unused = times | idle.keys() - {*measured.values()}
    if strange:
        _refuse_loops(header, signals, strange)
        unused |= {i for i in strange if reading.ignore_extra or header.is_of_message(i)}
    held, followed = _placed(header, signals, places, strange, reading)
    if absent := [name for name in extra if name not in called and name not in header.names]:
        remedy = alternatives(absent[0], header.names, "columns")
        raise header.error(f"no column {listing(absent)}, which the scene names", remedy)
    if unknown := [i for i in strange if i not in unused]:
        raise _unknown_error(header, signals, {meaning.place for meaning in meanings.values() if meaning}, unknown)
    units = {i: _unit(header, i, signals, place, meanings[i], reading.angle_unit) for place, i in places.items()}
    return Layout(
        names=header.names,
        clock=clock,
        q=tuple(places.get(("q", i), ABSENT) for i in range(len(signals.positions))),
        qd=tuple(places.get(("qd", i), ABSENT) for i in range(len(signals.velocities))),
        qdd=tuple(places.get(("qdd", i), ABSENT) for i in range(len(signals.velocities))),
        extra={**measured, **{name: (called if name in called else header.names).index(name) for name in extra}},
        parts={i: parts for i, (parts, _) in units.items() if parts != 1.0},
        told=frozenset(i for i, (_, told) in units.items() if told),
        held=held,
        followed=followed,
        notes=(f"columns not used: {listing(header.names[i] for i in sorted(unused))}",) if unused else (),
    )


def _set(header: Header, places: dict[T, int], place: T, i: int) -> None:
    if place in places:
        both = f"{header.names[places[place]]!r} and {header.names[i]!r}"
        raise header.error(f"columns {both} give the same quantity", "keep one of them")
    places[place] = i


def _measured(header: Header, signals: Signals, meanings: Mapping[int, Meaning]) -> dict[str, int]:
    """`tau_<joint>` -> column, of the torques that a table gives, each once and in N m (N for a slide)."""
    found: dict[str, int] = {}
    for i, (place, unit) in meanings.items():
        if place:
            _set(header, found, f"tau_{signals.velocities[place[1]]}", i)
            if unit is not None and "".join(filter(str.isalpha, unit)).lower() not in ("nm", "n"):
                what = f"column {header.names[i]!r}: {unit!r} is no unit that measured torques are read in"
                raise header.error(what, "give N m, or N for a slide")
    return found


def _unit(
    header: Header, i: int, signals: Signals, place: Place, meaning: Meaning | None, angle_unit: AngleUnit | None
) -> tuple[float, bool]:
    """How many of the unit of a column make one of SI, and whether that was told; raises if it cannot be its unit."""
    quantity, index = place
    stem = (signals.positions if quantity == "q" else signals.velocities)[index]
    kind, order = signals.kinds[stem], ("q", "qd", "qdd").index(quantity)
    text = meaning.unit if meaning else None
    if text is None and i in header.aliases:  # in brackets, or behind `_` what can be a unit of such a kind
        name = header.names[i]
        units = ((own, unit_of(own)) for _, own in split_unit(name))
        text = next((own for own, unit in units if name[-1] in "])" or (unit and unit.dimension == kind)), None)
    if text is None:
        turns = kind == "angle" and stem in signals.spans
        return (ANGLES[angle_unit or "rad"], angle_unit is not None) if turns else (1.0, False)
    unit = unit_of(text)
    if unit is None or (unit.dimension, unit.order) != (kind, order):
        names = {"angle": [*ANGLES], "length": ["m", "mm"], "": []}[kind]
        remedy = " or ".join(f"{name}{RATES[order]}" for name in names)
        what = f"column {header.names[i]!r}: {text!r} is no unit of the {MEASURED[quantity]} of {stem!r}"
        raise header.error(what, f"understood: {remedy}" if remedy else "it has none")
    return unit.parts, True


def _placed(
    header: Header, signals: Signals, places: Mapping[Place, int], unknown: Sequence[int], reading: Reading
) -> tuple[dict[int, float], tuple[str, ...]]:
    """What no column places: index in q -> position of what is held, and the joints that follow from loops, which are
    held only where they are named. Columns that are `unknown` may be meant for what is missing."""
    try:
        held = reading.hold.positions(signals, reading.angle_unit or "rad")
    except TrajectoryError as error:
        raise header.error(error.what, error.remedy or "") from None
    found: dict[int, float] = {}
    missing: list[str] = []
    followed: list[str] = []
    for name, (q, qd) in signals.spans.items():
        given = {i: header.names[places["q", i]] for i in q if ("q", i) in places}
        moved = [header.names[i] for (quantity, k), i in places.items() if quantity != "q" and k in qd]
        still = held.keys() & set(q)
        floating = len(q) > 1
        turn = [given[i] for i in q[3:] if i in given]
        if 0 < len(turn) < len(q) - 3:
            remedy = f"give {name}_qx, _qy, _qz and _qw, or none of them"
            raise header.error(f"the orientation of {name!r} is incomplete: only {listing(turn)}", remedy)
        if given or (floating and moved):  # of a floating joint one column will do
            still &= {i for i in q if {name, signals.positions[i]} & reading.hold.named.keys()}
        elif name in signals.looped and name not in reading.hold.named:
            if moved:
                what = f"column {moved[0]!r} moves joint {name!r}, and no column says where it is"
                raise header.error(what, f"give q_{name}, or leave it out: it follows from the loops")
            followed.append(name)
            still = set()
        elif not still:
            missing.append(name)
        if still and (both := [given[i] for i in sorted(still) if i in given] or ([] if floating else moved)):
            what = f"joint {name!r} is to be held, and column {both[0]!r} moves it"
            raise header.error(what, "leave one of them out")
        found |= {i: held[i] for i in sorted(still)}
    if missing:
        raise _incomplete(header, signals, missing, unknown)
    return found, tuple(followed)


def _refuse_loops(header: Header, signals: Signals, unknown: Sequence[int]) -> None:
    """Raise if unknown columns are what a simulation writes of loops, all six of `fx_<loop>` to `mz_<loop>`; of joints
    `torques --reactions` writes them, too, but for every joint."""
    there, joints = {header.names[i] for i in unknown}, {*signals.spans, *signals.dependent}
    names = [header.names[i][3:] for i in unknown if header.names[i].startswith(f"{COMPONENTS[0]}_")]
    whole = [name for name in names if there >= {f"{part}_{name}" for part in COMPONENTS}]
    loops = [name for name in whole if not joints <= {*whole} or name not in joints]
    if loops and signals.joints:
        first, last = (f"{part}_{loops[0]}" for part in (COMPONENTS[0], COMPONENTS[-1]))
        what = (
            f"columns '{first}' to '{last}' are what simulate writes of a loop, and the scene has no loop of that "
            "name: the torques would be those of the open tree"
        )
        remedy = f"give --scene with its [[loop]]; if {loops[0]!r} is no loop, rename its columns"
        raise header.error(what, remedy)


def _unknown_error(
    header: Header, signals: Signals, given: Collection[Place | None], unknown: Sequence[int]
) -> TrajectoryError:
    names = [header.names[i] for i in unknown]
    what = f"unknown column{'s' * (len(unknown) > 1)} {listing(names)}"
    leave = f"--ignore-extra leaves {'them' if len(unknown) > 1 else 'it'} out"
    if any(name.startswith("base_") for name in names):
        return header.error(what, f'a scene with [base] motion = "moving" uses base_ columns; {leave}')
    found = {ours: (signals.find(ours), theirs) for ours, theirs in _meant(names, signals).items()}
    free = {ours: theirs for ours, (meaning, theirs) in found.items() if meaning and meaning.place not in given}
    return header.error(what, f"{_asked(free)}there is {listing(header.names)}; {leave}")


def _meant(columns: Iterable[str], signals: Signals) -> dict[str, str]:
    """Our name -> the unknown column most like it, but for case, blanks, marks: `q_elbow` -> `Elbow angle [deg]`."""
    from difflib import SequenceMatcher, get_close_matches

    found: dict[str, tuple[float, str]] = {}
    for column in islice(columns, _COMPARED):
        best = (0.0, "")
        names = dict.fromkeys((column, *(bare for bare, _ in split_unit(column))))
        for quantity, rest in [reading for name in names for reading in [*worded(name)] or [("q", name)]]:
            ours = {_plain(name): name for name in (signals.positions if quantity == "q" else signals.velocities)}
            for stem in dict.fromkeys((_plain(rest), _plain(rest.rpartition("/")[2]))):
                for close in get_close_matches(stem, ours, n=1, cutoff=_ALIKE):
                    best = max(best, (SequenceMatcher(None, close, stem).ratio(), f"{quantity}_{ours[close]}"))
                inside = [name for name in ours if len(name) >= _LETTERS and name in stem]
                # and the number of a name, if it ends with one, is not part of a longer one
                cut_short = {x for x in inside if x[-1].isdigit() and stem.rpartition(x)[2][:1].isdigit()}
                if inside := [name for name in inside if name not in cut_short]:
                    best = max(best, (_ALIKE, f"{quantity}_{ours[max(inside, key=len)]}"))
        likeness, name = best
        if name and likeness > found.get(name, (0.0,))[0]:
            found[name] = likeness, column
    return {name: column for name, (_, column) in found.items()}


def _asked(matches: Mapping[str, str]) -> str:
    if not matches:
        return ""
    name, column = next(iter(matches.items()))
    return f"did you mean {column!r} for {name!r}? then {_options(matches)}; "


def _options(matches: Mapping[str, str]) -> str:
    from shlex import quote

    return " ".join(f"--map {quote(f'{ours}={theirs}')}" for ours, theirs in [*matches.items()][:_OPTIONS])


def _plain(name: str) -> str:
    return "".join(filter(str.isalnum, name)).lower()


def _incomplete(header: Header, signals: Signals, missing: Sequence[str], unknown: Sequence[int]) -> TrajectoryError:
    there = f"there is {listing(header.names)}"
    if free := [name for name in missing if len(signals.spans[name][0]) > 1]:
        name = free[0]
        remedy = f"give {' '.join(f'{name}_{part}' for part in POSE)}, or any of them; --hold {name}={REST}; {there}"
        return header.error(f"no column says where {name!r} is, which moves freely", remedy)
    if entries := [header.names[i] for i in unknown if header.entry(i) == "q"]:
        such = _options({f"q_{name}": column for name, column in zip(missing, entries, strict=False)})
        return header.error(f"columns {listing(entries)} do not tell which joints they are of", f"say it, as in {such}")
    matches = _meant([header.names[i] for i in unknown], signals)
    matches = {ours: theirs for ours, theirs in matches.items() if ours.removeprefix("q_") in missing}
    rest = f"--hold {REST} keeps joints without columns still"
    return header.error(f"no position of joint {listing(missing)}", f"{_asked(matches)}{rest}; {there}")
