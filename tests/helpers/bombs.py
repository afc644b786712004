"""Small files that ask for gigabytes or hours; and commands run under limits of the system."""

from __future__ import annotations

import bz2
import os
import sqlite3
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import lz4.frame
import numpy as np
from rosbags.rosbag2 import reader

zstd = reader.zstd
HUGE = 1 << 31
"""Bytes that a small file expands to."""
_LIMITED = (
    "import os, resource as r, sys; r.setrlimit(r.RLIMIT_CPU, (60, 60)); r.setrlimit(r.RLIMIT_AS, (3 << 30, 3 << 30)); "
    "os.execv(sys.executable, [sys.executable, '-c', 'from robodyn.cli.main import main; main()', *sys.argv[1:]])"
)
_APART = (
    "import os, resource, subprocess, sys; status = subprocess.call([sys.executable, '-c', *sys.argv[1:]]); "
    "print(status, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
)
"""A small process between, for a child counts the memory of the one that starts it as its own until it begins."""
MOST = 500 << 20
"""Bytes of memory that refusing a file may take."""


class Bounded(NamedTuple):
    """How a command ended; `memory`: the most bytes that it held."""

    status: int
    err: str
    memory: int


FEWER = "message_values=100000,bag_records=200000,csv_line_bytes=100000,log_values=3000000"
"""A twentieth or so of what is counted one by one, so that it is not counted for seconds before it is refused."""


