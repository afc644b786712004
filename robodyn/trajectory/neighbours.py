"""Blocks of samples with their neighbours, so that derivatives do not see the limits of blocks."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.trajectory.assemble import cut, join
from robodyn.trajectory.motion import Trajectory


def with_neighbours(parts: Iterator[Trajectory], halo: int) -> Iterator[tuple[Trajectory, int, int]]:
    """Each part with up to `halo` samples before and after it, and where the part begins and ends in that."""
    before: list[Trajectory] = []
    waiting: list[Trajectory] = []

    def emit() -> tuple[Trajectory, int, int]:
        nonlocal before
        part = waiting.pop(0)
        past = join([*before, part])
        start = len(past) - len(part)
        before = [cut(past, max(0, len(past) - halo), len(past))] if halo else []
        if not waiting or not halo:
            return past, start, len(past)
        future = join(waiting)
        return join([past, cut(future, 0, min(halo, len(future)))]), start, len(past)

    for part in parts:
        waiting.append(part)
        while waiting and sum(map(len, waiting[1:])) >= halo:
            yield emit()
    while waiting:
        yield emit()
