"""A log of a robot: its motion and measured torques on an even grid, block by block."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import Caveat, TrajectoryError
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.input_file import open_input
from robodyn.support.wording import Cell, Shown, count, figure, shown, shown_path
from robodyn.trajectory.derivatives.derivative_selection import estimate
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.read import read_motion

_COARSE, _VALUES = 0.01, 500
"""Of a torque's range: steps that are told; values from which on a torque does not come in steps."""
_NOISE = 1 << 13  # samples from whose positions the noise is told
GAP, _EVEN = 4.5, 1e-3
"""So many steps without a row part a log in stretches; stamps that are off a grid by less than this part are even."""
_FEWEST, SIGHT = 64, 1 << 17  # rows up to which nothing is compared; samples from whose torques the noise is told
REMEDY = "is it the right log, and are torques recorded?"
_HALO = 8  # rows on either side that an interpolated value sees
_WIDTH, _DEVIATIONS = 7, 10.0
"""Samples of the running median, by which three wrong ones next to each other are seen; times what torques are usually
off it."""
_OFTEN, _PILED = 8, 5.0
"""Samples at a torque's extreme, and how many times those one and two steps below, from which on it is clipped; the top
of a parabola is reached 2.4 times as often as what is one step below."""
_SHARE = 0.5  # of the range of 98 % of the running medians
_LOUD = 10.0  # times the noise: torques that are compared