def bounded(*args: str, cwd: Path, limits: str = "") -> Bounded:
    """Run `robodyn args` with a minute of processor and 3 GB of address space."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "ROBODYN_CACHE": "0", "ROBODYN_LIMITS": limits}
    call = [sys.executable, "-c", _APART, _LIMITED, *args]
    done = subprocess.run(call, capture_output=True, text=True, cwd=cwd, env=environment, check=False)
    status, memory = map(int, done.stdout.splitlines()[-1].split())
    return Bounded(status, done.stderr, memory << 10)


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


def _mcap_zstd(path: Path) -> None:
    path.write_bytes(mcap([("zstd", _zstd(HUGE), HUGE)]))


def _mcap_lying(path: Path) -> None:
    path.write_bytes(mcap([("zstd", _zstd(HUGE), 1000)]))


def _mcap_lz4(path: Path) -> None:
    path.write_bytes(mcap([("lz4", _lz4(HUGE), HUGE)]))


def _mcap_many(path: Path) -> None:
    data = _record(0x80, bytes(1 << 25))
    path.write_bytes(mcap([("zstd", zstd.compress(data), len(data))] * 2000))


def _mcap_records(path: Path) -> None:
    path.write_bytes(mcap([("zstd", zstd.compress(_record(0x80, b"") * 6_000_000), 54_000_000)] * 2))


def _bag1(how: bytes, data: bytes) -> bytes:
    """Return a bag of ROS 1 with one chunk, whose index names a message in it."""

    def header(**fields: bytes) -> bytes:
        found = b"".join(_text(name.encode() + b"=" + value) for name, value in fields.items())
        return _text(found)

    def u32(value: int) -> bytes:
        return struct.pack("<I", value)

    kind = b"sensor_msgs/JointState"
    words = b"Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"
    words += b"=" * 80 + b"\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
    chunk = header(op=b"\5", compression=how, size=u32(HUGE)) + _text(data)
    index = header(op=b"\4", ver=u32(1), conn=u32(0), count=u32(1)) + _text(struct.pack("<III", 1, 0, 0))
    connection = header(op=b"\7", conn=u32(0), topic=b"/joint_states")
    connection += header(topic=b"/joint_states", type=kind, md5sum=b"3066dcd76a6cfaef579bd0f34173e9fd",
                         message_definition=words)  # fmt: skip
    first = b"#ROSBAG V2.0\n"

    def begin(place: int) -> bytes:
        return (
            first
            + header(op=b"\3", index_pos=struct.pack("<Q", place), conn_count=u32(1), chunk_count=u32(1))
            + _text(b"")
        )

    start = len(begin(0))
    info = header(op=b"\6", ver=u32(1), chunk_pos=struct.pack("<Q", start), count=u32(1),
                  start_time=struct.pack("<II", 1, 0), end_time=struct.pack("<II", 2, 0))  # fmt: skip
    info += _text(struct.pack("<II", 0, 1))
    return begin(start + len(chunk) + len(index)) + chunk + index + connection + info


def _bag_bz2(path: Path) -> None:
    stream = bz2.BZ2Compressor(1)
    parts = [stream.compress(bytes(1 << 24)) for _ in range(8)]
    path.write_bytes(_bag1(b"bz2", b"".join([*parts, stream.flush()])))


def _bag_lz4(path: Path) -> None:
    path.write_bytes(_bag1(b"lz4", _lz4(HUGE)))


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


def _database(path: Path, column: str) -> None:
    """Write a bag whose messages are computed."""
    with sqlite3.connect(path) as base:
        base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, "
                     "offered_qos_profiles TEXT)")  # fmt: skip
        base.execute(f"CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, {column})")
        base.execute("INSERT INTO topics VALUES(1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr', '')")
        base.executemany("INSERT INTO messages(topic_id, timestamp) VALUES(1, ?)", [(k,) for k in range(20)])
    base.close()


def _database_blob(path: Path) -> None:
    _database(path, "data BLOB GENERATED ALWAYS AS (zeroblob(900000000)) VIRTUAL")


ALIASES = b"a: &a [x, x, x, x, x, x, x, x, x]\n" + b"".join(
    b"%c: &%c [*%c, *%c, *%c, *%c, *%c, *%c, *%c, *%c, *%c]\n" % (k + 1, k + 1, *[k] * 9) for k in range(97, 106)
)
KEYS = b"a." * 20_000 + b"a = 1\n"


def _write(content: bytes | str) -> Callable[[Path], None]:
    return lambda path: Path(path).write_bytes(content.encode() if isinstance(content, str) else content) and None


def _columns(path: Path) -> None:
    names = ["time", *(f"c{k}" for k in range(20_000))]
    path.write_text("\n".join([",".join(names), *[",".join("1" * len(names))] * 3]) + "\n")


def _members(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        for k in range(20_000):
            with archive.open(f"q_c{k}.npy", "w") as stream:
                np.lib.format.write_array(stream, np.zeros(2))


def _publishers(path: Path) -> None:
    """Every second message is about a joint of its own."""
    one = '{"name": ["%s"], "position": [0], "header": {"stamp": {"sec": %d}}}'
    path.write_text("[" + ",".join(one % (f"j{k}" if k % 2 else "shoulder", k) for k in range(40_000)) + "]")


HEAD = "time,q_shoulder,q_elbow\n0,1,2\n"
TABLES: dict[str, Callable[[Path], None]] = {
    "zstd.mcap": _mcap_zstd,
    "lying.mcap": _mcap_lying,
    "lz4.mcap": _mcap_lz4,
    "many.mcap": _mcap_many,
    "records.mcap": _mcap_records,
    "bz2.bag": _bag_bz2,
    "lz4.bag": _bag_lz4,
    "folder": _folder,
    "metadata": _metadata,
    "blob.db3": _database_blob,
    "aliases.yaml": _write(ALIASES),
    "documents.yaml": _write(b"--- {}\n" * 4_000_000),
    "scalar.yaml": _write(b"name: [a]\nposition: " + b"word " * 6_000_000 + b": x"),
    "flow.yaml": _write(b"[" * 1_000_000),
    "values.yaml": _write(b"name: [a]\nposition: [" + b"1, " * 4_000_000 + b"1]\n"),
    "values.json": _write(b'{"name": ["a"], "position": [' + b"[]," * 8_000_000 + b"1]}"),
    "deep.json": _write(b'{"a":' * 1_000_000),
    "publishers.json": _publishers,
    "columns.csv": _columns,
    "line.csv": _write(HEAD + "1," * 4_000_000 + "\n"),
    "lines.csv": _write("\n" * 20_000_000),
    "digits.csv": _write(HEAD + "1," + "1" * 8_000_000 + ",2\n2,3,4\n"),
    "blanks.csv": _write("time q_shoulder q_elbow\n0 1 2\n" + "1 " * 4_000_000 + "\n2 3 4\n"),
    "header.csv": _write("a," * 4_000_000 + "\n"),
    "names.csv": _write("time,q_" + "./" * 50_000 + "\n0,1\n"),
    "members.npz": _members,
}
"""Tables, bags and messages, by their names."""
TOML: dict[str, bytes] = {
    "keys": KEYS,
    "header": b"[" + b"a." * 20_000 + b"a]\n",
    "quoted": b'"a".' * 20_000 + b"a = 1\n",
    "inline": b"x = {" + b"a . " * 20_000 + b"a = 1}\n",
    "size": b"# " + b"x" * 2_000_000,
    "arrays": b"x = " + b"[" * 500_000,
}
WAIVERS = '<robot name="r"><link name="a"/>' + "<!-- robodyn: allow RD101: because -->" * 100_000 + "</robot>"
