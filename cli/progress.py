"""Progress bars on standard error, for long work on a terminal only."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robodyn.support.extras import available

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from robodyn.trajectory.reader import TrajectoryReader

LONG = 20_000_000
"""Bytes of trajectory from which a bar is worth its lines."""
LONG_MESHES = 2_000_000
"""Bytes of meshes from which it is."""
MANY_ROBOTS = 10
"""Descriptions from which it is."""


@contextmanager
def _bar(what: str, total: float, *columns: str, files: str = "", **options: Any) -> Iterator[tuple[Progress, TaskID]]:
    """Yield a bar of these columns of `rich.progress`, or texts with braces, and its task; options: of `Progress`."""
    from rich import progress
    from rich.console import Console

    shown = [progress.TextColumn(name) if "{" in name else getattr(progress, name)() for name in columns]
    ends = progress.TextColumn(what), progress.BarColumn(), *shown, progress.TimeRemainingColumn()
    with progress.Progress(*ends, console=Console(stderr=True), transient=True, **options) as bar:
        yield bar, bar.add_task(what, total=total, files=files)


@contextmanager
def watched(reader: TrajectoryReader) -> Iterator[Callable[..., None]]:
    """Yield a function to call after each block of the reader; it moves the bar if there is one."""
    if reader.size_bytes < LONG or not terminal():
        yield lambda *_: None
        return
    with _bar("reading", reader.size_bytes, "DownloadColumn") as (bar, task):
        yield lambda *_: bar.update(task, completed=reader.position_bytes)


@contextmanager
def _counting(shown: bool, what: str, total: int, *columns: str, **options: Any) -> Iterator[Callable[[], None]]:
    """Yield a function to call after each of so many things; it moves the bar if there is one."""
    if not shown:
        yield lambda: None
        return
    with _bar(what, total, "MofNCompleteColumn", *columns, **options) as (bar, task):
        yield lambda: bar.update(task, advance=1, refresh=bool(options))


def counted(files: Sequence[Path]) -> AbstractContextManager[Callable[[], None]]:
    """Return a context that yields a function to call after each of some files."""
    return _counting(worth_a_bar(map(bytes_of, files)), "measuring", len(files), "TaskProgressColumn")


def robots_done(count: int, what: str = "checking") -> AbstractContextManager[Callable[[], None]]:
    """Return a context that yields a function to call after each of some descriptions.

    The bar has no thread of its own, so that processes can be started while it is shown.
    """
    return _counting(count >= MANY_ROBOTS and terminal(), what, count, auto_refresh=False)


def terminal() -> bool:
    """Return whether there is a terminal to show a bar on, and what draws one."""
    return sys.stderr.isatty() and available("rich")


def worth_a_bar(sizes: Iterable[int]) -> bool:
    """Return whether meshes of so many bytes take long enough, and there is a terminal to show a bar on."""
    return sum(sizes) >= LONG_MESHES and terminal()


def bytes_of(path: Path) -> int:
    """Return the size of a file; 0 if it cannot be told."""
    try:
        return path.stat().st_size
    except (OSError, ValueError):
        return 0


@contextmanager
def files_done(paths: Sequence[str]) -> Iterator[Callable[[int], None]]:
    """Yield a function to call with the number of each file that is done; it moves the bar, on a terminal.

    The bar has no thread of its own; what is printed on a terminal meanwhile stands above it.
    """
    if len(paths) < 2 or not terminal():
        yield lambda number: None
        return
    sizes = [os.path.getsize(path) + 1 if os.path.isfile(path) else 1 for path in paths]
    shown = sys.stdout is not None and sys.stdout.isatty()
    first, done, columns = f"0 of {len(paths)}", count(1), ("{task.fields[files]} files",)
    with _bar("computing", sum(sizes), *columns, files=first, auto_refresh=False, redirect_stdout=shown) as (bar, task):
        bar.refresh()
        yield lambda number: bar.update(
            task, advance=sizes[number], files=f"{next(done)} of {len(paths)}", refresh=True
        )
