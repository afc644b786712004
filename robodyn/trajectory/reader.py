"""The reader of a table: block by block, missing derivatives filled in; one sample of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.support.caveats import Caveat
from robodyn.support.floats import Floats
from robodyn.support.wording import count
from robodyn.trajectory.assemble import Assembly, cut, with_neighbours
from robodyn.trajectory.columns import Signals
from robodyn.trajectory.groups import anew, consistent, given, missing, samples_needed
from robodyn.trajectory.header import Header, listing
from robodyn.trajectory.layout import Layout, resolve
from robodyn.trajectory.motion import FEW, Derivation, Sampling, Trajectory
from robodyn.trajectory.plausible import Plausibility
from robodyn.trajectory.reading import DEFAULT, MODES, Reading
from robodyn.trajectory.standstill import REACH, Standstill
from robodyn.trajectory.table import Table, reason

if TYPE_CHECKING:
    from robodyn.trajectory.derive import Plan
    from robodyn.trajectory.given import Given

BLOCK_ROWS = 1 << 15
_PIECES, _PIECE_ROWS = 16, 4096
_COMPARED = 4, 1024
_FEW, _OFTEN = 3, 0.9
_AT_REST = (
    "one row is no motion: velocities and accelerations that it does not give are 0, as at rest "
    "(robodyn fbd ROBOT --at Q shows the forces on each body)"
)


class TrajectoryReader:
    """Samples of a table, block by block; also a context manager that closes the file.

    columns: the names in the table; size_bytes, position_bytes: length of the file and how much has been read;
    notes: assumptions made so far; derivation: how velocities and accelerations are derived, None if all are given;
    caveats: what makes the units doubtful, by all that has been read; followed: joints without columns that loops tell;
    missing: joints whose velocities or accelerations are not given.
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
            from robodyn.trajectory.log_table import whole_joints

            reading = replace(reading, ignore_extra=True, columns=whole_joints(reading.columns, table.names))
        self._table, self._mode, self._rows = table, reading.derivatives, block_rows
        self.columns = table.names
        header = Header(table.names, table.file, table.header_line)
        if header.labels:
            header = header.labelled(table.texts([*header.labels]))
        layout = resolve(header, signals, extra, reading)
        if reading.derivatives == "anew":
            layout = anew(signals, layout)
        layout = _begun(layout, table)
        self._assembly = Assembly(signals, layout, table.error_at)
        self._groups, assumptions = missing(signals, layout)
        self.missing = tuple(group.name for group in self._groups)
        self._told = given(signals, layout)
        self._encoder_error = reading.encoder_error
        if reading.derivatives == "none":
            self._groups = self._told = ()
        if reading.derivatives == "given" and self._groups:
            lost = [group.name for group in self._groups]
            what = f"velocity or acceleration of {listing(lost)} is not given"
            raise header.error(what, "--derivatives auto derives what is missing")
        self.notes, self.followed = (*table.notes, *layout.notes, *assumptions), layout.followed
        self.caveats: tuple[Caveat, ...] = ()
        self._plan: Plan | None = None
        self._open: Floats | None = None

    @property
    def file(self) -> str | None:
        """As messages name it; None for arrays."""
        return self._table.file

    @property
    def size_bytes(self) -> int:
        return self._table.size_bytes

    @property
    def position_bytes(self) -> int:
        return self._table.position_bytes

    @property
    def derivation(self) -> Derivation | None:
        return self._plan.derivation if self._plan else None

    def blocks(self) -> Iterator[Trajectory]:
        """Consecutive samples, at most `block_rows` at a time; each pass starts anew.

        Derivatives see neighbours on either side of a block.

        Raises:
            TrajectoryError: a cell, a row or the time is wrong, or there are too few rows to differentiate.

        Accuracy: the limits of blocks change a derivative by at most 1e-11 of the largest, 1e-13 with unequal stamps.
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
        known: dict[int, tuple[float, float]] = {}
        pieces = self._pieces(*(_PIECES, _PIECE_ROWS) if self._groups else _COMPARED)
        if self._groups:
            from robodyn.trajectory.derive import plan

            mode = "auto" if self._mode == "anew" else self._mode
            self._plan = plan(self._groups, pieces, mode, self._encoder_error)
            self._remember(self._plan.notes)
            known = self._plan.resolutions
        check: Given | None = None
        enough = bool(self._told) and max(map(len, pieces), default=0) >= FEW
        self._open = consistent(self._told, pieces) if enough and not self._groups else None
        if enough and self._open is None:
            from robodyn.trajectory.given import against_positions

            check = against_positions(self._told, pieces, self._plan, self._encoder_error)
        every = self._assembly.signals, self._assembly.layout
        still = Standstill(*every, pieces, known) if self._mode != "none" else None
        halo = max(max(self._plan.halo, REACH) if self._plan else 0, check.halo if check else 0)
        needed = max(1, samples_needed(self._groups))
        plausible = Plausibility(self._assembly.signals, self._assembly.layout)
        for samples, start, stop in with_neighbours(self._samples(), halo):
            if len(samples) == 1 < needed:
                self._plan = None
                self._remember([_AT_REST])
            elif len(samples) < needed:
                self._refuse_short(len(samples), needed)
            block = self._trusted(samples, check, still, slice(start, stop))
            plausible.update(block if self._plan or not self.missing else _with_rough_speeds(block))
            self.caveats = (*plausible.caveats(), *(check.caveats if check else ()))
            yield replace(block, derivation=self.derivation, notes=self.notes, caveats=self.caveats)

    def _trusted(self, samples: Trajectory, check: Given | None, still: Standstill | None, rows: slice) -> Trajectory:
        """Return some of the samples with the missing columns, speeds of 0 where joints stand still, and how far they
        can be trusted."""
        known = None
        if self._plan:
            from robodyn.trajectory.derive import derive, sampling

            samples, noise, off = derive(samples, self._plan)
            known = sampling(samples, self._plan, noise, off, rows)
        if check:
            known = check.trusted(samples, known, rows)
        elif self._open is not None:
            qdd = samples.qdd[rows]
            known = Sampling(self._open + 0.0 * qdd, 0.0 * qdd, 0.0 * self._open, (qdd**2).sum(axis=0))
        elif known and self._told:
            known = replace(known, unknown=True)
        samples = still.stopped(samples) if still else samples
        return replace(cut(samples, rows.start, rows.stop), sampling=known)

    def _samples(self) -> Iterator[Trajectory]:
        row, last_time = 1, -math.inf
        for block in self._table.blocks(self._assembly.layout.needed, self._rows):
            if len(block):
                samples = self._assembly.samples(block, row, last_time)
                self._remember(samples.notes)
                row, last_time = row + len(block), float(samples.time[-1])
                yield samples
        if row == 1:
            raise TrajectoryError("has no rows", remedy="give rows of numbers", file=self._table.file)

    def _pieces(self, count: int, rows: int) -> list[Trajectory]:
        """Runs of samples that stand for the table; bad rows are left for `blocks` to report."""
        pieces: list[Trajectory] = []
        if not (self._groups or self._told):
            return pieces
        for block in self._table.pieces(self._assembly.layout.needed, count, rows):
            if len(block) and np.isfinite(block).all():
                with suppress(TrajectoryError):
                    pieces.append(self._assembly.samples(block, 1, -math.inf))
        return pieces

    def _remember(self, notes: Sequence[str]) -> None:
        self.notes = tuple(dict.fromkeys((*self.notes, *notes)))

    def _refuse_short(self, rows: int, needed: int) -> None:
        what = f"has {count(rows, 'row')}, too few to differentiate"
        remedy = f"give at least {needed} rows, or velocities and accelerations"
        raise TrajectoryError(what, remedy=remedy, file=self._table.file)

    def close(self) -> None:
        self._table.close()

    def __enter__(self) -> TrajectoryReader:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _with_rough_speeds(block: Trajectory) -> Trajectory:
    """Return a block with high differences of its positions, which no turn of 2 pi is among, for velocities of zero."""
    if len(block) < _FEW or block.q.shape != block.qd.shape:
        return block
    steps = np.quantile(np.abs(np.diff(block.q, axis=0)), _OFTEN, axis=0)
    rough = steps / float(np.median(np.diff(block.time)))
    return replace(block, qd=np.where(block.qd.any(axis=0), block.qd, rough))


def _begun(layout: Layout, table: Table) -> Layout:
    """Return the layout with the origin of its stamps, which the table subtracts from now on."""
    table.choose(layout.needed)
    clock = layout.clock.begun(table.first(layout.clock.columns))
    table.origins = dict(zip(clock.columns, clock.origin, strict=False))
    return replace(layout, clock=clock)


def row_at(
    reader: TrajectoryReader, time: float, complete: Callable[[Trajectory], Trajectory] = lambda block: block
) -> Trajectory:
    """The sample nearest to `time` [s], the earlier of two that are as near; nothing is interpolated.

    Args:
        complete: fills in what blocks lack, one after another.

    Raises:
        TrajectoryError: the time is before the first row or after the last, or the table is wrong.
    """
    first, best, last = float("nan"), None, float("nan")
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
