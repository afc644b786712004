"""A log of a robot: its motion and measured torques on an even grid, block by block."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.identification.log_scan import GAP, SIGHT, Scan, measured_torques
from robodyn.identification.noise_cutoff import noise_cutoff
from robodyn.identification.samples import Grid, Samples
from robodyn.identification.spikes import clipping, limits, mended, noise_of, step_of
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.caveats import Caveat
from robodyn.support.floats import Floats
from robodyn.support.input_file import open_input
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.noise import estimate
from robodyn.trajectory.robot_motion import read_motion

_COARSE = 0.01
"""Of a torque's range: steps that are told."""
_NOISE = 1 << 13
"""Samples from whose positions the noise is told."""


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
        limits: (2, n) the least and the largest torque, where an amplifier clips it; infinite where none does [N m].
        delays: (n,) by which torques are logged late [s]; loud: (n,) standard deviation of their noise [N m].
        held: joints without columns, and where.
        notes: what was assumed and left out, one line each; caveats: about its units and its given rates.
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
        """Yield the samples on even grids, one grid for each stretch without gaps."""
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
                for start, stop in zip([0, *far], [*far, len(block)], strict=True):
                    if stop > start:
                        rows = slice(start, stop)
                        yield Samples(
                            block.time[rows], block.q[rows], block.qd[rows], block.qdd[rows], tau[rows], start in far
                        )


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
    noise = _noise(scan.seen[0]) if derive else 0.0
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
        *(_clipped(model.rates[i], tau[:, i], clipped[:, i]) for i in measured if np.isfinite(clipped[:, i]).any()),
        *_in_steps([(model.rates[i], tau[:, i]) for i in measured]),
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
        loud=noise_of(tau),
        held=held,
        notes=notes,
        caveats=scan.last.caveats,
    )


def _clipped(name: str, tau: Floats, ends: Floats) -> str:
    share = 100.0 * float(np.mean((tau <= ends[0]) | (tau >= ends[1])))
    where = " and ".join(f"{end:.4g}" for end in ends if np.isfinite(end))
    return (
        f"the torque of {name} stands at {where} in {share:.2g} % of the rows, as if it were clipped: they are left out"
    )


def _in_steps(torques: Sequence[tuple[str, Floats]]) -> list[str]:
    """Return a line if torques have few values."""
    coarse = [f"{each:.3g} ({name})" for name, tau in torques if (each := step_of(tau)) > _COARSE * np.ptp(tau)]
    return [f"torques are in steps of {', '.join(coarse)}: what is smaller cannot be told"] if coarse else []


def _noise(block: Trajectory) -> float:
    """Return the standard deviation of the noise of the noisiest position, as the first rows tell."""
    rows = slice(0, _NOISE)
    time, q = block.time[rows], block.q[rows]
    return max(estimate([(time, column, column)]).sigma for column in np.split(q, q.shape[1], axis=1))
