"""Bags of ROS 1 and ROS 2 as tables of a motion."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from robodyn.errors import TrajectoryError
from robodyn.support.extras import need
from robodyn.support.wording import alternatives, count, shown
from robodyn.trajectory.columns.header import listing
from robodyn.trajectory.readers.bounded_bags import bounded, check_bag
from robodyn.trajectory.readers.log_table import LogTable
from robodyn.trajectory.readers.messages import KNOWN, states_of
from robodyn.trajectory.readers.table import BAGS, METADATA, decoding

_DYNAMIC = """std_msgs/Header header
string[] joint_names
control_msgs/InterfaceValue[] interface_values
"""
_INTERFACE = """string[] interface_names
float64[] values
"""


def bag_table(name: str, topic: str | None = None) -> LogTable:
    """Return the motion in a bag.

    Args:
        name: of a `.db3`, `.mcap` or `.bag` file, or of the folder of a bag of ROS 2; without its `metadata.yaml` it
            must have a single file of a bag.
        topic: whose messages; None: the only one of a type that is known.

    Raises:
        TrajectoryError: the bag cannot be read; no topic, or several, could be meant; see `states_of`.
    """
    need("ROS bags", "rosbags", file=name)
    from rosbags.highlevel import AnyReader

    if not os.path.exists(name):
        raise TrajectoryError("cannot be read: no such file or directory", remedy="check the name", file=name)
    place = _place(name)
    check_bag(place)
    with decoding("a bag", name), bounded(place), AnyReader([place], default_typestore=_types()) as bag:
        chosen = _chosen(bag.connections, topic, name)
        kind = _kind(chosen[0])
        return LogTable(name, states_of(kind, _messages(bag, chosen), name))


def _place(name: str) -> Path:
    """Return the file or folder that is read: of a folder without metadata the only bag in it.

    Raises:
        TrajectoryError: there is none, or several.
    """
    path = Path(name)
    if not path.is_dir() or (path / METADATA).is_file():
        return path
    bags = sorted(each for each in path.iterdir() if each.suffix.lower() in BAGS)
    if not bags:
        what = f"is a folder without {METADATA}, and no file in it is {', '.join(BAGS)}"
        raise TrajectoryError(what, remedy="name a table or a bag", file=name)
    if len(bags) > 1:
        what = f"is a folder without {METADATA}, with {len(bags)} bags: {listing(each.name for each in bags)}"
        remedy = "name one of them, or let `ros2 bag reindex` write the metadata"
        raise TrajectoryError(what, remedy=remedy, file=name)
    return bags[0]


def _messages(bag: Any, connections: Sequence[Any]) -> Iterator[tuple[Any, int]]:
    for connection, recorded, data in bag.messages(connections=connections):
        yield bag.deserialize(data, connection.msgtype), int(recorded)


def _chosen(connections: Sequence[Any], topic: str | None, file: str) -> list[Any]:
    """Return the connections of the topic that is meant."""
    topics: dict[str, list[Any]] = {}
    for connection in connections:
        if _kind(connection) in KNOWN:
            topics.setdefault(connection.topic, []).append(connection)
    if topic is not None and topic in topics:
        return topics[topic]
    listed = ", ".join(
        f"{name} ({_kind(each[0])}, {count(_messages_in(each), 'message')})" for name, each in topics.items()
    )
    if topic is not None:
        what = f"no topic {shown(topic)} with messages about joints"
        raise TrajectoryError(what, remedy=alternatives(topic, [*topics], "topics"), file=file)
    if len(topics) != 1:
        others = ", ".join(sorted({connection.msgtype for connection in connections})[:8]) or "nothing"
        if not topics:
            what = f"no topic with messages about joints ({', '.join(KNOWN)}); it has {others}"
            raise TrajectoryError(what, remedy="record the topic of joint states", file=file)
        raise TrajectoryError(f"has several topics about joints: {listed}", remedy="--topic NAME says which", file=file)
    return next(iter(topics.values()))


def _kind(connection: Any) -> str:
    return str(connection.msgtype).rpartition("/")[2]


def _messages_in(connections: Sequence[Any]) -> int:
    return sum(int(connection.msgcount) for connection in connections)


def _types() -> Any:
    """Return the types of messages for bags that do not bring them, as those of SQLite."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(_INTERFACE, "control_msgs/msg/InterfaceValue"))
    store.register(get_types_from_msg(_DYNAMIC, "control_msgs/msg/DynamicJointState"))
    return store
