"""Progress bars on standard error, for long work on a terminal only."""

from __future__ import annotations

import os
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
    """Yield a function to call after each block of the reader; it moves the bar if there is one."""
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
    """Yield a function to call after each of some files; it moves the bar if there is one."""
    if not worth_a_bar(map(bytes_of, files)):
        yield lambda: None
        return
    from rich.progress import MofNCompleteColumn

    with bar_of_meshes(MofNCompleteColumn()) as bar:
        task = bar.add_task("measuring", total=len(files))
        yield lambda: bar.advance(task)


@contextmanager
def robots_done(count: int, what: str = "checking") -> Iterator[Callable[[], None]]:
    """Yield a function to call after each of some descriptions; it moves the bar, if there is one, and the time left.

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
    """Return a bar with a percentage and the time left."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    shown = (TextColumn("measuring"), BarColumn(), *columns, TaskProgressColumn(), TimeRemainingColumn())
    return Progress(*shown, console=Console(stderr=True), transient=True)


def worth_a_bar(sizes: Iterable[int]) -> bool:
    """Return whether meshes of so many bytes take long enough, and there is a terminal to show a bar on."""
    return sum(sizes) >= LONG_MESHES and sys.stderr.isatty()


def bytes_of(path: Path) -> int:
    """Return the size of a file; 0 if it cannot be told."""
    try:
        return path.stat().st_size
    except (OSError, ValueError):
        return 0


@contextmanager
def files_done(paths: Sequence[str]) -> Iterator[Callable[[int], None]]:
    """A function to call with the number of each file that is done; it moves the bar and the time left, on a terminal.

    The bar has no thread of its own; what is printed on a terminal meanwhile stands above it.
    """
    if len(paths) < 2 or not sys.stderr.isatty():
        yield lambda number: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    sizes = [os.path.getsize(path) + 1 if os.path.isfile(path) else 1 for path in paths]
    columns = (TextColumn("computing"), BarColumn(), TextColumn("{task.fields[files]} files"), TimeRemainingColumn())
    shown = sys.stdout is not None and sys.stdout.isatty()
    how = {"transient": True, "auto_refresh": False, "redirect_stdout": shown}
    with Progress(*columns, console=Console(stderr=True), **how) as bar:  # type: ignore[arg-type]
        done = 0
        task = bar.add_task("computing", total=sum(sizes), files=f"0 of {len(paths)}")
        bar.refresh()

        def tick(number: int) -> None:
            nonlocal done
            done += 1
            bar.update(task, advance=sizes[number], files=f"{done} of {len(paths)}", refresh=True)

        yield tick


_MOST, _OVERDUE = 0.99, 1.02
_STEPS = 1000


class Meter:
    """How much of the readings of files that are measured one after the other is done.

    A file counts by its size and by how often a sound binary STL of that size is read. What needs more readings stays
    at the last hundredth of its share, and is overdue, until it is done.
    """

    def __init__(self, sizes: Sequence[int]) -> None:
        """Args: sizes: bytes of each file."""
        from robodyn.solids.mesh.one_shell import readings
        from robodyn.solids.mesh.stl_binary import RECORD

        self._record = RECORD
        self._shares = [float(size * (1 + readings(size // RECORD))) for size in sizes]
        self.total = sum(self._shares)
        self._before = self._read = 0.0

    @property
    def completed(self) -> float:
        return self._before + min(self._read, _MOST * self._shares[0] if self._shares else 0.0)

    @property
    def overdue(self) -> bool:
        """Whether the present file has been read more often than was foreseen: nobody knows how long it will take."""
        return bool(self._shares) and self._read > _OVERDUE * self._shares[0]

    def heard(self, triangles: int) -> None:
        """So many more triangles of the present file have been read."""
        self._read += triangles * self._record

    def done(self) -> None:
        """The present file is done."""
        self._before, self._read = self._before + self._shares.pop(0), 0.0


@contextmanager
def metered(files: Sequence[str]) -> Iterator[tuple[Callable[[int], None] | None, Callable[[], None]]]:
    """What is to hear how many triangles have been read, if there is a bar, and a function to call after each file."""
    sizes = [bytes_of(Path(name)) for name in files]
    if not worth_a_bar(sizes):
        yield None, lambda: None
        return
    meter, shown = Meter(sizes), (0, False)
    with bar_of_meshes() as bar:
        task = bar.add_task("measuring", total=meter.total)

        def show() -> None:
            nonlocal shown
            now = int(_STEPS * meter.completed / meter.total), meter.overdue
            if now != shown:
                shown = now
                bar.tasks[task].total = None if meter.overdue else meter.total
                bar.update(task, completed=meter.completed)

        def heard(triangles: int) -> None:
            meter.heard(triangles)
            show()

        def done() -> None:
            meter.done()
            show()

        yield heard, done
