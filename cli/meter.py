"""How far the measuring of large meshes has come."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from robodyn.cli.progress import bar_of_meshes, bytes_of, worth_a_bar
from robodyn.solids.mesh.one_shell import readings
from robodyn.solids.mesh.stl_binary import RECORD

_MOST, _OVERDUE = 0.99, 1.02
_STEPS = 1000


class Meter:
    """How much of the readings of files that are measured one after the other is done.

    A file counts by its size and by how often a sound binary STL of that size is read. What needs more readings stays
    at the last hundredth of its share, and is overdue, until it is done.
    """

    def __init__(self, sizes: Sequence[int]) -> None:
        """Args: sizes: bytes of each file."""
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
        self._read += triangles * RECORD

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
