"""A progress bar for many files, by their sizes."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager


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
