"""Progress bars on standard error, for long work on a terminal only."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn

    from robodyn.trajectory.reader import TrajectoryReader

LONG = 20_000_000
"""Bytes of trajectory from which a bar is worth its lines."""
LONG_MESHES = 2_000_000
"""Bytes of meshes from which it is."""
MANY_ROBOTS = 10
"""Descriptions from which it is."""


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


@contextmanager
def counted(files: Sequence[Path]) -> Iterator[Callable[[], None]]:
    """A function to call after each of some files; it moves the bar if there is one."""
    if not worth_a_bar(map(bytes_of, files)):
        yield lambda: None
        return
    from rich.progress import MofNCompleteColumn

    with bar_of_meshes(MofNCompleteColumn()) as bar:
        task = bar.add_task("measuring", total=len(files))
        yield lambda: bar.advance(task)


@contextmanager
def robots_done(count: int, what: str = "checking") -> Iterator[Callable[[], None]]:
    """A function to call after each of some descriptions; it moves the bar, if there is one, and the time left.

    The bar has no thread of its own, so that processes can be started while it is shown.
    """
    if count < MANY_ROBOTS or not sys.stderr.isatty():
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True, auto_refresh=False) as bar:
        task = bar.add_task(what, total=count)
        yield lambda: bar.update(task, advance=1, refresh=True)


def bar_of_meshes(*columns: ProgressColumn) -> Progress:
    """A bar with a percentage and the time left."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    shown = (TextColumn("measuring"), BarColumn(), *columns, TaskProgressColumn(), TimeRemainingColumn())
    return Progress(*shown, console=Console(stderr=True), transient=True)


def worth_a_bar(sizes: Iterable[int]) -> bool:
    """Whether meshes of so many bytes take long enough, and there is a terminal to show a bar on."""
    return sum(sizes) >= LONG_MESHES and sys.stderr.isatty()


def bytes_of(path: Path) -> int:
    """The size of a file; 0 if it cannot be told."""
    try:
        return path.stat().st_size
    except (OSError, ValueError):
        return 0
