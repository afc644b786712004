"""A progress bar on standard error, for long work on a terminal only."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from robodyn.trajectory.reader import TrajectoryReader

LONG = 20_000_000
"""Bytes of trajectory from which a bar is worth its lines."""


@contextmanager
def watched(reader: TrajectoryReader) -> Iterator[Callable[..., None]]:
    """A function to call after each block of the reader; it moves the bar if there is one."""
    if reader.size_bytes < LONG or not sys.stderr.isatty():
        yield lambda *_: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("reading"), BarColumn(), DownloadColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reading", total=reader.size_bytes)

        def tick(*_: Any) -> None:
            bar.update(task, completed=reader.position_bytes)

        yield tick