@dataclass(frozen=True, repr=False)
class Log(Shown):
    """What a file tells of a motion and its torques; the file is read anew by every pass, in blocks.

    Attributes:
        measured: rates whose torques are measured, as places in `model.rates`.
        start, stop: first and last stamp; step: of the grid [s]; samples: rows of the table; even: whether they stand
            on such a grid, so that nothing is interpolated.
        noise: standard deviation of the noisiest position [rad or m], where derivatives are missing; else 0.
        derived: whether velocities or accelerations are missing.
        cutoff: above which torques are noise [Hz].
        spikes: (n,) how far off their neighbours torques are left out; limits: (2, n) the least and the largest torque,
            where an amplifier clips it; infinite where there are none [N m].
        delays: (n,) by which torques are logged late [s]; loud: (n,) standard deviation of their noise as if it were
            white, by second differences; 0 of coarse steps [N m].
        held: joints without columns, and where; caveats: about its units and its given rates.
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
    limits: Floats
    delays: Floats
    loud: Floats
    held: Mapping[str, float]
    notes: tuple[str, ...]
    caveats: tuple[Caveat, ...]

    def _lines(self) -> Sequence[str]:
        known = f"{len(self.measured)} of {count(self.model.n, 'torque')} measured"
        times = f"{count(self.samples, 'sample')} from {figure(self.start, 6)} to {figure(self.stop, 6)} s"
        moved = f"derived of positions with a noise of {figure(self.noise)}" if self.derived else "given"
        said = f"{count(len(self.notes), 'note')}, {count(len(self.caveats), 'caveat')}"
        return (
            f"Log {shown_path(self.path)} of {shown(self.model.name)}: {known}, {times}",
            f"steps of {figure(self.step, 6)} s, torques are noise above {figure(self.cutoff)} Hz",
            f"accelerations are {moved}; {said}",
        )

    def _table(self) -> tuple[Sequence[str], Sequence[Sequence[Cell]]]:
        columns = (self.loud, self.delays, *self.limits)
        rows: list[list[Cell]] = [[self.model.rates[k], *(float(each[k]) for each in columns)] for k in self.measured]
        return ("measured", "noise", "late [s]", "clipped below", "clipped above"), rows

    @property
    def noisy(self) -> bool:
        """Whether derivatives are to be taken of smoothed positions."""
        return self.noise > 0.0

    @property
    def sha256(self) -> str:
        """Of the file, or of the files of a folder one after another."""
        found = hashlib.sha256()
        path = Path(self.path)
        for each in sorted(filter(Path.is_file, path.iterdir())) if path.is_dir() else [path]:
            with open_input(each) as file:
                while part := file.read(1 << 20):
                    found.update(part)
        return found.hexdigest()

    def blocks(self) -> Iterator[Samples]:
        """Yield the samples on even grids, one for each stretch without gaps."""
        grid = None if self.even and not self.delays.any() else Grid(self.step, self.delays)
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
        with read_motion(self.path, self.model, self.scene, **self.options) as reader:
            for block in reader.blocks():
                tau = mended(measured_torques(block, self.model), self.spikes)
                tau[(tau <= self.limits[0]) | (tau >= self.limits[1])] = np.nan
                far = np.flatnonzero(np.diff(block.time, prepend=last) > GAP * self.step)
                last = float(block.time[-1])
                whole = Samples(block.time, block.q, block.qd, block.qdd, tau, False)
                for start, stop in zip([0, *far], [*far, len(block)], strict=True):
                    if stop > start:
                        yield whole.cut(slice(start, stop), start in far)


def read_log(path: str, model: Model, scene: Scene = DEFAULT, *, cutoff: float | None = None, **options: Any) -> Log:
    """Return a log with measured torques; joints without columns are held at rest.

    Args:
        cutoff: above which torques are noise [Hz]; None: as `noise_cutoff` finds it.
        options: of `robodyn.read_motion`.

    Raises:
        TrajectoryError: the file cannot be read, does not fit, gives no torque, or has too few rows; it is standard
            input, which cannot be read anew.
    """
    if path == "-":
        what = "a log is read several times, and standard input only once"
        raise TrajectoryError(what, remedy="name a file", file="<stdin>")
    if any(body.joint.kind == "floating" for body in model.bodies):
        raise TrajectoryError("the base moves freely, and what carries it is not measured", remedy="fix the base")
    options = {**options, "hold": options.get("hold") or "rest", "measured": True}
    scan = Scan(model)
    with read_motion(path, model, scene, **{**options, "derivatives": "none"}) as reader:
        for block in reader.blocks():
            scan.add(block)
        notes, derived = reader.notes, bool(reader.missing)
    derive = derived and options.get("derivatives", "auto") == "auto"
    noise = 0.0
    if derive:
        first = scan.seen[0]
        noise = max(estimate([(first.time[:_NOISE], *[q[:_NOISE, None]] * 2)]).sigma for q in first.q.T)
    if noise:
        options["derivatives"] = "none"
    measured, constant = scan.measured(path)
    step, even = scan.grid(path)
    tau = np.concatenate([measured_torques(block, model) for block in scan.seen])[:SIGHT]
    spikes, held, given = limits(tau), scan.last.held, {*measured, *constant}
    moves = np.concatenate([block.q for block in scan.seen])[:SIGHT]
    clipped = clipping(tau, (np.diff(moves, axis=0, prepend=moves[:1]) != 0.0).any(axis=1))
    notes = (
        *notes,
        *(f"{name} is held at {position:.6g}" for name, position in held.items()),
        *(
            f"{name}: its torque was not measured"
            for i, name in enumerate(model.rates)
            if i not in given and name not in held
        ),
        *(f"the torque of {model.rates[i]} is {tau[0, i]:.6g} throughout: it is left out" for i in constant),
        *(f"the torque of {model.rates[i]} has spikes, which are left out" for i in measured if spikes[i] < np.inf),
        *_of_torques([model.rates[i] for i in measured], tau[:, measured], clipped[:, measured]),
    )
    return Log(
        path=path,
        model=model,
        scene=scene,
        options=options,
        measured=measured,
        start=float(scan.seen[0].time[0]),
        stop=float(scan.last.time[-1]),
        step=step,
        samples=scan.rows,
        even=even,
        noise=noise,
        derived=derived,
        cutoff=noise_cutoff(mended(tau, spikes)[:, measured], step) if cutoff is None else cutoff,
        spikes=spikes,
        limits=clipped,
        delays=np.zeros(model.n),
        loud=np.median(np.abs(np.diff(tau, 2, axis=0)), axis=0) / (0.6745 * np.sqrt(6.0)),
        held=held,
        notes=notes,
        caveats=scan.last.caveats,
    )


def _of_torques(names: Sequence[str], torques: Floats, limits: Floats) -> Iterator[str]:
    coarse = []
    for name, tau, ends in zip(names, torques.T, limits.T, strict=True):
        if np.isfinite(ends).any():
            share = 100.0 * float(np.mean((tau <= ends[0]) | (tau >= ends[1])))
            what = f"the torque of {name} stands at {' and '.join(f'{end:.4g}' for end in ends if np.isfinite(end))}"
            yield f"{what} in {share:.2g} % of the rows, as if it were clipped: they are left out"
        size = float(np.ptp(tau)) or 1.0
        values = np.unique(np.round(tau / size, 9))
        if 1 < len(values) < _VALUES and (step := float(np.diff(values).min())) > _COARSE:
            coarse.append(f"{step * size:.3g} ({name})")
    if coarse:
        yield f"torques are in steps of {', '.join(coarse)}: what is smaller cannot be told"


class Scan:
    """What a first pass over a log tells, in memory of its own: the first blocks, the last one, how many rows."""

    def __init__(self, model: Model) -> None:
        self.model, self.rows = model, 0
        self.seen: list[Trajectory] = []
        self.last: Trajectory
        self._low, self._high = np.full(model.n, np.inf), np.full(model.n, -np.inf)
        self._typical, self._steps = 0.0, (0, 0.0, np.inf, 0.0)

    def add(self, block: Trajectory) -> None:
        steps = np.diff(block.time, prepend=self.last.time[-1]) if self.rows else np.diff(block.time)
        if not self.rows and len(steps):
            self._typical = float(np.median(steps))
        near = steps[steps < GAP * self._typical]
        count, total, least, most = self._steps
        shortest, longest = float(near.min(initial=least)), float(near.max(initial=most))
        self._steps = count + len(near), total + float(near.sum()), shortest, longest
        tau = measured_torques(block, self.model)
        self._low, self._high = np.minimum(self._low, tau.min(axis=0)), np.maximum(self._high, tau.max(axis=0))
        self.rows, self.last = self.rows + len(block), block
        if sum(map(len, self.seen)) < SIGHT:
            self.seen.append(block)

    def measured(self, path: str) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return which torques are measured, as places in the rates, and which of the columns never change."""
        there = [i for i, name in enumerate(self.model.rates) if f"tau_{name}" in self.last.extra]
        if not there:
            what = "gives no torque of a joint: no column tau_<joint> and no effort"
            raise TrajectoryError(what, remedy="name one by --map tau_JOINT=COLUMN", file=path)
        varying = tuple(i for i in there if self._high[i] > self._low[i])
        if not varying:
            raise TrajectoryError("no measured torque ever changes: nothing was measured", remedy=REMEDY, file=path)
        return varying, tuple(i for i in there if i not in varying)

    def grid(self, path: str) -> tuple[float, bool]:
        """Return the mean step where there is no gap [s], and whether all such steps are alike."""
        if self.rows <= _FEWEST:
            what = f"has {self.rows} rows, too few to compare"
            raise TrajectoryError(what, remedy=f"give more than {_FEWEST}", file=path)
        count, total, least, most = self._steps
        step = total / count
        return step, max(step - least, most - step) < _EVEN * step


