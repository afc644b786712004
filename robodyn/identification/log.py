"""A log of a robot: its motion and measured torques on an even grid, block by block."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.identification.noise_cutoff import noise_cutoff
from robodyn.identification.samples import Grid, Samples
from robodyn.identification.spikes import limits, mended
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.noise import estimate
from robodyn.trajectory.reader import TrajectoryReader
from robodyn.trajectory.robot_motion import read_motion

GAP = 4.5
"""So many steps without a row part a log in stretches."""
_EVEN = 1e-3
"""Stamps that are off an even grid by less than this part of a step are taken for even."""
_FEWEST = 64
"""Rows below which nothing is compared."""
_SIGHT, _NOISE = 1 << 17, 1 << 13
"""Samples from whose torques, and from whose positions, the noise is told."""


@dataclass(frozen=True)
class Log:
    """What a file tells of a motion and its torques; the file is read anew by every pass, in blocks.

    Attributes:
        measured: rates whose torques are measured, as places in `model.rates`.
        start, stop: first and last stamp; step: of the grid [s]; samples: rows of the table.
        even: whether the rows stand on such a grid, so that nothing is interpolated.
        noise: standard deviation of the noisiest position [rad or m], where derivatives are missing; else 0.
        derived: whether velocities or accelerations are missing.
        cutoff: above which torques are noise [Hz].
        spikes: (n,) how far off their neighbours torques are left out [N m].
        held: joints without columns, and where.
        notes: what was assumed and left out, one line each; doubts: why its units may be others.
    """

    path: str
    model: Model
    scene: Scene
    options: Mapping[str, Any]
    measured: tuple[int, ...]
    start: float
    stop: float
    step: float
    samples: int
    even: bool
    noise: float
    derived: bool
    cutoff: float
    spikes: Floats
    held: Mapping[str, float]
    notes: tuple[str, ...]
    doubts: tuple[str, ...]

    @property
    def noisy(self) -> bool:
        """Whether derivatives are to be taken of smoothed positions."""
        return self.noise > 0.0

    @property
    def sha256(self) -> str:
        """Of the file, or of the files of a folder one after another; of standard input nothing."""
        found = hashlib.sha256()
        names = sorted(os.listdir(self.path)) if os.path.isdir(self.path) else [""]
        for name in names:
            with open(os.path.join(self.path, name) if name else self.path, "rb") as file:
                while part := file.read(1 << 20):
                    found.update(part)
        return found.hexdigest()

    def blocks(self) -> Iterator[Samples]:
        """Yield the samples on even grids, one grid for each stretch without gaps."""
        grid = None if self.even else Grid(self.step)
        for part in self._parts():
            if grid is None:
                yield part
            else:
                yield from grid.feed(part)
        if grid is not None:
            yield from grid.finish()

    def _parts(self) -> Iterator[Samples]:
        """Yield the rows of the table, parted where stamps leave a gap."""
        last = -np.inf
        with _reader(self.path, self.model, self.scene, self.options) as reader:
            for block in reader.blocks():
                tau = mended(measured_torques(block, self.model), self.spikes)
                far = np.flatnonzero(np.diff(block.time, prepend=last) > GAP * self.step)
                last = float(block.time[-1])
                for start, stop in zip([0, *far], [*far, len(block)], strict=True):
                    if stop > start:
                        rows = slice(start, stop)
                        yield Samples(
                            block.time[rows], block.q[rows], block.qd[rows], block.qdd[rows], tau[rows], start in far
                        )


def measured_torques(block: Trajectory, model: Model) -> Floats:
    """Return (k, n) the measured torques of a block of a log, zero where nothing is measured [N m]."""
    zero = np.zeros(len(block))
    return np.stack([block.extra.get(f"tau_{name}", zero) for name in model.rates], axis=1)


def read_log(path: str, model: Model, scene: Scene = DEFAULT, *, cutoff: float | None = None, **options: Any) -> Log:
    """Return a log with measured torques; joints without columns are held at rest.

    Args:
        cutoff: above which torques are noise [Hz]; None: as `noise_cutoff` finds it.
        options: of `robodyn.read_motion`.

    Raises:
        TrajectoryError: the file cannot be read, does not fit, gives no torque, or has too few rows.
    """
    if any(body.joint.kind == "floating" for body in model.bodies):
        raise TrajectoryError("the base moves freely, and what carries it is not measured", remedy="fix the base")
    options = {**options, "hold": options.get("hold") or "rest", "measured": True}
    scan = _Scan(model)
    with _reader(path, model, scene, {**options, "derivatives": "none"}) as reader:
        for block in reader.blocks():
            scan.add(block)
        notes, missing = reader.notes, reader.missing
    derive = bool(missing) and options.get("derivatives", "auto") == "auto"
    noise = _noise(scan.seen[0]) if derive else 0.0
    if noise:
        options["derivatives"] = "none"
    measured, constant = scan.measured(path)
    step, even = scan.grid(path)
    tau = np.concatenate([measured_torques(block, model) for block in scan.seen])[:_SIGHT]
    spikes = limits(tau)
    notes = (
        *notes,
        *(f"{name} is held at {position:.6g}" for name, position in scan.last.held.items()),
        *(f"the torque of {model.rates[i]} is {tau[0, i]:.6g} throughout: it is left out" for i in constant),
        *(f"the torque of {model.rates[i]} has spikes, which are left out" for i in measured if spikes[i] < np.inf),
    )
    return Log(
        path=path,
        model=model,
        scene=scene,
        options=options,
        measured=measured,
        start=scan.start,
        stop=scan.stop,
        step=step,
        samples=scan.rows,
        even=even,
        noise=noise,
        derived=bool(missing),
        cutoff=noise_cutoff(mended(tau, spikes)[:, measured], step) if cutoff is None else cutoff,
        spikes=spikes,
        held=scan.last.held,
        notes=notes,
        doubts=tuple(doubt.said for doubt in scan.last.doubts),
    )


@dataclass
class _Scan:
    """What a first pass over a log tells, in memory that does not grow with it.

    Attributes:
        seen: the first blocks; last: the last one; rows: of the table.
    """

    model: Model
    seen: list[Trajectory] = field(default_factory=list)
    rows: int = 0
    start: float = 0.0
    stop: float = 0.0
    _first: Floats | None = None
    _varying: Floats | None = None
    _typical: float = 0.0
    _steps: list[float] = field(default_factory=lambda: [0.0, 0.0, np.inf, 0.0])

    def add(self, block: Trajectory) -> None:
        """Take in the next block."""
        tau = measured_torques(block, self.model)
        if self._first is None or self._varying is None:
            self._first, self._varying, self.start = tau[0], np.zeros(self.model.n), float(block.time[0])
            self._typical = float(np.median(np.diff(block.time))) if len(block) > 1 else 0.0
        steps = np.diff(block.time, prepend=self.stop) if self.rows else np.diff(block.time)
        near = steps[steps < GAP * self._typical]
        if len(near):
            count, total, least, most = self._steps
            self._steps = [
                count + len(near),
                total + float(near.sum()),
                min(least, float(near.min())),
                max(most, float(near.max())),
            ]
        self._varying = np.maximum(self._varying, np.abs(tau - self._first).max(axis=0))
        self.rows, self.stop, self.last = self.rows + len(block), float(block.time[-1]), block
        if sum(map(len, self.seen)) < _SIGHT:
            self.seen.append(block)

    def measured(self, path: str) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return which torques are measured, as places in the rates, and which of the columns never change."""
        there = [i for i, name in enumerate(self.model.rates) if f"tau_{name}" in self.last.extra]
        if not there or self._varying is None:
            what = "gives no torque of a joint: no column tau_<joint> and no effort"
            raise TrajectoryError(what, remedy="name one by --map tau_JOINT=COLUMN", file=path)
        varying = tuple(i for i in there if self._varying[i] > 0.0)
        if not varying:
            what = "no measured torque ever changes: nothing was measured"
            raise TrajectoryError(what, remedy="is it the right log, and are torques recorded?", file=path)
        return varying, tuple(i for i in there if i not in varying)

    def grid(self, path: str) -> tuple[float, bool]:
        """Return the mean step where there is no gap [s], and whether all such steps are alike."""
        if self.rows <= _FEWEST:
            raise TrajectoryError(f"has {self.rows} rows, too few to compare", remedy=f"give {_FEWEST}", file=path)
        count, total, least, most = self._steps
        step = total / count
        return step, max(step - least, most - step) < _EVEN * step


def _noise(block: Trajectory) -> float:
    """Return the standard deviation of the noise of the noisiest position, as the first rows tell."""
    rows = slice(0, _NOISE)
    time, q = block.time[rows], block.q[rows]
    return max(estimate([(time, column, column)]).sigma for column in np.split(q, q.shape[1], axis=1))


def _reader(path: str, model: Model, scene: Scene, options: Mapping[str, Any]) -> TrajectoryReader:
    return read_motion(path, model, scene, **options)
