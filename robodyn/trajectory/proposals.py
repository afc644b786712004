"""What a column that the robot does not know may be meant for, and the option that says so."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from robodyn.trajectory.columns import Quantity, Signals, worded
from robodyn.trajectory.units import split_unit

_ALIKE = 0.7
_OPTIONS = 8
"""So many options are written out."""


def meant(columns: Iterable[str], signals: Signals) -> dict[str, str]:
    """Return our name -> the unknown column that is most like it: `q_elbow` -> `Elbow angle [deg]`.

    Case, blanks and marks do not count. A column whose words tell a velocity is proposed for a velocity only.
    """
    from difflib import SequenceMatcher, get_close_matches

    found: dict[str, tuple[float, str]] = {}
    for column in columns:
        best = (0.0, "")
        for quantity, stem in _readings(column):
            ours = {_plain(name): name for name in (signals.positions if quantity == "q" else signals.velocities)}
            for close in get_close_matches(stem, ours, n=1, cutoff=_ALIKE):
                best = max(best, (SequenceMatcher(None, close, stem).ratio(), f"{quantity}_{ours[close]}"))
        likeness, name = best
        if name and likeness > found.get(name, (0.0,))[0]:
            found[name] = likeness, column
    return {name: column for name, (_, column) in found.items()}


def asked(matches: Mapping[str, str]) -> str:
    """Return the question whether columns are meant so, and the options that say yes; empty if there are none."""
    if not matches:
        return ""
    name, column = next(iter(matches.items()))
    return f"did you mean {column!r} for {name!r}? then {options(matches)}; "


def options(matches: Mapping[str, str]) -> str:
    """Return the options that call columns by our names, those of the first few."""
    from shlex import quote

    return " ".join(f"--map {quote(f'{ours}={theirs}')}" for ours, theirs in [*matches.items()][:_OPTIONS])


def _readings(column: str) -> Iterator[tuple[Quantity, str]]:
    """Yield what the words of a name may tell, and the rest, plain, with and without what stands before slashes."""
    for name in dict.fromkeys((column, *(bare for bare, _ in split_unit(column)))):
        for quantity, stem in [*worded(name)] or [("q", name)]:
            if quantity != "tau":
                yield from ((quantity, _plain(part)) for part in dict.fromkeys((stem, stem.rpartition("/")[2])))


def _plain(name: str) -> str:
    return "".join(filter(str.isalnum, name)).lower()
