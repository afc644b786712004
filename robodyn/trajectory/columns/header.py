"""The names of a table's columns, and what those are called that the robot would not know by their own."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from robodyn.errors import TrajectoryError
from robodyn.support.input_limits import beyond, limits
from robodyn.support.wording import alternatives, shown
from robodyn.trajectory.columns.signals import ANY_WORD, MEASURED, WORDS, Quantity, Signals
from robodyn.trajectory.columns.units import is_time

_INDEX = r"(?:\[(?P<index>\d+)\]|[._/]?(?P<behind>\d+))"
_ARRAY = re.compile(rf"(?P<path>(?:.*[./_])?)(?!q){ANY_WORD}{_INDEX}")
"""Entries of arrays; those called q, qd and qdd are ours, in the order of the description."""
_LABEL = re.compile(rf"(?P<path>(?:.*[./_])?)(?:joint_)?names?{_INDEX}", re.IGNORECASE)

_SHOWN = 8


@dataclass(frozen=True)
class Header:
    """The column names of a table, and where they stand, for messages.

    Attributes:
        aliases: place of a column -> what it is called instead; `called`: the names that count.
    """

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
        seen = set[str]()
        for i, name in enumerate(self.names):
            if not name:
                what = f"column {i + 1} of {len(self.names)} has no name"
                raise self.error(what, "name every column in the header")
            if name in seen:
                raise self.error(f"column {name!r} appears twice", "keep one of them")
            seen.add(name)

    def renamed(self, columns: Mapping[str, str], signals: Signals, extra: Collection[str]) -> Header:
        """The header with columns called as a person wants it: our name -> the table's.

        Raises:
            TrajectoryError: the robot does not know the one, or the table has not the other.
        """
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

    def entry(self, i: int) -> Quantity | None:
        """What a column measures of a joint that it does not name, None if it is no entry of an array."""
        found = _ARRAY.fullmatch(self.called[i])
        return WORDS[found["word"].lower()] if found else None


def check_columns(count: int, file: str | None, line: int | None = None) -> None:
    """Raise if there are more columns than are read."""
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