def measured_torques(block: Trajectory, model: Model) -> Floats:
    """Return (k, n) the measured torques of a block of a log, zero where nothing is measured [N m]."""
    zero = np.zeros(len(block))
    return np.stack([block.extra.get(f"tau_{name}", zero) for name in model.rates], axis=1)


class Samples(NamedTuple):
    """Consecutive samples (k,) on an even grid, with which a stretch begins or goes on. Torques [N m] are zero of
    joints that are not measured, NaN where they are left out."""

    time: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats
    begins: bool

    def cut(self, rows: slice | NDArray[np.intp], begins: bool) -> Samples:
        time, q, qd, qdd, tau, _ = self
        return Samples(time[rows], q[rows], qd[rows], qdd[rows], tau[rows], begins)


def joined(first: Samples, second: Samples) -> Samples:
    time, q, qd, qdd, tau = map(np.concatenate, zip(first[:-1], second[:-1], strict=True))
    return Samples(time, q, qd, qdd, tau, first.begins)


class Grid:
    """Puts rows with uneven stamps onto an even grid, and torques that are `delays` (n,) late [s] where they belong.
    Motion goes by cubic splines, torques by straight lines."""

    def __init__(self, step: float, delays: Floats) -> None:
        self._step, self._delays, self._next, self._begins = step, delays, 0.0, True
        self._halo = _HALO + int(np.ceil(np.abs(delays).max(initial=0.0) / step))
        self._rows: Samples | None = None

    def feed(self, part: Samples) -> Iterator[Samples]:
        """Yield the samples up to some rows before the end of a part."""
        if part.begins:
            yield from self.finish()
            self._rows, self._next, self._begins = None, float(part.time[0]), True
        rows = part if self._rows is None else joined(self._rows, part)
        self._rows = rows
        if len(rows.time) > self._halo:
            yield from self._until(float(rows.time[-self._halo]))
            first = max(0, int(np.searchsorted(rows.time, self._next)) - self._halo)
            self._rows = rows.cut(slice(first, None), False)

    def finish(self) -> Iterator[Samples]:
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
        late = zip(self._delays.tolist(), rows.tau.T, strict=True)
        outside = {True: np.nan, False: None}
        tau = [np.interp(time + d, rows.time, of, outside[d != 0.0], outside[d != 0.0]) for d, of in late]
        yield Samples(time, q, qd, qdd, np.stack(tau, axis=1), self._begins)
        self._next, self._begins = float(time[-1]) + self._step, False


