"""What messages of ROS say of joints: JointState, DynamicJointState and JointTrajectory of any version; their text,
JSON or the YAML that MoveIt and `ros2 topic echo` write."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.support.extras import need
from robodyn.support.input_file import parse_json, read_input
from robodyn.support.wording import shown
from robodyn.trajectory.readers.table import decoding
from robodyn.trajectory.readers.yaml_values import yaml_documents

QUANTITIES = {"position": "q", "velocity": "qd", "acceleration": "qdd", "effort": "tau"}
"""What messages call what columns are called."""
NANO = 1_000_000_000
_LATEST = 1 << 62
"""ns, either way: stamps and their differences are whole numbers of 64 bits."""


class State(NamedTuple):
    """What one message, or one point of a trajectory, says of joints.

    Attributes:
        stamp: ns; names: of joints; values: by quantity, in the order of the names, as far as they are given.
    """

    stamp: int
    names: tuple[str, ...]
    values: Mapping[str, Sequence[float]]


def joint_state(message: Any, recorded: int) -> State:
    """Return what a sensor_msgs/JointState says.

    Args:
        message: an object with these attributes, or a mapping; recorded: ns, when, for messages without a stamp.

    Raises:
        ValueError: something else stands where names or numbers belong.
    """
    stamp = _stamp(_get(_get(message, "header"), "stamp"))
    values = {quantity: _get(message, quantity) for quantity in ("position", "velocity", "effort")}
    return State(stamp or recorded, _names(_get(message, "name"), "name"), _numbers(values))


def dynamic_joint_state(message: Any, recorded: int) -> State:
    """Return what a control_msgs/DynamicJointState says; only interfaces that all of its joints have count.

    Raises:
        ValueError: as `joint_state`.
    """
    names, each = _names(_get(message, "joint_names"), "joint_names"), []
    for values in _parts(_get(message, "interface_values"), "interface_values"):
        interfaces = _names(_get(values, "interface_names"), "interface_names")
        numbers = _numbers({"values": _get(values, "values")}).get("values", ())
        each.append(dict(zip(interfaces, numbers, strict=False)))
    stamp = _stamp(_get(_get(message, "header"), "stamp"))
    common = [quantity for quantity in QUANTITIES if each and all(quantity in values for values in each)]
    return State(stamp or recorded, names, {quantity: [values[quantity] for values in each] for quantity in common})


def joint_trajectory(message: Any) -> list[State]:
    """Return the points of a trajectory_msgs/JointTrajectory, from its own start on.

    Raises:
        ValueError: as `joint_state`.
    """
    names, plural = _names(_get(message, "joint_names"), "joint_names"), {"position": "positions"}
    plural |= {"velocity": "velocities", "acceleration": "accelerations", "effort": "effort"}
    return [
        State(
            _stamp(_get(point, "time_from_start")),
            names,
            _numbers({quantity: _get(point, name) for quantity, name in plural.items()}),
        )
        for point in _parts(_get(message, "points"), "points")
    ]


def _get(message: Any, name: str) -> Any:
    """Return a part of a message, None if it has none."""
    return message.get(name) if isinstance(message, Mapping) else getattr(message, name, None)


def _names(values: Any, what: str) -> tuple[str, ...]:
    names = _parts(values, what)
    wrong = next((name for name in names if isinstance(name, bool) or not isinstance(name, (str, int))), None)
    if wrong is not None or None in names:
        raise ValueError(f"{what} has {shown(str(wrong))}, which is no name")
    return tuple(map(str, names))


def _parts(values: Any, what: str) -> list[Any]:
    if values is None:
        return []
    if not isinstance(values, list):
        raise ValueError(f"{what} is {shown(str(values))}, not a list")
    return values


def _numbers(values: Mapping[str, Any]) -> dict[str, Sequence[float]]:
    """Return the quantities that are given."""
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
    """Return a stamp in ns: seconds as a number, or sec and nanosec, as ROS 1 has them too."""
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
        TrajectoryError: there are several trajectories, or something else stands where names or numbers belong.
    """
    if kind == TRAJECTORY:
        found = [message for message, _ in messages]
        if len(found) > 1:
            what = f"has {len(found)} trajectories of joints, each with a time of its own"
            raise TrajectoryError(what, remedy="write each to a file of its own", file=file)
        messages = ((message, 0) for message in found)
    states: list[State] = []
    for number, (message, recorded) in enumerate(messages, 1):
        try:
            states += joint_trajectory(message) if kind == TRAJECTORY else [KINDS[kind](message, recorded)]
        except ValueError as error:
            raise TrajectoryError(f"message {number}: {error}", remedy=f"is it a {kind}?", file=file) from None
    return states


_KEYS = {"JointState": {"name", "position"}, "DynamicJointState": {"joint_names", "interface_values"}}
_KEYS |= {TRAJECTORY: {"joint_names", "points"}}
"""By kind, the keys by which a mapping is one."""


def read_messages(name: str) -> list[State]:
    """What a file of messages says: a trajectory, or states one after another.

    Raises:
        TrajectoryError: it cannot be read, is beyond a limit, or has no messages about joints, or of several kinds.
    """
    as_json = name.lower().endswith(".json")
    if not as_json:
        need("YAML files", "pyyaml", file=name)
    text = read_input(name)
    with decoding("JSON", name):
        documents = [parse_json(text, name)] if as_json else yaml_documents(text, name)
    found = [each for document in documents for each in _messages(document)]
    kinds = sorted({kind for kind, _ in found})
    if len(kinds) != 1:
        what = f"has messages of several kinds: {', '.join(kinds)}" if kinds else "has no messages about joints"
        remedy = f"understood: {', '.join((*KINDS, TRAJECTORY))}, by keys such as joint_names and points"
        raise TrajectoryError(what, remedy=remedy, file=name)
    return states_of(kinds[0], ((message, 0) for _, message in found), name)


def _messages(document: Any) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the messages in a document, wherever they are, with their kinds, in its order."""
    waiting = [document]
    while waiting:
        value = waiting.pop()
        if isinstance(value, Mapping):
            kind = next((kind for kind, keys in _KEYS.items() if keys <= value.keys()), None)
            if kind is not None:
                yield kind, value
                continue
        inner = value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ()
        waiting += reversed([*inner])
