"""Messages about joints as a table: one row per message, joints of other publishers put onto its stamps."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats
from robodyn.support.input_limits import beyond, limits
from robodyn.support.wording import count
from robodyn.trajectory.columns.header import listing
from robodyn.trajectory.readers.messages import NANO, QUANTITIES, State
from robodyn.trajectory.readers.table import ArrayTable

_GAP = 4.5
"""So many of its steps without a message, and nothing is said of a joint between."""


class LogTable(ArrayTable):
    """A table of messages: what it has beyond the robot is left out.

    Rows are the messages of the publisher that has most: those about one set of joints, and of such with the same stamp
    the first. Joints that only others tell of are interpolated onto its stamps, linearly.

    Attributes:
        notes: what became of the messages.

    Raises:
        TrajectoryError: there are no messages, or none that has positions.
    """

    leaves_out = True

    def __init__(self, file: str, states: Sequence[State]) -> None:
        if not states:
            raise TrajectoryError("has no messages", remedy="is the log complete?", file=file)
        first, *others = _publishers(states)
        notes: list[str] = []
        rows = _once(first, notes)
        stamps = _stamps(rows)
        columns: dict[str, NDArray[Any]] = {"sec": stamps // NANO, "nanosec": stamps % NANO}
        columns |= _columns(rows, rows[0].names, notes)
        told, left = {*rows[0].names}, 0
        self._between: dict[str, NDArray[np.bool_]] = {}
        for other in others:
            new = [name for name in other[0].names if name not in told]
            told |= {*new}
            left += 0 if new else len(other)
            own = _once(sorted(other, key=lambda state: state.stamp), [])
            for name, values in _columns(own, new, notes).items():
                if len(columns) * len(stamps) > limits().log_values:
                    what = f"{len(columns)} columns of {len(stamps)} rows"
                    raise beyond("log_values", what, TrajectoryError, file=file)
                columns[name], self._between[name] = _onto(stamps, _stamps(own), values, turns=name.startswith("q_"))
        if left:
            notes.append(f"{count(left, 'message')} about fewer joints left out")
        if not any(name.startswith("q_") for name in columns):
            raise TrajectoryError("no messages with positions", remedy="is it another topic?", file=file)
        self.notes = tuple(notes)
        super().__init__(file, columns)

    def choose(self, columns: Sequence[int]) -> None:
        """Leave out rows that are not between messages about joints of these columns.

        Raises:
            TrajectoryError: none is.
        """
        between = {name: self._between[name] for name in (self.names[i] for i in columns) if name in self._between}
        if not between:
            return
        rows = np.logical_and.reduce([*between.values()])
        joints = listing(dict.fromkeys(name.partition("_")[2] for name in between))
        if not rows.any():
            what = f"messages about {joints} and those about the other joints are of different times"
            raise TrajectoryError(what, remedy="record them together", file=self.file)
        self.notes += (f"messages of another publisher about {joints} are interpolated onto the stamps of the others",)
        if lost := self._rows - int(rows.sum()):
            self.notes += (f"{count(lost, 'message')} left out, not between two about {joints}",)
        self._arrays, self._rows = [values[rows] for values in self._arrays], int(rows.sum())


def whole_joints(columns: Mapping[str, str], there: Collection[str]) -> dict[str, str]:
    """Return our names -> those of a log, with the other quantities of joints whose positions are among them.

    Args:
        there: the columns of the log.
    """
    found = dict(columns)
    for ours, theirs in columns.items():
        if ours.startswith("q_") and theirs.startswith("q_"):
            for letter in QUANTITIES.values():
                if f"{letter}{theirs[1:]}" in there:
                    found.setdefault(f"{letter}{ours[1:]}", f"{letter}{theirs[1:]}")
    return found


def _publishers(states: Sequence[State]) -> list[list[State]]:
    """Return the messages about each set of joints, those of the most frequent first."""
    found: dict[frozenset[str], list[State]] = {}
    for state in states:
        found.setdefault(frozenset(state.names), []).append(state)
    return [found[names] for names in sorted(found, key=lambda names: (-len(found[names]), -len(names)))]


def _once(states: Sequence[State], notes: list[str]) -> list[State]:
    """Return messages without those that have the stamp of the one before, and note how many there were."""
    new = [states[0], *(b for a, b in pairwise(states) if b.stamp != a.stamp)]
    if len(new) < len(states):
        notes.append(f"{count(len(states) - len(new), 'message')} with the stamp of the one before left out")
    return new


def _stamps(states: Sequence[State]) -> NDArray[np.int64]:
    return np.array([state.stamp for state in states], dtype=np.int64)


def _columns(states: Sequence[State], names: Sequence[str], notes: list[str]) -> dict[str, Floats]:
    """Return the columns of joints, of quantities that all messages have; note what some lack, or have as NaN only."""
    columns: dict[str, Floats] = {}
    for quantity, letter in QUANTITIES.items():
        having = [state for state in states if len(state.values.get(quantity, ())) == len(state.names) > 0]
        if len(having) == len(states):
            rows = np.array([_in_order(state, names, quantity) for state in states])
            lost = [name for i, name in enumerate(names) if quantity != "position" and np.isnan(rows[:, i]).all()]
            columns |= {f"{letter}_{name}": rows[:, i] for i, name in enumerate(names) if name not in lost}
            if lost:
                notes.append(f"{quantity} of {listing(lost)} is NaN in every message: read as not measured")
        elif having and names:
            lacking = len(states) - len(having)
            notes.append(f"{quantity} is not used: {count(lacking, 'message')} of {len(states)} lack it")
    return columns


def _in_order(state: State, names: Sequence[str], quantity: str) -> Sequence[float]:
    """Return the values of a message in the order of these names."""
    values = state.values[quantity]
    if state.names == names:
        return values
    place = {name: i for i, name in enumerate(state.names)}
    return [values[place[name]] for name in names]


def _onto(
    stamps: NDArray[np.int64], own: NDArray[np.int64], values: Floats, turns: bool
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return values at other stamps, and where these stand between two messages without a gap.

    Args:
        stamps: (N,) ns; own: (k,) of the values [ns], increasing; values: (k,).
        turns: whether a change by more than pi is a turn around, in which nothing stands between: the nearer counts.
    """
    before = np.maximum(np.searchsorted(own, stamps, "right") - 1, 0)
    after = np.minimum(np.searchsorted(own, stamps), len(own) - 1)
    span = own[after] - own[before]
    part = (stamps - own[before]) / np.maximum(span, 1)
    if turns:
        part = np.where(np.abs(values[after] - values[before]) > pi, np.rint(part), part)
    found = (1.0 - part) * values[before] + part * values[after]
    typical = np.median(np.diff(own)) if len(own) > 1 else 0.0
    return found, (own[before] <= stamps) & (stamps <= own[after]) & (span <= _GAP * typical)