def limits(tau: Floats) -> Floats:
    """Return (n,) how far off the running median a torque is a spike; infinite where none of tau (N, n) is."""
    middle = _medians(tau)
    off = np.abs(tau - middle)
    low, high = np.quantile(middle, (0.01, 0.99), axis=0)
    found = np.maximum(_DEVIATIONS * np.median(off, axis=0) / 0.6745, _SHARE * (high - low))
    return np.asarray(np.where((off > found).any(axis=0) & (found > 0.0), found, np.inf))


def mended(tau: Floats, limit: Floats) -> Floats:
    """Return (N, n) torques with the running median in the place of spikes."""
    if np.isinf(limit).all():
        return tau
    middle = _medians(tau)
    return np.asarray(np.where(np.abs(tau - middle) > limit, middle, tau))


def clipping(tau: Floats, moves: NDArray[np.bool_]) -> Floats:
    """Return (2, n) the least and the largest torque, where it stands there as nothing that moves does; else infinite;
    tau: (N, n) N m. moves: (N,) whether any joint does; a robot at rest needs the same torque for long."""
    found = np.stack((np.full(tau.shape[1], -np.inf), np.full(tau.shape[1], np.inf)))
    for j, column in enumerate(tau[moves].T):
        values, counts = np.unique(column, return_counts=True)
        for side, order in enumerate((slice(None), slice(None, None, -1))):
            most, next_ones = counts[order][:1].sum(), counts[order][1:3]
            if len(values) > 1 and most >= _OFTEN and most > _PILED * next_ones.max():
                found[side, j] = values[order][0]
    return found


def _medians(tau: Floats) -> Floats:
    from scipy.ndimage import median_filter

    return np.asarray(median_filter(tau, (_WIDTH, 1), mode="nearest"))


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
