"""Header of a table + signals of a robot -> which column holds what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from robodyn.errors import TrajectoryError
from robodyn.support.wording import alternatives
from robodyn.trajectory.columns.header import Header, listing
from robodyn.trajectory.columns.signals import MEASURED, TIME_NAMES, Meaning, Place, Signals
from robodyn.trajectory.columns.units import ANGLES, RATES, AngleUnit, Clock, clocks, split_unit, unit_of
from robodyn.trajectory.reading import DEFAULT, Reading

ABSENT = -1
T = TypeVar("T")


@dataclass(frozen=True)
class Layout:
    """Where each quantity stands in the table: the index of its column, ABSENT where there is none.

    Attributes:
        parts: column -> how many of its unit make one of SI, where that is not 1.
        told: columns whose unit is told by a name or an option, and not only assumed.
        extra: name of a column that the scene needs, or `tau_<joint>` of a measured torque -> its index.
        held: index in q -> position of what has no column and is held.
        followed: joints that have no column and follow from loops.
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
    """The layout of a table.

    Args:
        signals: what the robot wants; every scalar joint needs its position, a floating joint any one of its columns,
            unless loops tell.
        extra: columns that the scene names; they must exist.

    Raises:
        TrajectoryError: a name is empty or appears twice, a quantity is given twice or in a unit that it cannot have, a
            column is unknown or missing, or columns are those of loops, whether unknown ones are left out or not.
    """
    header.check()
    header = header.renamed(reading.columns, signals, extra)
    called = header.called
    clock, times = _clock(header, signals, reading)
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
        from robodyn.trajectory.columns.unknown_columns import is_of_message, refuse_loops

        refuse_loops(header, signals, strange)
        unused |= {i for i in strange if reading.ignore_extra or is_of_message(header, i)}
    held, followed = _placed(header, signals, places, strange, reading)
    if absent := [name for name in extra if name not in called and name not in header.names]:
        remedy = alternatives(absent[0], header.names, "columns")
        raise header.error(f"no column {listing(absent)}, which the scene names", remedy)
    if unknown := [i for i in strange if i not in unused]:
        from robodyn.trajectory.columns.unknown_columns import unknown_error

        raise unknown_error(header, signals, {meaning.place for meaning in meanings.values() if meaning}, unknown)
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


def _clock(header: Header, signals: Signals, reading: Reading) -> tuple[Clock, set[int]]:
    """What tells the time, and the columns that could have."""
    names = {i: name for i, name in enumerate(header.called) if name in TIME_NAMES or signals.find(name) is None}
    found, others = clocks(names, header.aliases)
    if not found:
        remedy = f"name it 'time', or say which it is: --map time=NAME; columns: {listing(header.names)}"
        raise header.error("no column of time", remedy)
    if len(found) > 1:
        both = listing(header.names[clock.column] for clock in found)
        raise header.error(f"time is given {len(found)} times, by {both}", "keep one of them, or --map time=NAME")
    return found[0].in_unit(reading.time_unit), others


def _set(header: Header, places: dict[T, int], place: T, i: int) -> None:
    if place in places:
        both = f"{header.names[places[place]]!r} and {header.names[i]!r}"
        raise header.error(f"columns {both} give the same quantity", "keep one of them")
    places[place] = i


def _measured(header: Header, signals: Signals, meanings: Mapping[int, Meaning]) -> dict[str, int]:
    """`tau_<joint>` -> column, of the torques that a table gives.

    Raises:
        TrajectoryError: two columns give the same torque, or a unit is not N m (N for a slide).
    """
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
    """How many of the unit of a column make one of SI, and whether that was told.

    Args:
        angle_unit: of scalar joints whose columns do not tell, None for rad.

    Raises:
        TrajectoryError: the unit in a name is none, or not one of this quantity.
    """
    quantity, index = place
    stem = (signals.positions if quantity == "q" else signals.velocities)[index]
    kind, order = signals.kinds[stem], ("q", "qd", "qdd").index(quantity)
    text = meaning.unit if meaning else None
    if text is None and i in header.aliases:
        text = _own_unit(header.names[i], kind)
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


def _own_unit(name: str, kind: str) -> str | None:
    """The unit in any name: what is in brackets; behind `_` only what can be one of such a kind."""
    for _, text in split_unit(name):
        unit = unit_of(text)
        if name[-1] in "])" or (unit and unit.dimension == kind):
            return text
    return None


def _placed(
    header: Header, signals: Signals, places: Mapping[Place, int], unknown: Sequence[int], reading: Reading
) -> tuple[dict[int, float], tuple[str, ...]]:
    """What no column places: index in q -> position of what is held, and the joints that follow from loops.

    Joints of loops are held where they are named, and not where all are.

    Args:
        unknown: columns without a meaning, which may be meant for what is missing.

    Raises:
        TrajectoryError: a scalar joint has no position and is not held, a floating joint has no column at all or part
            of a quaternion, or a column moves what is to be held.
    """
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
        from robodyn.trajectory.columns.unknown_columns import incomplete

        raise incomplete(header, signals, missing, unknown)
    return found, tuple(followed)
