"""Messages of ROS about joints as a table: JointState, DynamicJointState and JointTrajectory of any version, of bags,
or as text, JSON or the YAML that MoveIt and `ros2 topic echo` write."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from itertools import pairwise
from math import pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import TrajectoryError
from robodyn.support.extras import need
from robodyn.support.floats import Floats
from robodyn.support.input_file import beyond, limits, parse_json, read_input
from robodyn.support.wording import count, shown
from robodyn.trajectory.columns.layout import listing
from robodyn.trajectory.formats.table import ArrayTable, decoding

QUANTITIES = {"position": "q", "velocity": "qd", "acceleration": "qdd", "effort": "tau"}
"""What messages call what columns are called."""
NANO = 1_000_000_000
_LATEST = 1 << 62  # ns, either way: stamps and their differences are whole numbers of 64 bits
_STAMPS = (("sec", "secs"), ("nanosec", "nsec", "nsecs", "nanosecs"))
_WHOLE = re.compile(r"[-+]?[0-9]{1,18}")
_NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_FURTHER = re.compile(r"([-+]?)\.(inf|Inf|INF|nan|NaN|NAN)")
_GAP = 4.5  # so many of its steps without a message, and nothing is said of a joint between


class State(NamedTuple):
    """What one message, or one point of a trajectory, says of joints at a stamp [ns]: values by quantity, in the order
    of the names, as far as they are given."""

    stamp: int
    names: tuple[str, ...]
    values: Mapping[str, Sequence[float]]


def joint_state(message: Any, recorded: int) -> list[State]:
    """What a sensor_msgs/JointState, an object or a mapping, says; `recorded` [ns] is its stamp if it has none. Raises
    a ValueError where something else stands in place of names or numbers."""
    stamp = _stamp(_get(_get(message, "header"), "stamp"))
    values = {quantity: _get(message, quantity) for quantity in ("position", "velocity", "effort")}
    return [State(stamp or recorded, _names(_get(message, "name"), "name"), _numbers(values))]


def dynamic_joint_state(message: Any, recorded: int) -> list[State]:
    """What a control_msgs/DynamicJointState says; only interfaces that all of its joints have count."""
    names, each = _names(_get(message, "joint_names"), "joint_names"), []
    for values in _parts(_get(message, "interface_values"), "interface_values"):
        interfaces = _names(_get(values, "interface_names"), "interface_names")
        numbers = _numbers({"values": _get(values, "values")}).get("values", ())
        each.append(dict(zip(interfaces, numbers, strict=False)))
    stamp = _stamp(_get(_get(message, "header"), "stamp"))
    common = [quantity for quantity in QUANTITIES if each and all(quantity in values for values in each)]
    return [State(stamp or recorded, names, {quantity: [values[quantity] for values in each] for quantity in common})]


def joint_trajectory(message: Any, recorded: int = 0) -> list[State]:
    """The points of a trajectory_msgs/JointTrajectory, from its own start on."""
    names, plural = _names(_get(message, "joint_names"), "joint_names"), {"position": "positions"}
    plural |= {"velocity": "velocities", "acceleration": "accelerations", "effort": "effort"}
    states = []
    for point in _parts(_get(message, "points"), "points"):
        values = _numbers({quantity: _get(point, name) for quantity, name in plural.items()})
        states.append(State(_stamp(_get(point, "time_from_start")), names, values))
    return states


def _get(message: Any, name: str) -> Any:
    return message.get(name) if isinstance(message, Mapping) else getattr(message, name, None)


def _names(values: Any, what: str) -> tuple[str, ...]:
    names = _parts(values, what)
    if wrong := [name for name in names if isinstance(name, bool) or not isinstance(name, (str, int))]:
        raise ValueError(f"{what} has {shown(str(wrong[0]))}, which is no name")
    return tuple(map(str, names))


def _parts(values: Any, what: str) -> list[Any]:
    if values is None:
        return []
    if not isinstance(values, list):
        raise ValueError(f"{what} is {shown(str(values))}, not a list")
    return values


def _numbers(values: Mapping[str, Any]) -> dict[str, Sequence[float]]:
    found: dict[str, Sequence[float]] = {}
    for quantity, given in values.items():
        if isinstance(given, np.ndarray) and given.ndim == 1 and given.dtype.kind in "fiu":
            numbers: Any = given
        else:
            numbers = [_number(value, quantity) for value in _parts(given, quantity)]
        if len(numbers) > 0:
            found[quantity] = numbers
    return found


def _number(value: Any, what: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{what} has {shown(str(value))}, which is no number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{what} has a number beyond 1.8e308") from None


def _stamp(stamp: Any) -> int:
    """A stamp in ns: seconds as a number, or sec and nanosec, as ROS 1 has them too."""
    if stamp is None:
        return 0
    if isinstance(stamp, (str, int, float)):
        parts = [stamp, 0]
    else:
        parts = [next((x for x in (_get(stamp, name) for name in names) if x is not None), 0) for names in _STAMPS]
    seconds, nano = (_number(part, "the stamp") for part in parts)
    if not abs(seconds) * NANO + abs(nano) < _LATEST:
        raise ValueError(f"the stamp is {seconds:g} s and {nano:g} ns, beyond 146 years")
    whole = [part if isinstance(part, int) else 0 for part in parts]
    return round((seconds - whole[0]) * NANO) + whole[0] * NANO + round(nano - whole[1]) + whole[1]


TRAJECTORY = "JointTrajectory"
KINDS: dict[str, tuple[Callable[[Any, int], list[State]], set[str]]] = {
    "JointState": (joint_state, {"name", "position"}),
    "DynamicJointState": (dynamic_joint_state, {"joint_names", "interface_values"}),
    TRAJECTORY: (joint_trajectory, {"joint_names", "points"}),
}
"""By kind, what reads a message, and the keys by which a mapping is one."""


def states_of(kind: str, messages: Iterable[tuple[Any, int]], file: str) -> list[State]:
    """What messages of one kind say, each given with the time of its record [ns]; of trajectories there may be one."""
    messages = [*messages] if kind == TRAJECTORY else messages
    if isinstance(messages, list) and len(messages) > 1:
        what = f"has {len(messages)} trajectories of joints, each with a time of its own"
        raise TrajectoryError(what, remedy="write each to a file of its own", file=file)
    states: list[State] = []
    for number, (message, recorded) in enumerate(messages, 1):
        try:
            states += KINDS[kind][0](message, recorded)
        except ValueError as error:
            raise TrajectoryError(f"message {number}: {error}", remedy=f"is it a {kind}?", file=file) from None
    return states


def read_messages(name: str) -> list[State]:
    """What a file of messages of one kind says: a trajectory, or states one after another."""
    as_json = name.lower().endswith(".json")
    if not as_json:
        need("YAML files", "pyyaml", file=name)
    text = read_input(name)
    with decoding("JSON", name):
        documents = [parse_json(text, name)] if as_json else yaml_documents(text, name)
    found: list[tuple[str, Any]] = []
    waiting = [*reversed(documents)]
    while waiting:  # messages may be anywhere in documents
        value = waiting.pop()
        there = value.keys() if isinstance(value, Mapping) else set()
        if kind := next((kind for kind, (_, keys) in KINDS.items() if keys <= there), None):
            found.append((kind, value))
        elif isinstance(value, (Mapping, list)):
            waiting += reversed([*(value.values() if isinstance(value, Mapping) else value)])
    kinds = sorted({kind for kind, _ in found})
    if len(kinds) != 1:
        what = f"has messages of several kinds: {', '.join(kinds)}" if kinds else "has no messages about joints"
        remedy = f"understood: {', '.join(KINDS)}, by keys such as joint_names and points"
        raise TrajectoryError(what, remedy=remedy, file=name)
    return states_of(kinds[0], ((message, 0) for _, message in found), name)


def yaml_documents(text: bytes, file: str) -> list[Any]:
    """The documents of YAML as mappings, lists, numbers, texts and None, within limits: no aliases, no tags, and plain
    scalars are null, decimal numbers, or text: no dates, no 12:30:45, no yes and no."""
    import yaml

    documents: list[Any] = []
    containers: list[tuple[str, list[Any]]] = [("", documents)]
    try:
        for number, event in enumerate(yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)), 1):
            kind, at = type(event).__name__, {"file": file, "line": event.start_mark.line + 1}
            if number > limits().message_values:
                raise beyond("message_values", "too many values", TrajectoryError, **at)
            if kind == "AliasEvent":
                what = f"*{event.anchor} stands for another part"
                raise TrajectoryError(what, remedy="write the values themselves", **at)
            if kind == "ScalarEvent":
                containers[-1][1].append(_scalar(event.value) if event.implicit[0] else event.value)
            elif kind in ("SequenceStartEvent", "MappingStartEvent"):
                if len(containers) > limits().nesting:
                    raise beyond("nesting", "nested too deeply", TrajectoryError, **at)
                containers.append((kind, []))
            elif kind in ("SequenceEndEvent", "MappingEndEvent"):
                began, values = containers.pop()
                if began == "MappingStartEvent" and any(isinstance(key, (list, dict)) for key in values[::2]):
                    raise TrajectoryError("a key is no text", remedy="write it again", **at)
                mapping = began == "MappingStartEvent"
                containers[-1][1].append(dict(zip(values[::2], values[1::2], strict=True)) if mapping else values)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        what = " ".join(str(getattr(error, "problem", None) or error).split())
        line = None if mark is None else mark.line + 1
        raise TrajectoryError(f"is not YAML: {what:.200}", remedy="write it again", file=file, line=line) from None
    return documents


def _scalar(text: str) -> Any:
    if text in ("", "~", "null", "Null", "NULL"):
        return None
    if _WHOLE.fullmatch(text):
        return int(text)
    if _NUMBER.fullmatch(text):
        return float(text)
    further = _FURTHER.fullmatch(text)
    return text if further is None else float(further[1] + further[2])


class LogTable(ArrayTable):
    """A table of messages: what it has beyond the robot is left out. Rows are the messages of the publisher that has
    most: those about one set of joints, and of such with the same stamp the first. Joints that only others tell of are
    interpolated onto its stamps, linearly."""

    leaves_out = True

    def __init__(self, file: str, states: Sequence[State]) -> None:
        if not states:
            raise TrajectoryError("has no messages", remedy="is the log complete?", file=file)
        by_joints: dict[frozenset[str], list[State]] = {}
        for state in states:
            by_joints.setdefault(frozenset(state.names), []).append(state)
        first, *others = sorted(by_joints.values(), key=lambda some: (-len(some), -len(set(some[0].names))))
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
        """Leave out rows that are not between messages about joints of these columns; raises if none is."""
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
    """Our names -> those of a log that are `there`, with other quantities of joints whose positions are among them."""
    found = dict(columns)
    for ours, theirs in columns.items():
        if ours.startswith("q_") and theirs.startswith("q_"):
            for letter in QUANTITIES.values():
                if f"{letter}{theirs[1:]}" in there:
                    found.setdefault(f"{letter}{ours[1:]}", f"{letter}{theirs[1:]}")
    return found


def _once(states: Sequence[State], notes: list[str]) -> list[State]:
    """Messages without those that have the stamp of the one before."""
    new = [states[0], *(b for a, b in pairwise(states) if b.stamp != a.stamp)]
    if len(new) < len(states):
        notes.append(f"{count(len(states) - len(new), 'message')} with the stamp of the one before left out")
    return new


def _stamps(states: Sequence[State]) -> NDArray[np.int64]:
    return np.array([state.stamp for state in states], dtype=np.int64)


def _columns(states: Sequence[State], names: Sequence[str], notes: list[str]) -> dict[str, Floats]:
    """The columns of joints, of quantities that all messages have; notes what some lack, or have as NaN only."""
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
    values = state.values[quantity]
    if state.names == names:
        return values
    place = {name: i for i, name in enumerate(state.names)}
    return [values[place[name]] for name in names]


def _onto(
    stamps: NDArray[np.int64], own: NDArray[np.int64], values: Floats, turns: bool
) -> tuple[Floats, NDArray[np.bool_]]:
    """Values at other stamps (N,) [ns] than their own (k,), and where these stand between two messages without a gap;
    of `turns` that differ by more than pi the nearer counts."""
    before = np.maximum(np.searchsorted(own, stamps, "right") - 1, 0)
    after = np.minimum(np.searchsorted(own, stamps), len(own) - 1)
    span = own[after] - own[before]
    part = (stamps - own[before]) / np.maximum(span, 1)
    if turns:
        part = np.where(np.abs(values[after] - values[before]) > pi, np.rint(part), part)
    found = (1.0 - part) * values[before] + part * values[after]
    typical = np.median(np.diff(own)) if len(own) > 1 else 0.0
    return found, (own[before] <= stamps) & (stamps <= own[after]) & (span <= _GAP * typical)
