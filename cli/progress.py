"""Progress bars on standard error, for long work on a terminal only."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robodyn.support.extras import available

if TYPE_CHECKING:
    from robodyn.trajectory.read import TrajectoryReader

LONG, LONG_MESHES, MANY_ROBOTS = 20_000_000, 2_000_000, 10
"""Bytes of a trajectory and of meshes, and descriptions, from which a bar is worth its lines."""


@contextmanager
def _bar(shown: bool, what: str, total: float, *columns: str, files: str = "", **options: Any) -> Iterator[Any]:
    """Yield a function that moves a bar by the keywords of `Progress.update`, or does nothing where none is shown."""
    if not (shown and sys.stderr.isatty() and available("rich")):
        yield lambda **_: None
        return
    from rich import progress
    from rich.console import Console

    middle = [progress.TextColumn(name) if "{" in name else getattr(progress, name)() for name in columns]
    ends = progress.TextColumn(what), progress.BarColumn(), *middle, progress.TimeRemainingColumn()
    with progress.Progress(*ends, console=Console(stderr=True), transient=True, **options) as bar:
        task = bar.add_task(what, total=total, files=files)
        yield lambda **how: bar.update(task, **how)


@contextmanager
def watched(reader: TrajectoryReader) -> Iterator[Callable[..., None]]:
    """Yield a function to call after each block of the reader."""
    with _bar(reader.size_bytes >= LONG, "reading", reader.size_bytes, "DownloadColumn") as move:
        yield lambda *_: move(completed=reader.position_bytes)


@contextmanager
def counted(files: Sequence[Path]) -> Iterator[Callable[[], None]]:
    """Yield a function to call after each of some meshes."""
    long, columns = sum(map(_size, map(str, files))) >= LONG_MESHES, ("MofNCompleteColumn", "TaskProgressColumn")
    with _bar(long, "measuring", len(files), *columns) as move:
        yield lambda: move(advance=1)


@contextmanager
def robots_done(count: int, what: str = "checking") -> Iterator[Callable[[], None]]:
    """Yield a function to call after each of some descriptions; without a thread, so that processes can be started."""
    with _bar(count >= MANY_ROBOTS, what, count, "MofNCompleteColumn", auto_refresh=False) as move:
        yield lambda: move(advance=1, refresh=True)


@contextmanager
def files_done(paths: Sequence[str]) -> Iterator[Callable[[int], None]]:
    """Yield a function to call with the number of each file that is done; what is printed meanwhile stands above."""
    sizes = [_size(path) + 1 for path in paths]
    above = sys.stdout is not None and sys.stdout.isatty()
    first, done, columns = f"0 of {len(paths)}", count(1), ("{task.fields[files]} files",)
    how: dict[str, Any] = {"files": first, "auto_refresh": False, "redirect_stdout": above}
    with _bar(len(paths) > 1, "computing", sum(sizes), *columns, **how) as move:
        move(refresh=True)
        yield lambda number: move(advance=sizes[number], files=f"{next(done)} of {len(paths)}", refresh=True)


def _size(path: str) -> int:
    try:
        return os.path.getsize(path)
    except (OSError, ValueError):
        return 0
