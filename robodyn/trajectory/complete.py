"""Whether a table says where every joint is, and which joints are held still instead."""

from __future__ import annotations

from collections.abc import Sequence

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns import POSE, Place, Signals
from robodyn.trajectory.header import Header, listing
from robodyn.trajectory.reading import REST, Reading

Places = dict[Place, int]


def held_still(
    header: Header, signals: Signals, places: Places, unknown: Sequence[int], reading: Reading
) -> dict[int, float]:
    """Return index in q -> position of what is held because no column says where it is.

    Args:
        places: (quantity, index) -> column; unknown: columns without a meaning, which may be meant for what is missing.

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
    for name, (q, qd) in signals.spans.items():
        given = {i: header.names[places["q", i]] for i in q if ("q", i) in places}
        moved = [header.names[i] for (quantity, k), i in places.items() if quantity != "q" and k in qd]
        still = held.keys() & set(q)
        floating = len(q) > 1
        if floating:
            _check_turn(header, name, [given[i] for i in q[3:] if i in given])
        if given or (floating and moved):  # of a floating joint one column will do
            still &= {i for i in q if {name, signals.positions[i]} & reading.hold.named.keys()}
        elif not still:
            missing.append(name)
        if still and (both := [given[i] for i in sorted(still) if i in given] or ([] if floating else moved)):
            raise header.error(
                f"joint {name!r} is to be held, and column {both[0]!r} moves it", "leave one of them out"
            )
        found |= {i: held[i] for i in sorted(still)}
    if missing:
        raise _incomplete(header, signals, missing, unknown)
    return found


def _check_turn(header: Header, name: str, given: Sequence[str]) -> None:
    if 0 < len(given) < 4:
        remedy = f"give {name}_qx, _qy, _qz and _qw, or none of them"
        raise header.error(f"the orientation of {name!r} is incomplete: only {listing(given)}", remedy)


def _incomplete(header: Header, signals: Signals, missing: Sequence[str], unknown: Sequence[int]) -> TrajectoryError:
    from robodyn.trajectory.unknown_columns import asked, meant, options

    there = f"there is {listing(header.names)}"
    if free := [name for name in missing if len(signals.spans[name][0]) > 1]:
        name = free[0]
        remedy = f"give {' '.join(f'{name}_{part}' for part in POSE)}, or any of them; --hold {name}={REST}; {there}"
        return header.error(f"no column says where {name!r} is, which moves freely", remedy)
    if entries := [header.names[i] for i in unknown if header.entry(i) == "q"]:
        such = options({f"q_{name}": column for name, column in zip(missing, entries, strict=False)})
        return header.error(f"columns {listing(entries)} do not tell which joints they are of", f"say it, as in {such}")
    matches = meant([header.names[i] for i in unknown], signals)
    matches = {ours: theirs for ours, theirs in matches.items() if ours.removeprefix("q_") in missing}
    rest = f"--hold {REST} keeps joints without columns still"
    return header.error(f"no position of joint {listing(missing)}", f"{asked(matches)}{rest}; {there}")
