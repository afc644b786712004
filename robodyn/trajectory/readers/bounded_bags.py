"""Bags of ROS read within limits: rosbags itself unpacks whatever a chunk holds, and asks of a database what it may."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from robodyn.errors import TrajectoryError
from robodyn.support.input_file import read_input, vetted
from robodyn.support.input_limits import beyond, limits
from robodyn.trajectory.readers.table import METADATA
from robodyn.trajectory.readers.yaml_values import yaml_documents

_LEAST = 1 << 28
"""Bytes that may always come out of a bag."""
_STEPS = 10_000


def check_bag(path: Path) -> None:
    """Raise unless all files of a bag are regular ones, and its metadata is plain YAML of moderate size.

    Raises:
        OSError: one is a pipe, a device, or cannot be read.
        InputError: the metadata is beyond a limit.
    """
    files = [path]
    if path.is_dir():
        files = [each for each in path.iterdir() if not each.is_dir()]
        text = read_input(path / METADATA, limits().yaml_metadata_bytes + 1)
        if len(text) > limits().yaml_metadata_bytes:
            raise beyond("yaml_metadata_bytes", "too many bytes", TrajectoryError, file=str(path / METADATA))
        yaml_documents(text, str(path / METADATA))
    for file in files:
        vetted(file)


@contextmanager
def bounded(path: Path) -> Iterator[None]:
    """Let rosbags unpack no more from this bag than the limits allow, and its databases count their steps.

    Raises:
        TrajectoryError: when something is beyond a limit.
    """
    import apsw
    from rosbags.rosbag1 import reader as first
    from rosbags.rosbag2 import reader, storage_mcap, storage_sqlite3

    files = path.iterdir() if path.is_dir() else [path]
    zstd: Any = vars(reader)["zstd"]
    unpacked = _Unpacked(str(path), sum(each.stat().st_size for each in files if each.is_file()), zstd)
    mcap = {name: unpacked.chunk(unpack) for name, unpack in _UNPACK.items() if name != "bz2"}
    ros1 = {name or "none": unpacked.chunk(unpack) for name, unpack in _UNPACK.items() if name != "zstd"}
    with ExitStack() as stack:
        for known, ours in ((storage_mcap.DECOMPRESSORS, mcap), (first.decompressors, ros1)):
            _changed(stack, known, ours)
        _changed(stack, vars(reader), {"zstd": unpacked})
        for module in (reader, storage_mcap, storage_sqlite3):
            _changed(stack, vars(module), {"parse_qos": _no_qos})
        hook = _Steps(str(path)).bound
        apsw.connection_hooks.append(hook)
        stack.callback(apsw.connection_hooks.remove, hook)
        yield


def _changed(stack: ExitStack, names: dict[str, Any], ours: Mapping[str, Any]) -> None:
    """Give names another meaning until the stack ends; they must be there."""
    stack.callback(names.update, {name: names[name] for name in ours})
    names.update(ours)


def _no_qos(_: object) -> list[Any]:
    """What a bag says of the quality of service is YAML again, and nothing here needs it."""
    return []


class _Unpacked:
    """What has come out of one bag so far; in rosbags it stands for the module that unpacks messages and files."""

    def __init__(self, file: str, stored: int, zstd: Any) -> None:
        self._file, self._zstd = file, zstd
        self._left = max(_LEAST, stored * limits().bag_expansion)
        self._records = 0

    def chunk(self, unpack: Callable[[Any, bytes, int], bytes]) -> Callable[..., bytes]:
        """Return a function that unpacks a chunk, which may be told its size."""

        def unpacked(data: bytes, size: int | None = None) -> bytes:
            most = limits().bag_chunk_bytes
            found = unpack(self._zstd, data, most if size is None else min(size, most))
            self._count(found)
            if size is not None:
                self._count_records(found)
            return found

        return unpacked

    def decompress(self, data: bytes) -> bytes:
        """Unpack one message."""
        found = _zstd(self._zstd, data, limits().bag_chunk_bytes)
        self._count(found)
        return found

    @contextmanager
    def open(self, stream: BinaryIO, _: str) -> Iterator[_Unpacked]:
        """Unpack a file: what is yielded has `read`."""
        with self._zstd.open(stream, "rb") as inner:
            self._inner = inner
            yield self

    def read(self, size: int) -> bytes:
        """Return some bytes of a file."""
        found: bytes = self._inner.read(size)
        self._count(found)
        return found

    def _count(self, found: bytes) -> None:
        most = limits().bag_chunk_bytes
        if len(found) > most:
            raise beyond("bag_chunk_bytes", "too many bytes in a chunk or message", TrajectoryError, file=self._file)
        self._left -= len(found)
        if self._left < 0:
            what = "too many times its own bytes come out of its chunks"
            raise beyond("bag_expansion", what, TrajectoryError, file=self._file)

    def _count_records(self, data: bytes) -> None:
        place, most = 0, limits().bag_records
        try:
            while place < len(data):
                place += 9 + struct.unpack_from("<Q", data, place + 1)[0]
                self._records += 1
                if self._records > most:
                    raise beyond("bag_records", "too many records", TrajectoryError, file=self._file)
        except struct.error:
            return  # the reader tells of it


def _none(_: Any, data: bytes, most: int) -> bytes:
    return data


def _zstd(module: Any, data: bytes, most: int) -> bytes:
    found: bytes = module.ZstdDecompressor().decompress(data, max_length=most + 1)
    return found


def _lz4(_: Any, data: bytes, most: int) -> bytes:
    from lz4.frame import LZ4FrameDecompressor

    found: bytes = LZ4FrameDecompressor().decompress(data, max_length=most + 1)
    return found


def _bz2(_: Any, data: bytes, most: int) -> bytes:
    from bz2 import BZ2Decompressor

    return BZ2Decompressor().decompress(data, max_length=most + 1)


_UNPACK: dict[str, Callable[[Any, bytes, int], bytes]] = {"": _none, "zstd": _zstd, "lz4": _lz4, "bz2": _bz2}


class _Steps:
    """Bounds what a database may do: a table in it may be computed, without end."""

    def __init__(self, file: str) -> None:
        self._file, self._done, self._most = file, 0, limits().bag_steps
        self._each = min(_STEPS, self._most)

    def bound(self, connection: Any) -> None:
        """Set the limits of a connection."""
        import apsw

        connection.limit(apsw.SQLITE_LIMIT_LENGTH, limits().bag_chunk_bytes)
        connection.set_progress_handler(self._progress, self._each)

    def _progress(self) -> bool:
        self._done += self._each
        if self._done >= self._most:
            raise beyond("bag_steps", "too many steps of its database", TrajectoryError, file=self._file)
        return False
