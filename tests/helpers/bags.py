"""Bags of ROS 1 and ROS 2 written for tests, and messages as mappings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

NANO = 1_000_000_000
ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
ROS2.register(
    get_types_from_msg("string[] interface_names\nfloat64[] values\n", "control_msgs/msg/InterfaceValue")
    | get_types_from_msg(
        "std_msgs/Header header\nstring[] joint_names\ncontrol_msgs/InterfaceValue[] interface_values\n",
        "control_msgs/msg/DynamicJointState",
    )
)


def _header(store: Any, stamp: int) -> Any:
    time = store.types["builtin_interfaces/msg/Time"](sec=stamp // NANO, nanosec=stamp % NANO)
    more = {"seq": 0} if store is ROS1 else {}
    return store.types["std_msgs/msg/Header"](stamp=time, frame_id="", **more)


def _array(values: Sequence[float]) -> Any:
    return np.array(values, dtype=float)


def joint_state(store: Any, stamp: int, names: Sequence[str], values: Mapping[str, Sequence[float]]) -> Any:
    parts = {name: _array(values.get(name, ())) for name in ("position", "velocity", "effort")}
    return store.types["sensor_msgs/msg/JointState"](header=_header(store, stamp), name=list(names), **parts)


def dynamic_joint_state(stamp: int, values: Mapping[str, Mapping[str, float]]) -> Any:
    each = [
        ROS2.types["control_msgs/msg/InterfaceValue"](interface_names=list(found), values=_array([*found.values()]))
        for found in values.values()
    ]
    kind = ROS2.types["control_msgs/msg/DynamicJointState"]
    return kind(header=_header(ROS2, stamp), joint_names=list(values), interface_values=each)


def write_bag(path: Path, topics: Mapping[str, Sequence[tuple[int, Any]]], kind: str = "sqlite3") -> Path:
    """Write messages by topic, each with the time of its record [ns]; return what is read: a file or a folder."""
    if kind == "ros1":
        with Writer1(path) as bag:
            for topic, messages in topics.items():
                name = messages[0][1].__msgtype__
                connection = bag.add_connection(topic, name, typestore=ROS1)
                for stamp, message in messages:
                    bag.write(connection, stamp, ROS1.serialize_ros1(message, name))
        return path
    with Writer2(path, version=8, storage_plugin=StoragePlugin[kind.upper()]) as bag2:
        for topic, messages in topics.items():
            name = messages[0][1].__msgtype__
            connection2 = bag2.add_connection(topic, name, typestore=ROS2)
            for stamp, message in messages:
                bag2.write(connection2, stamp, ROS2.serialize_cdr(message, name))
    return path
