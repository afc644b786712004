"""Bags of ROS 1 and ROS 2 as tables of a motion.

They are read within limits: rosbags itself unpacks whatever a chunk holds, and asks of a database what it may.
"""

from __future__ import annotations

import bz2
import os
import struct
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

from robodyn.errors import TrajectoryError
from robodyn.support.extras import need
from robodyn.support.input_file import beyond, limits, read_input, vetted
from robodyn.support.wording import alternatives, count, shown
from robodyn.trajectory.columns.layout import listing
from robodyn.trajectory.formats.messages import KINDS, LogTable, states_of, yaml_documents
from robodyn.trajectory.formats.table import BAGS, METADATA, decoding

_LEAST = 1 << 28  # bytes that may always come out of a bag
_STEPS = 10_000
_DYNAMIC = """std_msgs/Header header
string[] joint_names
control_msgs/InterfaceValue[] interface_values
"""
_INTERFACE = """string[] interface_names
float64[] values
"""


def bag_table(name: str, topic: str | None = None) -> LogTable:
    """The motion in a `.db3`, `.mcap` or `.bag` file or a folder of a bag of ROS 2, by the messages of a topic (None:
    the only one of a known type); raises if it cannot be read, or no topic, or several, could be meant."""
    need("ROS bags", "rosbags", file=name)
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    if not os.path.exists(name):
        raise TrajectoryError("cannot be read: no such file or directory", remedy="check the name", file=name)
    place = Path(name)
    if place.is_dir() and not (place / METADATA).is_file():  # the only bag in it is read
        bags = sorted(each for each in place.iterdir() if each.suffix.lower() in BAGS)
        if not bags:
            what = f"is a folder without {METADATA}, and no file in it is {', '.join(BAGS)}"
            raise TrajectoryError(what, remedy="name a table or a bag", file=name)
        if len(bags) > 1:
            what = f"is a folder without {METADATA}, with {len(bags)} bags: {listing(each.name for each in bags)}"
            remedy = "name one of them, or let `ros2 bag reindex` write the metadata"
            raise TrajectoryError(what, remedy=remedy, file=name)
        place = bags[0]
    files = [place]
    if place.is_dir():  # whose files are all regular ones, and its metadata plain YAML of moderate size
        files, metadata = [each for each in place.iterdir() if not each.is_dir()], str(place / METADATA)
        text = read_input(metadata, limits().yaml_metadata_bytes + 1)
        if len(text) > limits().yaml_metadata_bytes:
            raise beyond("yaml_metadata_bytes", "too many bytes", TrajectoryError, file=metadata)
        yaml_documents(text, metadata)
    for file in files:
        vetted(file)
    store = get_typestore(Stores.ROS2_HUMBLE)  # for bags that do not bring the types of messages, as those of SQLite
    for definition, kind in ((_INTERFACE, "InterfaceValue"), (_DYNAMIC, "DynamicJointState")):
        store.register(get_types_from_msg(definition, f"control_msgs/msg/{kind}"))
    with decoding("a bag", name), _bounded(place), AnyReader([place], default_typestore=store) as bag:
        chosen = _chosen(bag.connections, topic, name)
        messages = (
            (bag.deserialize(data, connection.msgtype), int(recorded))
            for connection, recorded, data in bag.messages(connections=chosen)
        )
        return LogTable(name, states_of(_kind(chosen[0]), messages, name))


def _chosen(connections: Sequence[Any], topic: str | None, file: str) -> list[Any]:
    topics: dict[str, list[Any]] = {}
    for connection in connections:
        if _kind(connection) in KINDS:
            topics.setdefault(connection.topic, []).append(connection)
    if topic is not None and topic in topics:
        return topics[topic]
    sizes = {name: sum(int(each.msgcount) for each in some) for name, some in topics.items()}
    listed = ", ".join(f"{x} ({_kind(topics[x][0])}, {count(size, 'message')})" for x, size in sizes.items())
    if topic is not None:
        what = f"no topic {shown(topic)} with messages about joints"
        raise TrajectoryError(what, remedy=alternatives(topic, [*topics], "topics"), file=file)
    if len(topics) != 1:
        others = ", ".join(sorted({connection.msgtype for connection in connections})[:8]) or "nothing"
        if not topics:
            what = f"no topic with messages about joints ({', '.join(KINDS)}); it has {others}"
            raise TrajectoryError(what, remedy="record the topic of joint states", file=file)
        raise TrajectoryError(f"has several topics about joints: {listed}", remedy="--topic NAME says which", file=file)
    return next(iter(topics.values()))


