"""A log of a robot: its motion and measured torques on an even grid, block by block."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.identify.spikes import limits, mended
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
_LOUD = 10.0
"""Times the noise: torques that are compared."""
_HALO = 8
"""Rows on either side that an interpolated value sees."""
_FEWEST = 64
"""Rows below which nothing is compared."""
_SIGHT, _NOISE = 1 << 17, 1 << 13
"""Samples from whose torques, and from whose positions, the noise is told."""


class Samples(NamedTuple):
    """Consecutive samples on an even grid.

    Attributes:
        time: (k,) s; q: (k, nq); qd, qdd: (k, n); tau: (k, n) N m, zero where nothing is measured.
        begins: whether a stretch begins with them.
    """

    time: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats
    begins: bool

    def cut(self, rows: slice, begins: bool) -> Samples:
        """Return some of the samples."""
        return Samples(self.time[rows], self.q[rows], self.qd[rows], self.qdd[rows], self.tau[rows], begins)


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
        notes: what was assumed and left out, one line each.
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
    notes: tuple[str, ...]

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
    time: list[Floats] = []
    seen: list[Trajectory] = []
    first: Floats | None = None
    varying = np.zeros(model.n, dtype=bool)
    with _reader(path, model, scene, {**options, "derivatives": "none"}) as reader:
        for block in reader.blocks():
            time.append(block.time)
            tau = measured_torques(block, model)
            first = tau[0] if first is None else first
            varying |= (tau != first).any(axis=0)
            if sum(map(len, seen)) < _SIGHT:
                seen.append(block)
            last = block
        notes, missing = reader.notes, reader.missing
    derive = bool(missing) and options.get("derivatives", "auto") == "auto"
    noise = _noise(seen[0]) if derive else 0.0
    if noise:
        options["derivatives"] = "none"
    measured = tuple(i for i, name in enumerate(model.rates) if f"tau_{name}" in last.extra)
    if not measured:
        what = "gives no torque of a joint: no column tau_<joint> and no effort"
        raise TrajectoryError(what, remedy="name one by --map tau_JOINT=COLUMN", file=path)
    constant = [i for i in measured if not varying[i]]
    if len(constant) == len(measured):
        what = "no measured torque ever changes: nothing was measured"
        raise TrajectoryError(what, remedy="is it the right log, and are torques recorded?", file=path)
    measured = tuple(i for i in measured if varying[i])
    stamps = np.concatenate(time)
    steps = np.diff(stamps)
    if len(steps) < _FEWEST:
        raise TrajectoryError(f"has {len(steps) + 1} rows, too few to compare", remedy=f"give {_FEWEST}", file=path)
    step = float(np.median(steps))
    near = steps[steps < GAP * step]
    step = float(near.mean())
    tau = np.concatenate([measured_torques(block, model) for block in seen])[:_SIGHT]
    spikes = limits(tau)
    constants = [f"the torque of {model.rates[i]} is {tau[0, i]:.6g} throughout: it is left out" for i in constant]
    spiked = [f"the torque of {model.rates[i]} has spikes, which are left out" for i in measured if spikes[i] < np.inf]
    tau = mended(tau, spikes)[:, measured]
    held = tuple(f"{name} is held at {position:.6g}" for name, position in last.held.items())
    return Log(
        path,
        model,
        scene,
        options,
        measured,
        float(stamps[0]),
        float(stamps[-1]),
        step,
        len(steps) + 1,
        bool(np.abs(near - step).max() < _EVEN * step),
        noise,
        bool(missing),
        noise_cutoff(tau, step) if cutoff is None else cutoff,
        spikes,
        (*notes, *held, *constants, *spiked, *(doubt.said for doubt in last.doubts)),
    )


def _noise(block: Trajectory) -> float:
    """Return the standard deviation of the noise of the noisiest position, as the first rows tell."""
    rows = slice(0, _NOISE)
    time, q = block.time[rows], block.q[rows]
    return max(estimate([(time, column, column)]).sigma for column in np.split(q, q.shape[1], axis=1))


def _reader(path: str, model: Model, scene: Scene, options: Mapping[str, Any]) -> TrajectoryReader:
    return read_motion(path, model, scene, **options)


class Grid:
    """Puts rows with uneven stamps onto an even grid: motion by cubic splines, torques by straight lines."""

    def __init__(self, step: float) -> None:
        self._step, self._next, self._begins = step, 0.0, True
        self._rows: Samples | None = None

    def feed(self, part: Samples) -> Iterator[Samples]:
        """Yield the samples up to some rows before the end of a part."""
        if part.begins:
            yield from self.finish()
            self._rows, self._next, self._begins = None, float(part.time[0]), True
        rows = part if self._rows is None else joined(self._rows, part)
        self._rows = rows
        if len(rows.time) > _HALO:
            yield from self._until(float(rows.time[-_HALO]))
            first = max(0, int(np.searchsorted(rows.time, self._next)) - _HALO)
            self._rows = rows.cut(slice(first, None), False)

    def finish(self) -> Iterator[Samples]:
        """Yield what is left of a stretch."""
        if self._rows is not None:
            yield from self._until(float(self._rows.time[-1]))

    def _until(self, stop: float) -> Iterator[Samples]:
        from scipy.interpolate import CubicSpline

        rows = self._rows
        count = int(np.floor((stop - self._next) / self._step * (1.0 + 1e-12))) + 1
        if rows is None or count < 1 or len(rows.time) < 4:
            return
        time: Floats = np.asarray(self._next + self._step * np.arange(count))
        motion = CubicSpline(rows.time, np.concatenate([rows.q, rows.qd, rows.qdd], axis=1))(time)
        q, qd, qdd = np.split(motion, [rows.q.shape[1], rows.q.shape[1] + rows.qd.shape[1]], axis=1)
        tau = np.stack([np.interp(time, rows.time, column) for column in rows.tau.T], axis=1)
        yield Samples(time, q, qd, qdd, tau, self._begins)
        self._next, self._begins = float(time[-1]) + self._step, False


def joined(first: Samples, second: Samples) -> Samples:
    """Return consecutive samples as one."""
    time, q, qd, qdd, tau = (
        np.concatenate([getattr(part, name) for part in (first, second)]) for name in Samples._fields[:-1]
    )
    return Samples(time, q, qd, qdd, tau, first.begins)


def noise_cutoff(tau: Floats, step: float) -> float:
    """Return the frequency [Hz] above which torques are noise, rounded to two digits: the median of the joints.

    The amplitude spectrum (Welch's, Hann window) is above ten times that of the highest octave up to there, by
    medians over sixths of an octave, which see no single lines; and at least 1e-5 of the power is above. It lies
    between 60 periods of the log, of which the filter leaves five sixths, and a fifth of the sampling rate.

    Args:
        tau: (N, k) N m.
    """
    length = max(64, 1 << int(np.log2(max(len(tau) // 4, 1))))
    window = np.hanning(length)[:, None]
    power = np.zeros((length // 2 + 1, tau.shape[1]))
    for start in range(0, max(1, len(tau) - length + 1), length // 2):
        part = tau[start : start + length]
        power += np.abs(np.fft.rfft(window[: len(part)] * (part - part.mean(axis=0)), length, axis=0)) ** 2
    frequency = np.fft.rfftfreq(length, step)
    floor = _LOUD**2 * np.median(power[len(power) // 2 :], axis=0)
    left = np.cumsum(power[::-1], axis=0)[::-1]
    found = np.zeros(tau.shape[1])
    edges = frequency[1] * 2.0 ** np.arange(0.0, np.log2(len(power) - 1), 1.0 / 6.0)
    for low, high in pairwise(edges):
        band = (frequency >= low) & (frequency < high)
        if band.any():
            loud = (np.median(power[band], axis=0) > floor) & (left[np.argmax(band)] > 1e-5 * left[0])
            found[loud] = high
    lowest, highest = 60.0 / (len(tau) * step), 0.2 / step
    return float(f"{min(max(float(np.median(found)), lowest), highest):.2g}")
