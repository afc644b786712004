"""Messages of ROS as text: JSON, or the YAML that MoveIt and `ros2 topic echo` write."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from robodyn.errors import TrajectoryError
from robodyn.support.extras import need
from robodyn.support.input_file import parse_json, read_input
from robodyn.trajectory.readers.log_table import LogTable
from robodyn.trajectory.readers.messages import KINDS, TRAJECTORY, State, states_of
from robodyn.trajectory.readers.table import decoding
from robodyn.trajectory.readers.yaml_values import yaml_documents

_KEYS = {"JointState": {"name", "position"}, "DynamicJointState": {"joint_names", "interface_values"}}
_KEYS |= {TRAJECTORY: {"joint_names", "points"}}
"""By kind, the keys by which a mapping is one."""


def message_table(name: str) -> LogTable:
    """Return the motion in a file of messages: a trajectory, or states one after another.

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
    states: list[State] = states_of(kinds[0], ((message, 0) for _, message in found), name)
    return LogTable(name, states)


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
