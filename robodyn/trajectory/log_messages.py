"""Messages of ROS about joints, as tables: JointState, DynamicJointState and JointTrajectory of any version."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import TrajectoryError
from robodyn.support.wording import count
from robodyn.trajectory.table import ArrayTable

QUANTITIES = {"position": "q", "velocity": "qd", "acceleration": "qdd", "effort": "tau"}
"""What messages call what columns are called."""
NANO = 1_000_000_000


class State(NamedTuple):
    """What one message, or one point of a trajectory, says of joints.

    Attributes:
        stamp: ns; names: of joints; values: by quantity, in the order of the names, as far as they are given.
    """

    stamp: int
    names: tuple[str, ...]
    values: Mapping[str, Sequence[float]]


class LogTable(ArrayTable):
    """A table of messages: what it has beyond the robot is left out.

    Attributes:
        notes: what became of the messages.
    """

    leaves_out = True

    def __init__(self, file: str, states: Sequence[State]) -> None:
        columns, self.notes = columns_of(states, file)
        super().__init__(file, columns)


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


def columns_of(states: Sequence[State], file: str) -> tuple[dict[str, NDArray[Any]], tuple[str, ...]]:
    """Return the columns of a table, and notes on what is not in it.

    Rows are the messages that have the joints that most of them have; of those with the same stamp the first.

    Raises:
        TrajectoryError: there are no messages, or none that has positions.
    """
    if not states:
        raise TrajectoryError("has no messages", remedy="is the log complete?", file=file)
    sets = Counter(frozenset(state.names) for state in states)
    joints = max(sets, key=lambda names: (sets[names], len(names)))
    kept = [state for state in states if frozenset(state.names) == joints]
    notes = []
    if len(kept) < len(states):
        notes.append(f"{count(len(states) - len(kept), 'message')} about other joints left out")
    new = [kept[0], *(b for a, b in pairwise(kept) if b.stamp != a.stamp)]
    if len(new) < len(kept):
        notes.append(f"{count(len(kept) - len(new), 'message')} with the stamp of the one before left out")
    stamps = np.array([state.stamp for state in new], dtype=np.int64)
    columns: dict[str, NDArray[Any]] = {"sec": stamps // NANO, "nanosec": stamps % NANO}
    names = new[0].names
    for quantity, letter in QUANTITIES.items():
        having = [state for state in new if len(state.values.get(quantity, ())) == len(state.names)]
        if len(having) == len(new):
            rows = np.array([_in_order(state, names, quantity) for state in new])
            columns |= {f"{letter}_{name}": rows[:, i] for i, name in enumerate(names)}
        elif having:
            lacking = len(new) - len(having)
            notes.append(f"{quantity} is not used: {count(lacking, 'message')} of {len(new)} lack it")
    if not any(name.startswith("q_") for name in columns):
        raise TrajectoryError("no messages with positions", remedy="is it another topic?", file=file)
    return columns, tuple(notes)


def _in_order(state: State, names: tuple[str, ...], quantity: str) -> Sequence[float]:
    """Return the values of a message in the order of these names."""
    values = state.values[quantity]
    if state.names == names:
        return values
    place = {name: i for i, name in enumerate(state.names)}
    return [values[place[name]] for name in names]


def joint_state(message: Any, recorded: int) -> State:
    """Return what a sensor_msgs/JointState says.

    Args:
        message: an object with these attributes, or a mapping; recorded: ns, when, for messages without a stamp.
    """
    stamp = _stamp(_get(_get(message, "header"), "stamp"))
    values = {quantity: _get(message, quantity) for quantity in ("position", "velocity", "effort")}
    return State(stamp or recorded, tuple(_get(message, "name")), _numbers(values))


def dynamic_joint_state(message: Any, recorded: int) -> State:
    """Return what a control_msgs/DynamicJointState says; only interfaces that all of its joints have count."""
    names, each = tuple(_get(message, "joint_names")), []
    for values in _get(message, "interface_values"):
        each.append(dict(zip(_get(values, "interface_names"), _get(values, "values"), strict=False)))
    stamp = _stamp(_get(_get(message, "header"), "stamp"))
    common = [quantity for quantity in QUANTITIES if each and all(quantity in values for values in each)]
    return State(stamp or recorded, names, {quantity: [values[quantity] for values in each] for quantity in common})


def joint_trajectory(message: Any) -> list[State]:
    """Return the points of a trajectory_msgs/JointTrajectory, from its own start on."""
    names, plural = tuple(_get(message, "joint_names")), {"position": "positions", "velocity": "velocities"}
    plural |= {"acceleration": "accelerations", "effort": "effort"}
    return [
        State(
            _stamp(_get(point, "time_from_start")),
            names,
            _numbers({quantity: _get(point, name) for quantity, name in plural.items()}),
        )
        for point in _get(message, "points") or ()
    ]


def _get(message: Any, name: str) -> Any:
    """Return a part of a message, None if it has none."""
    return message.get(name) if isinstance(message, Mapping) else getattr(message, name, None)


def _numbers(values: Mapping[str, Any]) -> dict[str, Sequence[float]]:
    return {quantity: found for quantity, found in values.items() if found is not None and len(found)}


def _stamp(stamp: Any) -> int:
    """Return a stamp in ns: seconds as a number, or sec and nanosec, as ROS 1 has them too."""
    if stamp is None:
        return 0
    if isinstance(stamp, (int, float)):
        return round(stamp * NANO)
    parts = [next((x for x in (_get(stamp, name) for name in names) if x is not None), 0) for names in _STAMPS]
    return int(parts[0]) * NANO + int(parts[1])


_STAMPS = (("sec", "secs"), ("nanosec", "nsec", "nsecs", "nanosecs"))
KINDS: Mapping[str, Callable[[Any, int], State]] = {
    "JointState": joint_state,
    "DynamicJointState": dynamic_joint_state,
}
TRAJECTORY = "JointTrajectory"
KNOWN = (*KINDS, TRAJECTORY)


def states_of(kind: str, messages: Iterable[tuple[Any, int]], file: str) -> list[State]:
    """Return what messages of one kind say, each given with the time of its record [ns].

    Raises:
        TrajectoryError: there are several trajectories.
    """
    if kind != TRAJECTORY:
        return [KINDS[kind](message, recorded) for message, recorded in messages]
    found = [message for message, _ in messages]
    if len(found) > 1:
        what = f"has {len(found)} trajectories of joints, each with a time of its own"
        raise TrajectoryError(what, remedy="write each to a file of its own", file=file)
    return joint_trajectory(found[0]) if found else []
