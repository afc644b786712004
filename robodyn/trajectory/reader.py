"""The reader of a table: block by block, missing derivatives filled in; one sample of it.

The steps of a block: the table gives columns of numbers (`readers/`), the layout says what they are (`columns/`), they
become q, qd and qdd in the robot's order, what is missing is derived and what is given compared with the positions
(`derivatives/`), speeds become 0 where joints stand still, and the units are judged (`plausible.py`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.support.caveats import Caveat
from robodyn.support.floats import Floats
from robodyn.support.wording import count
from robodyn.trajectory.columns.layout import ABSENT, Header, listing, resolve
from robodyn.trajectory.columns.signals import Signals
from robodyn.trajectory.derivatives.groups import anew, given, missing
from robodyn.trajectory.derivatives.standstill import REACH, Standstill
from robodyn.trajectory.motion import FEW, Derivation, Sampling, Trajectory, cut, with_neighbours
from robodyn.trajectory.plausible import Plausibility
from robodyn.trajectory.readers.table import Table, reason
from robodyn.trajectory.reading import DEFAULT, MODES, Reading

if TYPE_CHECKING:
    from robodyn.trajectory.derivatives.derive import Plan
    from robodyn.trajectory.derivatives.given_rates import GivenRates

BLOCK_ROWS = 1 << 15
NORM_TOLERANCE = 1e-3
"""Deviation of a quaternion's norm from 1 above which it is reported."""
_PIECES, _PIECE_ROWS = 16, 4096
_COMPARED = 4, 1024
_FEW, _OFTEN = 3, 0.9
_AT_REST = (
    "one row is no motion: velocities and accelerations that it does not give are 0, as at rest "
    "(robodyn fbd ROBOT --at Q shows the forces on each body)"
)


