"""Columns that the robot does not know, and joints of which no column says where they are.

What is left out, what is said of others, what they may be meant for, and which joints are held still instead.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import islice

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns.layout import Header, listing
from robodyn.trajectory.columns.signals import COMPONENTS, POSE, Place, Quantity, Signals, worded
from robodyn.trajectory.columns.units import split_unit
from robodyn.trajectory.reading import REST

_HEADER = re.compile(r"(?:.*[./_])?header[./_](?:seq|frame_id)")
"""Fields of a message of ROS that no motion needs."""
_ALIKE = 0.7
_LETTERS = 3
"""Letters at least of a name that another may have in it."""
_COMPARED, _OPTIONS = 200, 8
"""So many unknown columns are compared with the names of joints, so many options written out."""


def is_of_message(header: Header, i: int) -> bool:
    """Whether a column is of a message of ROS and needed for no motion."""
    return i in header.labels or header.entry(i) == "tau" or _HEADER.fullmatch(header.names[i]) is not None


def refuse_loops(header: Header, signals: Signals, unknown: Sequence[int]) -> None:
    """Raise if unknown columns are what a simulation writes of loops.

    A loop has all six of `fx_<loop>` to `mz_<loop>`. Those of joints may be what `torques --reactions` writes, which
    writes them for every joint; a loop that bears a joint's name is known by the joints that have none.
    """
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


def unknown_error(
    header: Header, signals: Signals, given: Collection[Place | None], unknown: Sequence[int]
) -> TrajectoryError:
    """The error about unknown columns, with what they may be meant for, if that is not given."""
    names = [header.names[i] for i in unknown]
    what = f"unknown column{'s' * (len(unknown) > 1)} {listing(names)}"
    leave = f"--ignore-extra leaves {'them' if len(unknown) > 1 else 'it'} out"
    if any(name.startswith("base_") for name in names):
        return header.error(what, f'a scene with [base] motion = "moving" uses base_ columns; {leave}')
    found = {ours: (signals.find(ours), theirs) for ours, theirs in _meant(names, signals).items()}
    free = {ours: theirs for ours, (meaning, theirs) in found.items() if meaning and meaning.place not in given}
    return header.error(what, f"{_asked(free)}there is {listing(header.names)}; {leave}")


def _meant(columns: Iterable[str], signals: Signals) -> dict[str, str]:
    """Our name -> the unknown column that is most like it: `q_elbow` -> `Elbow angle [deg]`.

    Case, blanks and marks do not count; a name that has all of ours in it is like it, too. A column whose words tell a
    velocity is proposed for a velocity only, and so on.
    """
    from difflib import SequenceMatcher, get_close_matches

    found: dict[str, tuple[float, str]] = {}
    for column in islice(columns, _COMPARED):
        best = (0.0, "")
        for quantity, stem in _readings(column):
            ours = {_plain(name): name for name in (signals.positions if quantity == "q" else signals.velocities)}
            for close in get_close_matches(stem, ours, n=1, cutoff=_ALIKE):
                best = max(best, (SequenceMatcher(None, close, stem).ratio(), f"{quantity}_{ours[close]}"))
            if within := max((each for each in ours if _within(each, stem)), key=len, default=""):
                best = max(best, (_ALIKE, f"{quantity}_{ours[within]}"))
        likeness, name = best
        if name and likeness > found.get(name, (0.0,))[0]:
            found[name] = likeness, column
    return {name: column for name, (_, column) in found.items()}


def _within(name: str, stem: str) -> bool:
    """Whether a name is part of another, and its number, if it ends with one, is not part of a longer one."""
    _, found, rest = stem.rpartition(name) if name else ("", "", "")
    return len(found) >= _LETTERS and not (name[-1].isdigit() and rest[:1].isdigit())


def _asked(matches: Mapping[str, str]) -> str:
    """The question whether columns are meant so, and the options that say yes; empty if there are none."""
    for name, column in matches.items():
        return f"did you mean {column!r} for {name!r}? then {_options(matches)}; "
    return ""


def _options(matches: Mapping[str, str]) -> str:
    from shlex import quote

    return " ".join(f"--map {quote(f'{ours}={theirs}')}" for ours, theirs in [*matches.items()][:_OPTIONS])


def _readings(column: str) -> Iterator[tuple[Quantity, str]]:
    """What the words of a name may tell, and the rest, plain, with and without what stands before slashes."""
    for name in dict.fromkeys((column, *(bare for bare, _ in split_unit(column)))):
        for quantity, stem in [*worded(name)] or [("q", name)]:
            yield from ((quantity, _plain(part)) for part in dict.fromkeys((stem, stem.rpartition("/")[2])))


def _plain(name: str) -> str:
    return "".join(filter(str.isalnum, name)).lower()


def incomplete(header: Header, signals: Signals, missing: Sequence[str], unknown: Sequence[int]) -> TrajectoryError:
    """What is raised where no column places joints that are not held."""
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
