"""Small files that ask for gigabytes or hours; and commands run under limits of the system."""

from __future__ import annotations

import json
import os
import sqlite3
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import NamedTuple

import lz4.frame
import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import reader

from helpers.bags import ROS1

CompressionFormat = Writer1.CompressionFormat
zstd = reader.zstd
HUGE = 1 << 29
"""Bytes that a small file expands to, more than refusing one may take."""
_SERVER = """
import json, os, resource, sys
from robodyn.cli import check, info, torques
from robodyn.cli.main import main
from robodyn.loads import torques
import polars
for line in sys.stdin:
    folder, limits, words = json.loads(line)
    child = os.fork()
    if not child:
        resource.setrlimit(resource.RLIMIT_CPU, (60, 60))
        resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
        os.chdir(folder)
        os.environ["ROBODYN_LIMITS"] = limits
        os.dup2(os.open(os.devnull, os.O_RDWR), 0)
        os.dup2(0, 1)
        os.dup2(os.open(".err", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
        sys.argv[1:] = words
        try:
            main()
        except SystemExit as end:
            os._exit(end.code)
    _, status, usage = os.wait4(child, 0)
    print(json.dumps([os.waitstatus_to_exitcode(status), usage.ru_maxrss]), flush=True)
"""
MOST = 500 << 20
"""Bytes of memory that refusing a file may take."""
FEWER = "message_values=100000,bag_records=200000,csv_line_bytes=100000,log_values=3000000"
"""A twentieth or so of what is counted one by one, so that it is not counted for seconds before it is refused."""


class Bounded(NamedTuple):
    """How a command ended; `memory`: the most bytes that it held."""

    status: int
    err: str
    memory: int


Command = Callable[..., Bounded]


@contextmanager
def bounded_commands() -> Iterator[Command]:
    """Run `robodyn args` here, in forks of one process, each with a minute of processor and 3 GB of address space."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "ROBODYN_CACHE": "0"}
    with subprocess.Popen(
        [sys.executable, "-c", _SERVER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
    ) as server:
        assert server.stdin is not None
        assert server.stdout is not None

        def bounded(*words: str, limits: str = "") -> Bounded:
            print(json.dumps([os.getcwd(), limits, words]), file=server.stdin, flush=True)
            status, memory = json.loads(server.stdout.readline())
            return Bounded(status, Path(".err").read_text(), memory << 10)

        yield bounded
        server.stdin.close()


@cache
def _zstd(count: int) -> bytes:
    stream = zstd.ZstdCompressor()
    parts = [stream.compress(bytes(1 << 24)) for _ in range(count >> 24)]
    return b"".join([*parts, stream.flush()])


@cache
def _lz4(count: int) -> bytes:
    with lz4.frame.LZ4FrameCompressor() as stream:
        parts = [stream.begin(), *(stream.compress(bytes(1 << 24)) for _ in range(count >> 24)), stream.flush()]
    return b"".join(parts)


def _record(kind: int, content: bytes) -> bytes:
    return struct.pack("<BQ", kind, len(content)) + content


def _text(content: bytes) -> bytes:
    return struct.pack("<I", len(content)) + content


def mcap(chunks: list[tuple[str, bytes, int]]) -> bytes:
    """Return an MCAP file without an index, of chunks: how each is compressed, its bytes, and how many it says."""
    magic = b"\x89MCAP0\r\n"
    parts = [magic, _record(1, _text(b"ros2") + _text(b""))]
    for how, data, said in chunks:
        head = struct.pack("<QQQI", 0, 1, said, 0) + _text(how.encode()) + struct.pack("<Q", len(data))
        parts.append(_record(6, head + data))
    return b"".join([*parts, _record(2, bytes(20)), magic])


def _bag1(how: CompressionFormat) -> Callable[[Path], None]:
    """Write a bag of ROS 1 with one chunk of 128 MB."""

    def write(path: Path) -> None:
        bag = Writer1(path)
        bag.set_compression(how)
        with bag:
            connection = bag.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=ROS1)
            bag.write(connection, 1_000_000_000, bytes(1 << 27))

    return write


METADATA = """rosbag2_bagfile_information:
  version: 5
  storage_identifier: sqlite3
  relative_file_paths: [x.db3.zstd]
  duration: {nanoseconds: 1}
  starting_time: {nanoseconds_since_epoch: 1}
  message_count: 1
  compression_format: zstd
  compression_mode: FILE
  topics_with_message_count: []