class TrajectoryReader:
    """Samples of a table, block by block; also a context manager that closes the file.

    Attributes:
        file: as messages name it, None for arrays; size_bytes: its length; columns: the names in the table.
        notes: assumptions made so far; caveats: what makes the units doubtful, by all that has been read.
        missing: joints whose velocities or accelerations are not given; followed: joints that loops tell.
    """

    def __init__(
        self,
        table: Table,
        signals: Signals,
        extra: Sequence[str] = (),
        reading: Reading = DEFAULT,
        block_rows: int = BLOCK_ROWS,
    ) -> None:
        if reading.derivatives not in (*MODES, "none"):
            what = f"unknown way to differentiate {reading.derivatives!r}"
            raise TrajectoryError(what, remedy=f"one of {listing(MODES)}")
        if table.leaves_out:
            from robodyn.trajectory.readers.messages import whole_joints

            reading = replace(reading, ignore_extra=True, columns=whole_joints(reading.columns, table.names))
        self._table, self._signals, self._mode, self._rows = table, signals, reading.derivatives, block_rows
        self._encoder_error, self.columns = reading.encoder_error, table.names
        self.file, self.size_bytes = table.file, table.size_bytes
        header = Header(table.names, table.file, table.header_line)
        if header.labels:
            header = header.labelled(table.texts([*header.labels]))
        layout = resolve(header, signals, extra, reading)
        if reading.derivatives == "anew":
            layout = anew(signals, layout)
        table.choose(layout.needed)
        clock = layout.clock.begun(table.first(layout.clock.columns))
        table.origins = dict(zip(clock.columns, clock.origin, strict=False))  # which it subtracts from now on
        self._layout = layout = replace(layout, clock=clock)
        self._groups, assumptions = missing(signals, layout)
        self.missing = tuple(group.name for group in self._groups)
        self._told = given(signals, layout)
        if reading.derivatives == "none":
            self._groups = self._told = ()
        if reading.derivatives == "given" and self._groups:
            what = f"velocity or acceleration of {listing(self.missing)} is not given"
            raise header.error(what, "--derivatives auto derives what is missing")
        self.notes, self.followed = (*table.notes, *layout.notes, *assumptions), layout.followed
        self.caveats: tuple[Caveat, ...] = ()
        self._plan: Plan | None = None
        self._check: GivenRates | None = None
        self._open: Floats | None = None

    @property
    def position_bytes(self) -> int:
        """How much of the file has been read."""
        return self._table.position_bytes

    @property
    def derivation(self) -> Derivation | None:
        return self._plan.derivation if self._plan else None

    def blocks(self) -> Iterator[Trajectory]:
        """Consecutive samples, at most `block_rows` at a time; each pass starts anew.

        Raises:
            TrajectoryError: a cell, a row or the time is wrong, or there are too few rows to differentiate.

        Accuracy: the limits of blocks change a derivative by at most 3e-11 of the largest.
        """
        try:
            yield from self._blocks()
        except OSError as error:
            raise TrajectoryError(f"cannot be read: {reason(error)}", file=self.file) from None
        except TrajectoryError as error:
            if error.file is not None or self.file is None:
                raise
            raise TrajectoryError(error.what, remedy=error.remedy, file=self.file) from None

    def _blocks(self) -> Iterator[Trajectory]:
        pieces = self._pieces(*(_PIECES, _PIECE_ROWS) if self._groups else _COMPARED)
        if self._groups:
            from robodyn.trajectory.derivatives.derive import plan

            mode = "auto" if self._mode == "anew" else self._mode
            self._plan = plan(self._groups, pieces, mode, self._encoder_error)
            self._remember(self._plan.notes)
        self._check = self._open = None
        if self._told and max(map(len, pieces), default=0) >= FEW:
            from robodyn.trajectory.derivatives.given_rates import against_positions, consistent

            self._open = None if self._groups else consistent(self._told, pieces)
            if self._open is None:
                self._check = against_positions(self._told, pieces, self._plan, self._encoder_error)
        known = self._plan.resolutions if self._plan else {}
        still = Standstill(self._signals, self._layout, pieces, known) if self._mode != "none" else None
        halo = max(max(self._plan.halo, REACH) if self._plan else 0, self._check.halo if self._check else 0)
        needed = 1 + max((group.order for group in self._groups), default=0)  # one more than the highest derivative
        plausible = Plausibility(self._signals, self._layout)
        for samples, start, stop in with_neighbours(self._samples(), halo):
            if len(samples) == 1 < needed:
                self._plan = None
                self._remember([_AT_REST])
            elif len(samples) < needed:
                what = f"has {count(len(samples), 'row')}, too few to differentiate"
                remedy = f"give at least {needed} rows, or velocities and accelerations"
                raise TrajectoryError(what, remedy=remedy, file=self.file)
            block = self._completed(samples, still, slice(start, stop))
            plausible.update(block if self._plan or not self.missing else _with_rough_speeds(block))
            self.caveats = (*plausible.caveats(), *(self._check.caveats if self._check else ()))
            yield replace(block, derivation=self.derivation, notes=self.notes, caveats=self.caveats)

    def _completed(self, samples: Trajectory, still: Standstill | None, rows: slice) -> Trajectory:
        """Some rows with the missing columns, speeds of 0 where joints stand still, and how far they can be trusted."""
        known = None
        if self._plan:
            from robodyn.trajectory.derivatives.derive import derive, sampling

            samples, noise, off = derive(samples, self._plan)
            known = sampling(samples, self._plan, noise, off, rows)
        if self._check:
            known = self._check.trusted(samples, known, rows)
        elif self._open is not None:
            qdd = samples.qdd[rows]
            known = Sampling(self._open + 0.0 * qdd, 0.0 * qdd, 0.0 * self._open, (qdd**2).sum(axis=0))
        elif known and self._told:
            known = replace(known, unknown=True)
        samples = still.stopped(samples) if still else samples
        return replace(cut(samples, rows.start, rows.stop), sampling=known)

    def _samples(self) -> Iterator[Trajectory]:
        row, last_time = 1, -math.inf
        for block in filter(len, self._table.blocks(self._layout.needed, self._rows)):
            samples = self._assembled(block, row, last_time)
            self._remember(samples.notes)
            row, last_time = row + len(block), float(samples.time[-1])
            yield samples
        if row == 1:
            raise TrajectoryError("has no rows", remedy="give rows of numbers", file=self._table.file)

    def _pieces(self, count: int, rows: int) -> list[Trajectory]:
        """Runs of samples that stand for the table; bad rows are left for `blocks` to report."""
        pieces: list[Trajectory] = []
        for block in self._table.pieces(self._layout.needed, count, rows) if self._groups or self._told else ():
            if len(block) and np.isfinite(block).all():
                with suppress(TrajectoryError):
                    pieces.append(self._assembled(block, 1, -math.inf))
        return pieces

    def _remember(self, notes: Sequence[str]) -> None:
        self.notes = tuple(dict.fromkeys((*self.notes, *notes)))

    def _assembled(self, block: Floats, first_row: int, last_time: float) -> Trajectory:
        """The samples in a block (k, len(layout.needed)), finite; absent columns are 0, or the identity. Raises where
        time does not increase from that of the row before it, or a quaternion is zero."""
        layout = self._layout
        clock, place = layout.clock, {column: i for i, column in enumerate(layout.needed)}
        stamps, *nano = (block[:, place[column]] for column in clock.columns)
        time = clock.seconds(stamps, *nano)
        before = np.concatenate(([last_time], time[:-1]))
        if (late := time <= before).any():
            i = int(np.argmax(late))
            relation = "repeats" if time[i] == before[i] else "is before"
            since = " s after the first stamp" if clock.origin else ""
            what = f"time {float(time[i])!r}{since} {relation} {float(before[i])!r} of the row before"
            raise self._table.error_at(first_row + i, what, "time must increase from row to row")
        q, qd, qdd = arrays = [np.zeros((len(block), len(of)), order="F") for of in (layout.q, layout.qd, layout.qdd)]
        for values, of in zip(arrays, (layout.q, layout.qd, layout.qdd), strict=True):
            for i, column in enumerate(of):
                if column != ABSENT:
                    cells = block[:, place[column]]
                    values[:, i] = cells / layout.parts[column] if column in layout.parts else cells
        for i, position in layout.held.items():
            q[:, i] = position
        return Trajectory(
            time,
            q,
            qd,
            qdd,
            extra={name: block[:, place[column]] for name, column in layout.extra.items()},
            first_row=first_row,
            notes=self._normalised(q, first_row),
            stamps=clock.given(stamps, time),
            origin=float(clock.start),
            held={self._signals.positions[i]: position for i, position in layout.held.items()},
            followed=layout.followed,
        )

    def _normalised(self, q: Floats, first_row: int) -> tuple[str, ...]:
        """Give the quaternions in q a norm of 1, and tell where one was off."""
        notes: list[str] = []
        for name, (columns, _) in self._signals.spans.items():
            if len(columns) == 1:
                continue
            turn = q[:, columns[3] : columns[-1] + 1]
            if self._layout.q[columns[3]] == ABSENT:
                turn[:, 3] = 1.0
            largest = np.abs(turn).max(axis=1, initial=0.0)
            if not largest.all():
                row, what = first_row + int(np.argmin(largest)), f"the quaternion of {name!r} is zero"
                raise self._table.error_at(row, what, "give a unit quaternion x y z w")
            turn /= largest[:, None]
            length = np.sqrt((turn**2).sum(axis=1))
            turn /= length[:, None]
            off = np.abs(length * largest - 1.0)
            if off.max(initial=0.0) > NORM_TOLERANCE:
                i = int(np.argmax(off))
                norm = length[i] * largest[i]
                notes.append(f"{name}: quaternions normalised; row {first_row + i} has norm {norm:.6g}")
        return tuple(notes)

    def close(self) -> None:
        self._table.close()

    def __enter__(self) -> TrajectoryReader:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _with_rough_speeds(block: Trajectory) -> Trajectory:
    """A block with high differences of its positions, which no turn of 2 pi is among, for velocities of zero."""
    if len(block) < _FEW or block.q.shape != block.qd.shape:
        return block
    steps = np.quantile(np.abs(np.diff(block.q, axis=0)), _OFTEN, axis=0)
    rough = steps / float(np.median(np.diff(block.time)))
    return replace(block, qd=np.where(block.qd.any(axis=0), block.qd, rough))


def row_at(
    reader: TrajectoryReader, time: float, complete: Callable[[Trajectory], Trajectory] = lambda block: block
) -> Trajectory:
    """The sample nearest to `time` [s], the earlier of two that are as near, of blocks that `complete` fills in.

    Raises:
        TrajectoryError: the time is before the first row or after the last, or the table is wrong.
    """
    first, best, last = math.nan, None, math.nan
    for block in map(complete, reader.blocks()):
        k = int(np.argmin(np.abs(block.time - time)))
        first = float(block.time[0]) if best is None else first
        last = float(block.time[-1])
        if best is None or abs(block.time[k] - time) < abs(best.time[0] - time):
            best = cut(block, k, k + 1)
        if first <= time <= last:
            break
    if best is None or not first <= time <= last:
        what = f"time {time:.6g} s is outside the motion"
        raise TrajectoryError(what, remedy=f"it lasts from {first:.6g} s to {last:.6g} s", file=reader.file)
    return best