def _kind(connection: Any) -> str:
    return str(connection.msgtype).rpartition("/")[2]


@contextmanager
def _bounded(path: Path) -> Iterator[None]:
    """Let rosbags unpack no more from this bag than the limits allow, and its databases count their steps."""
    import apsw
    from rosbags.rosbag1 import reader as first
    from rosbags.rosbag2 import reader, storage_mcap, storage_sqlite3

    files = path.iterdir() if path.is_dir() else [path]
    zstd: Any = vars(reader)["zstd"]
    budget = _Budget(str(path), sum(each.stat().st_size for each in files if each.is_file()), zstd)
    mcap = {kind: partial(budget.chunk, kind) for kind in ("", "zstd", "lz4")}
    ros1 = {kind or "none": partial(budget.chunk, kind) for kind in ("", "lz4", "bz2")}
    # what a bag says of the quality of service is YAML again, and nothing here needs it
    no_qos: dict[str, Any] = {"parse_qos": lambda _: []}
    replaced: list[tuple[dict[str, Any], Mapping[str, Any]]] = [
        (storage_mcap.DECOMPRESSORS, mcap),
        (first.decompressors, ros1),
        (vars(reader), {"zstd": budget, **no_qos}),
        (vars(storage_mcap), no_qos),
        (vars(storage_sqlite3), no_qos),
    ]
    with ExitStack() as stack:
        for names, ours in replaced:
            stack.callback(names.update, {name: names[name] for name in ours})
            names.update(ours)
        apsw.connection_hooks.append(budget.bound)
        stack.callback(apsw.connection_hooks.remove, budget.bound)
        yield


class _Budget:
    """What may come out of one bag; in rosbags it stands for the module that unpacks messages and files."""

    def __init__(self, file: str, stored: int, zstd: Any) -> None:
        self._file, self._zstd = file, zstd
        self._left = max(_LEAST, stored * limits().bag_expansion)
        self._records = self._steps = 0
        self._each = min(_STEPS, limits().bag_steps)

    def chunk(self, kind: str, data: bytes, size: int | None = None) -> bytes:
        """Unpack a chunk, whose size may be told."""
        most = limits().bag_chunk_bytes if size is None else min(size, limits().bag_chunk_bytes)
        if kind == "zstd":
            found: bytes = self._zstd.ZstdDecompressor().decompress(data, max_length=most + 1)
        elif kind == "lz4":
            from lz4.frame import LZ4FrameDecompressor

            found = LZ4FrameDecompressor().decompress(data, max_length=most + 1)
        else:
            found = bz2.BZ2Decompressor().decompress(data, max_length=most + 1) if kind else data
        self._count(found)
        if size is not None:
            self._count_records(found)
        return found

    def decompress(self, data: bytes) -> bytes:
        return self.chunk("zstd", data)

    @contextmanager
    def open(self, stream: BinaryIO, _: str) -> Iterator[_Budget]:
        """Unpack a file: what is yielded has `read`."""
        with self._zstd.open(stream, "rb") as inner:
            self._inner = inner
            yield self

    def read(self, size: int) -> bytes:
        found: bytes = self._inner.read(size)
        self._count(found)
        return found

    def bound(self, connection: Any) -> None:
        """Set the limits of a database: a table in it may be computed, without end."""
        import apsw

        connection.limit(apsw.SQLITE_LIMIT_LENGTH, limits().bag_chunk_bytes)
        connection.set_progress_handler(self._count_steps, self._each)

    def _count_steps(self) -> bool:
        self._steps += self._each
        if self._steps >= limits().bag_steps:
            raise beyond("bag_steps", "too many steps of its database", TrajectoryError, file=self._file)
        return False

    def _count(self, found: bytes) -> None:
        if len(found) > limits().bag_chunk_bytes:
            raise beyond("bag_chunk_bytes", "too many bytes in a chunk or message", TrajectoryError, file=self._file)
        self._left -= len(found)
        if self._left < 0:
            what = "too many times its own bytes come out of its chunks"
            raise beyond("bag_expansion", what, TrajectoryError, file=self._file)

    def _count_records(self, data: bytes) -> None:
        place = 0
        try:
            while place < len(data):
                place += 9 + struct.unpack_from("<Q", data, place + 1)[0]
                self._records += 1
                if self._records > limits().bag_records:
                    raise beyond("bag_records", "too many records", TrajectoryError, file=self._file)
        except struct.error:
            return  # the reader tells of it