"""


def _folder(path: Path) -> None:
    path.mkdir()
    (path / "metadata.yaml").write_text(METADATA)
    (path / "x.db3.zstd").write_bytes(_zstd(HUGE))


def _metadata(path: Path) -> None:
    path.mkdir()
    (path / "metadata.yaml").write_bytes(ALIASES)


def _database(path: Path) -> None:
    """Write a bag whose messages are computed."""
    column = "data BLOB GENERATED ALWAYS AS (zeroblob(900000000)) VIRTUAL"
    with sqlite3.connect(path) as base:
        base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, "
                     "offered_qos_profiles TEXT)")  # fmt: skip
        base.execute(f"CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, {column})")
        base.execute("INSERT INTO topics VALUES(1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr', '')")
        base.executemany("INSERT INTO messages(topic_id, timestamp) VALUES(1, ?)", [(k,) for k in range(20)])
    base.close()


ALIASES = b"a: &a [x, x, x, x, x, x, x, x, x]\n" + b"".join(
    b"%c: &%c [*%c, *%c, *%c, *%c, *%c, *%c, *%c, *%c, *%c]\n" % (k + 1, k + 1, *[k] * 9) for k in range(97, 106)
)
KEYS = b"a." * 20_000 + b"a = 1\n"


def _members(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        for k in range(11_000):
            with archive.open(f"q_c{k}.npy", "w") as stream:
                np.lib.format.write_array(stream, np.zeros(2))


def _columns() -> str:
    names = ["time", *(f"c{k}" for k in range(20_000))]
    return "\n".join([",".join(names), *[",".join("1" * len(names))] * 3]) + "\n"


def _publishers() -> str:
    """Every second message is about a joint of its own."""
    one = '{"name": ["%s"], "position": [0], "header": {"stamp": {"sec": %d}}}'
    return "[" + ",".join(one % (f"j{k}" if k % 2 else "shoulder", k) for k in range(40_000)) + "]"


HEAD = "time,q_shoulder,q_elbow\n0,1,2\n"
_FILES: dict[str, Callable[[], bytes | str]] = {
    "zstd.mcap": lambda: mcap([("zstd", _zstd(HUGE), HUGE)]),
    "lying.mcap": lambda: mcap([("zstd", _zstd(HUGE), 1000)]),
    "lz4.mcap": lambda: mcap([("lz4", _lz4(HUGE), HUGE)]),
    "many.mcap": lambda: mcap([("zstd", zstd.compress(_record(0x80, bytes(1 << 25))), (1 << 25) + 9)] * 2000),
    "records.mcap": lambda: mcap([("zstd", zstd.compress(_record(0x80, b"") * 6_000_000), 54_000_000)] * 2),
    "aliases.yaml": lambda: ALIASES,
    "documents.yaml": lambda: b"--- {}\n" * 4_000_000,
    "scalar.yaml": lambda: b"name: [a]\nposition: " + b"word " * 6_000_000 + b": x",
    "flow.yaml": lambda: b"[" * 1_000_000,
    "values.yaml": lambda: b"name: [a]\nposition: [" + b"1, " * 4_000_000 + b"1]\n",
    "values.json": lambda: b'{"name": ["a"], "position": [' + b"[]," * 8_000_000 + b"1]}",
    "deep.json": lambda: b'{"a":' * 1_000_000,
    "publishers.json": _publishers,
    "columns.csv": _columns,
    "line.csv": lambda: HEAD + "1," * 4_000_000 + "\n",
    "lines.csv": lambda: "\n" * 20_000_000,
    "digits.csv": lambda: HEAD + "1," + "1" * 8_000_000 + ",2\n2,3,4\n",
    "blanks.csv": lambda: "time q_shoulder q_elbow\n0 1 2\n" + "1 " * 4_000_000 + "\n2 3 4\n",
    "header.csv": lambda: "a," * 4_000_000 + "\n",
    "names.csv": lambda: "time,q_" + "./" * 50_000 + "\n0,1\n",
}
_MADE: dict[str, Callable[[Path], None]] = {
    "bz2.bag": _bag1(CompressionFormat.BZ2),
    "lz4.bag": _bag1(CompressionFormat.LZ4),
    "folder": _folder,
    "metadata": _metadata,
    "blob.db3": _database,
    "members.npz": _members,
}
TABLES = (*_FILES, *_MADE)
"""Names of tables, bags and messages."""


def write_bomb(path: Path) -> None:
    """Write the one of this name."""
    if make := _MADE.get(path.name):
        make(path)
        return
    content = _FILES[path.name]()
    path.write_bytes(content.encode() if isinstance(content, str) else content)


TOML: dict[str, bytes] = {
    "keys": KEYS,
    "header": b"[" + b"a." * 20_000 + b"a]\n",
    "quoted": b'"a".' * 20_000 + b"a = 1\n",
    "inline": b"x = {" + b"a . " * 20_000 + b"a = 1}\n",
    "size": b"# " + b"x" * 2_000_000,
    "arrays": b"x = " + b"[" * 500_000,
}
WAIVERS = '<robot name="r"><link name="a"/>' + "<!-- robodyn: allow RD101: because -->" * 50_000 + "</robot>"
