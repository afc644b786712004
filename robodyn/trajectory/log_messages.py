"""What messages of ROS say of joints: JointState, DynamicJointState and JointTrajectory of any version."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from robodyn.errors import TrajectoryError

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
