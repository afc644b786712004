"""Parquet tables, through polars in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any, BinaryIO

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.trajectory.table import FloatArray, check_finite, spread

_MARK = b"PAR1"
READ_ROWS = 1 << 18
"""Rows decoded at once: every request decodes the row groups that it touches from their beginnings."""
_PROGRAM = "import sys; sys.path[:] = {path}; from robodyn.trajectory.parquet_child import serve; serve({file})"


class ParquetTable:
    """A Parquet file of columns of numbers; see `Table`. Integers and float32 become float64."""

    header_line = None

    def __init__(self, path: str) -> None:
        self.file = path
        with open(path, "rb") as stream:
            self.size_bytes = stream.seek(0, os.SEEK_END)
            if self.size_bytes < 12 or not _is_parquet(stream, self.size_bytes):
                raise TrajectoryError("is not a Parquet file, or is cut short", remedy="write it again", file=path)
        program = _PROGRAM.format(path=sys.path, file=repr(path))
        pipe = subprocess.PIPE
        command = [sys.executable, "-c", program]
        self._child = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL)
        try:
            head, _ = self._ask({})
        except BaseException:
            self.close()
            raise
        self.names: tuple[str, ...] = tuple(head["names"])
        self._types: list[str | None] = head["types"]
        self._rows: int = head["rows"]
        self.position_bytes = 0

    def blocks(self, columns: Sequence[int], rows: int) -> Iterator[FloatArray]:
        size = max(rows, READ_ROWS)
        for start in range(0, self._rows, size):
            values = self._read(columns, start, min(size, self._rows - start))
            check_finite(values, [self.names[i] for i in columns], start + 1, self.error_at)
            self.position_bytes = self.size_bytes * (start + len(values)) // self._rows
            yield from (values[part : part + rows] for part in range(0, len(values), rows))

    def pieces(self, columns: Sequence[int], count: int, rows: int) -> list[FloatArray]:
        cuts = spread(self._rows, count, rows)
        return [self._read(columns, cut.start, cut.stop - cut.start) for cut in cuts]

    def _read(self, columns: Sequence[int], start: int, rows: int) -> FloatArray:
        names = [self.names[i] for i in columns]
        for name, kind in ((self.names[i], self._types[i]) for i in columns):
            if kind:
                what = f"column {name!r} holds {kind}, not numbers"
                raise TrajectoryError(what, remedy="store it as float64", file=self.file)
        head, values = self._ask({"names": names, "start": start, "rows": rows})
        if head["rows"] != rows:
            raise TrajectoryError("holds fewer rows than it says", remedy="write it again", file=self.file)
        return np.frombuffer(values).reshape(len(columns), rows).T

    def _ask(self, request: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
        """The child's answer; a child that says no, or dies, has met a damaged file."""
        assert self._child.stdin is not None
        assert self._child.stdout is not None
        try:
            self._child.stdin.write(json.dumps(request).encode() + b"\n")
            self._child.stdin.flush()
            line = self._child.stdout.readline()
        except BrokenPipeError:
            line = b""
        head: dict[str, Any] = json.loads(line) if line.endswith(b"\n") else {"error": "the decoder gave up"}
        if "error" in head:
            what = f"cannot be read as Parquet: {head['error']}"
            raise TrajectoryError(what, remedy="write it again", file=self.file)
        return head, self._child.stdout.read(head["bytes"])

    def error_at(self, row: int, what: str, remedy: str | None = None) -> TrajectoryError:
        return TrajectoryError(f"row {row}: {what}", remedy=remedy, file=self.file)

    def close(self) -> None:
        """End the child."""
        self._child.kill()
        self._child.wait()
        for pipe in (self._child.stdin, self._child.stdout):
            if pipe:
                with suppress(OSError):
                    pipe.close()


def _is_parquet(stream: BinaryIO, size: int) -> bool:
    stream.seek(0)
    first = stream.read(4)
    stream.seek(size - 4)
    return first == stream.read(4) == _MARK
