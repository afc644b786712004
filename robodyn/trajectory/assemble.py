"""A block of columns -> time, q, qd, qdd of the robot, checked; blocks with their neighbours."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats
from robodyn.trajectory.columns import Signals
from robodyn.trajectory.layout import ABSENT, Layout
from robodyn.trajectory.motion import Sampling, Trajectory

NORM_TOLERANCE = 1e-3
"""Deviation of a quaternion's norm from 1 above which it is reported."""

ErrorAt = Callable[[int, str, str], TrajectoryError]


@dataclass(frozen=True)
class Assembly:
    """Puts columns into coordinate order. `error_at(row, what, remedy)` makes the errors about rows."""

    signals: Signals
    layout: Layout
    error_at: ErrorAt

    def samples(self, block: Floats, first_row: int, last_time: float) -> Trajectory:
        """The samples in a block whose columns are `layout.needed`; absent columns are 0, or the identity.

        Args:
            block: (k, len(layout.needed)), finite.
            first_row: number of its first row in the table, from 1.
            last_time: time of the row before it.

        Raises:
            TrajectoryError: time does not increase, or a quaternion is zero.
        """
        place = {column: i for i, column in enumerate(self.layout.needed)}
        clock, parts = self.layout.clock, self.layout.parts
        stamps, *nano = (block[:, place[column]] for column in clock.columns)
        time = clock.seconds(stamps, *nano)
        self._check_time(time, first_row, last_time)
        q, qd, qdd = (np.zeros((len(block), len(of)), order="F") for of in self._columns)
        for values, of in zip((q, qd, qdd), self._columns, strict=True):
            for i, column in enumerate(of):
                if column != ABSENT:
                    cells = block[:, place[column]]
                    values[:, i] = cells / parts[column] if column in parts else cells
        for i, position in self.layout.held.items():
            q[:, i] = position
        extra = {name: block[:, place[column]] for name, column in self.layout.extra.items()}
        samples = Trajectory(
            time,
            q,
            qd,
            qdd,
            extra,
            first_row,
            stamps=clock.given(stamps, time),
            origin=float(clock.start),
            held={self.signals.positions[i]: position for i, position in self.layout.held.items()},
            followed=self.layout.followed,
        )
        return self._normalise(samples)

    @property
    def _columns(self) -> tuple[tuple[int, ...], ...]:
        return self.layout.q, self.layout.qd, self.layout.qdd

    def _check_time(self, time: Floats, first_row: int, last_time: float) -> None:
        before = np.concatenate(([last_time], time[:-1]))
        late = time <= before
        if late.any():
            i = int(np.argmax(late))
            relation = "repeats" if time[i] == before[i] else "is before"
            since = " s after the first stamp" if self.layout.clock.origin else ""
            what = f"time {float(time[i])!r}{since} {relation} {float(before[i])!r} of the row before"
            raise self.error_at(first_row + i, what, "time must increase from row to row")

    def _normalise(self, samples: Trajectory) -> Trajectory:
        notes: list[str] = []
        start = 0
        for joint in self.signals.joints:
            if joint.kind != "floating":
                start += 1
                continue
            turn = samples.q[:, start + 3 : start + 7]
            if self.layout.q[start + 3] == ABSENT:
                turn[:, 3] = 1.0
            largest = np.abs(turn).max(axis=1, initial=0.0)
            if not largest.all():
                row = samples.first_row + int(np.argmin(largest))
                raise self.error_at(row, f"the quaternion of {joint.name!r} is zero", "give a unit quaternion x y z w")
            turn /= largest[:, None]
            length = np.sqrt((turn**2).sum(axis=1))
            turn /= length[:, None]
            off = np.abs(length * largest - 1.0)
            if off.max(initial=0.0) > NORM_TOLERANCE:
                i = int(np.argmax(off))
                norm = length[i] * largest[i]
                notes.append(f"{joint.name}: quaternions normalised; row {samples.first_row + i} has norm {norm:.6g}")
            start += 7
        return replace(samples, notes=tuple(notes))


def join(parts: list[Trajectory]) -> Trajectory:
    """Consecutive samples as one trajectory."""
    if len(parts) == 1:
        return parts[0]
    time, q, qd, qdd = (np.concatenate([getattr(part, name) for part in parts]) for name in ("time", "q", "qd", "qdd"))
    extra = {name: np.concatenate([part.extra[name] for part in parts]) for name in parts[0].extra}
    notes = tuple(dict.fromkeys(note for part in parts for note in part.notes))
    stamps = None if parts[0].stamps is None else np.concatenate([part.given_time for part in parts])
    whole = replace(parts[-1], time=time, q=q, qd=qd, qdd=qdd, extra=extra, notes=notes, stamps=stamps)
    return replace(whole, first_row=parts[0].first_row, sampling=_joined(parts))


def _joined(parts: list[Trajectory]) -> Sampling | None:
    """Return how far all parts can be trusted, None if that is not known of one."""
    known = [part.sampling for part in parts if part.sampling is not None]
    if len(known) < len(parts):
        return None
    off, noise = (np.concatenate([getattr(each, name) for each in known]) for name in ("off", "noise"))
    off_squares = np.sum([each.off_squares for each in known], axis=0)
    squares = np.sum([each.squares for each in known], axis=0)
    return Sampling(off, noise, off_squares, squares, any(each.guessed for each in known))


def cut(samples: Trajectory, start: int, stop: int) -> Trajectory:
    """Samples start to stop."""
    rows = slice(start, stop)
    return replace(
        samples,
        time=samples.time[rows],
        q=samples.q[rows],
        qd=samples.qd[rows],
        qdd=samples.qdd[rows],
        extra={name: values[rows] for name, values in samples.extra.items()},
        first_row=samples.first_row + start,
        stamps=None if samples.stamps is None else samples.stamps[rows],
        sampling=None,
    )


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
