"""Passes over the logs that are fitted and those that are held out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.motors import spins
from robodyn.dynamics.regressor import INERTIAL
from robodyn.errors import InputError
from robodyn.identification.faults.channels import magnitudes, told
from robodyn.identification.faults.installation import CLEAR, Raw
from robodyn.identification.log.log import Log
from robodyn.identification.log.rows import PERIODS, POSITIONS, kernel, rates, states
from robodyn.identification.model_selection import (
    Structure,
    counts,
    coupled,
    coupled_motors,
    fitted,
    joint_motors,
    scene_motors,
    system,
    with_speeds,
)
from robodyn.identification.parameters.base import base_of
from robodyn.identification.parameters.regressor_columns import (
    PLAIN,
    Gathered,
    Guess,
    Moments,
    Motor,
    RegressorColumns,
    gather,
)
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.caveats import WrongUnits
from robodyn.support.floats import Floats, einsum

FOLDS = 5
"""Parts of what is fitted, for cross-validation; what is held out is another one."""
RESTS = 1e-6
"""rad/s (m/s): a joint that is never faster rests."""
_NOISE = 4.0
_SLOW = 1e-5
"""Of the largest speed: below it, derived speeds do not tell the sign of friction."""


@dataclass(frozen=True, eq=False)
class Run:
    """Logs that are fitted, then those that are held out, and how they are gone through."""

    logs: tuple[Log, ...]
    edges: tuple[tuple[float, ...], ...]
    measured: tuple[int, ...]
    scene: Scene
    cutoff: float
    slip_speed: float
    directions: dict[str, Motor]
    holds: bool

    @property
    def model(self) -> Model:
        return self.logs[0].model

    def delayed(self, delays: Floats) -> Run:
        """Return the run through logs whose torques are (n,) late [s]."""
        return replace(self, logs=tuple(replace(log, delays=delays) for log in self.logs))

    def gathered(self, regressor: RegressorColumns, guess: Guess | None = None) -> tuple[Gathered, Gathered]:
        """Return the factors of one pass over all logs, and the weighted ones."""
        plain, weighted = Gathered(FOLDS + 1, regressor), Gathered(FOLDS + 1, regressor)
        for log, edges in zip(self.logs, self.edges, strict=True):
            gather(log, self.cutoff, edges, plain, weighted, guess)
        return plain, weighted


def begun(logs: Sequence[Log], validate: Sequence[Log], scene: Scene, split: float, cutoff: float | None) -> Run:
    """Go through the logs once for the largest speeds."""
    every = (*logs, *validate)
    model = every[0].model
    check_size(model)
    for spin in spins(model, scene):
        what = f"[rotor] {spin.joint.name} has an axis, and identify knows only rotors that turn in place"
        raise InputError(what, remedy="leave axis and on out")
    measured = tuple(j for j in every[0].measured if all(j in log.measured for log in every))
    if not measured:
        raise InputError("the logs have no measured joint in common", remedy="identify them one by one")
    cutoff = min(log.cutoff for log in every) if cutoff is None else cutoff
    check_files(every, cutoff)
    known = scene_motors(model, scene)
    candidates = [*joint_motors(model), *known, *coupled_motors(model, measured, known)]
    largest = np.zeros(len(candidates))
    slip = scene.slip_speed
    for log in every:
        top = np.zeros(len(candidates))
        for samples in states(log, cutoff):
            speeds = einsum("kj,mj->km", samples.qd, np.stack([motor.direction for motor in candidates]))
            top = np.maximum(top, np.abs(speeds).max(axis=0, initial=0.0))
        if log.derived and not scene.slip_speed:
            _, first, _ = rates(kernel(min(POSITIONS * cutoff, 0.4 / log.step), log.step), log.step)
            noise = log.noise * float(np.sqrt((first**2).sum()))  # of the speeds of smoothed positions
            slip = max(slip, _SLOW * float(top[: model.n].max()), _NOISE * noise)
        largest = np.maximum(largest, top)
    if largest[: model.n].max() <= max(RESTS, 2.0 * slip if slip != scene.slip_speed else 0.0):
        why = ["no joint moves: the log shows nothing of masses and friction", *(c.text for c in every[0].caveats)]
        raise InputError("; ".join(why), remedy="log an exciting motion, see robodyn excite", file=every[0].path)
    motors = {each.name: with_speeds(each, float(top), slip) for each, top in zip(candidates, largest, strict=True)}
    ends = [log.start + (log.stop - log.start) * split * np.arange(1, FOLDS + 1) / FOLDS for log in logs]
    edges = (*(tuple(each.tolist()) for each in ends), *((-np.inf,) * FOLDS for _ in validate))
    holds = bool(validate) or split < 1.0
    return Run(every, edges, measured, scene, cutoff, float(f"{slip:.3g}"), motors, holds)


class First(NamedTuple):
    """What a first fit tells.

    Attributes:
        motors: that count; coupled: what those of several joints leave of the squares.
        values: by column; sigma: (joints,) of residuals [N m].
        faults: of the logs, for which nothing is written; caveats: of how gravity points, a line.
    """

    run: Run
    motors: list[Motor]
    coupled: dict[str, float]
    values: dict[str, float]
    sigma: Floats
    faults: list[str]
    caveats: list[str]


def first_fit(run: Run) -> First:
    names = run.model.rates
    given = {*names, *(motor.name for motor in run.scene.coupled)}
    slow = max(RESTS, 2.0 * run.slip_speed)
    motors = [
        each
        for name, each in run.directions.items()
        if (names.index(name) in run.measured if name in names else name in given or each.scale > slow)
    ]
    bare = [replace(motor, stribeck=()) for motor in motors]
    regressor = RegressorColumns(run.model, run.scene, run.measured, bare, run.slip_speed)
    fitted_logs = [log for log, edges in zip(run.logs, run.edges, strict=True) if edges[-1] > log.start]
    raw = Raw(fitted_logs, run.cutoff, regressor, [edges[-1] for edges in run.edges if np.isfinite(edges[-1])])
    plain, _ = run.gathered(regressor)
    joints = [k for k, motor in enumerate(motors) if motor.name in given]
    first = Structure(regressor, dict.fromkeys(joints, PLAIN))
    check_rows(plain, first, run.logs, run.cutoff, run.holds)
    late = raw.delays()
    if late.any():  # a delay counts if it leaves much less of its joint's torque also where all joints are fitted
        _, before = fitted(plain, range(FOLDS), first)
        _, after = fitted(run.delayed(late).gathered(regressor)[0], range(FOLDS), first)
        late[list(run.measured)] *= after**2 < CLEAR * before**2
        run = run.delayed(late)
        plain, _ = run.gathered(regressor)
    channels, measured = [triangle.R for triangle in plain.channels], [names[j] for j in run.measured]
    faults = told(channels).words(measured)
    ratios = {motor.name: part for motor, part in coupled(plain, range(FOLDS), first)}
    chosen = [k for k, motor in enumerate(motors) if k in joints or motor.name in ratios]
    second = Structure(regressor, dict.fromkeys(chosen, PLAIN))
    theta, sigma = fitted(plain, range(FOLDS), second)
    faults = faults or raw.misread(second, sigma)
    caveats = [] if faults else raw.leaning(second, theta, sigma, run.scene)
    values = dict(zip(regressor.names, (second.shape @ theta).tolist(), strict=True))
    units = [
        caveat.text if len(run.logs) == 1 else f"{log.path}: {caveat.text}"
        for log in run.logs
        for caveat in log.caveats
        if isinstance(caveat, WrongUnits)
    ]
    faults = [*units, *faults, *magnitudes(channels, measured)]
    return First(run, [motors[k] for k in chosen], ratios, values, sigma, faults, caveats)


def weighted_rows(run: Run, first: First) -> tuple[Gathered, Gathered, Moments]:
    """Return factors of all columns, plain and with outliers weighing less, and what tells how rows are correlated."""
    motors, values = first.motors, first.values
    shared = {
        int(j) for motor in motors for j in np.flatnonzero(motor.direction) if np.count_nonzero(motor.direction) > 1
    }
    alone = [motor.name in run.model.rates and run.model.rates.index(motor.name) not in shared for motor in motors]
    motors = [replace(motor, loaded=own) for motor, own in zip(motors, alone, strict=True)]
    bodies = np.array([value for name, value in values.items() if name.rpartition(".")[2] in INERTIAL])
    regressor = RegressorColumns(run.model, run.scene, run.measured, motors, run.slip_speed, bodies)
    guess = Guess(np.array([values.get(name, 0.0) for name in regressor.names]), first.sigma, Moments(regressor))
    return *run.gathered(regressor, guess), guess.moments


def repeated(
    run: Run, structure: Structure, theta: Floats, sigma: Floats
) -> tuple[Structure, Gathered, Gathered, Moments]:
    """Return the structure and what `weighted_rows` returns, linear near theta (p,): see `RegressorColumns.near`."""
    regressor = structure.regressor.near(theta[: len(structure.regressor.bodies)], structure.loads(theta))
    guess = Guess(structure.shape @ theta, sigma, Moments(regressor))
    return replace(structure, regressor=regressor), *run.gathered(regressor, guess), guess.moments


_JOINTS, _LEAST, _FOLDS = 30, 2, 2
"""At most; rows for each base parameter; folds with rows in them, so that what one leaves out is told by another."""


def check_size(model: Model) -> None:
    """Raise if a robot has so many joints that fits would take longer than minutes."""
    if model.n > _JOINTS:
        what = f"{model.name} has {model.n} joints, and identify fits at most {_JOINTS} together"
        raise InputError(f"{what}: time grows as their cube", remedy="describe and log its limbs one by one")


def check_files(logs: Sequence[Log], cutoff: float) -> None:
    """Raise if a log is given twice, of which standard errors would know nothing, or the filter passes everything."""
    seen: dict[str, str] = {}
    for log in logs:
        if log.sha256 in seen:
            what = f"has the same content as {seen[log.sha256]}"
            raise InputError(what, remedy="give each log once, and validate by another", file=log.path)
        seen[log.sha256] = log.path
        if log.noisy and POSITIONS * cutoff * (log.stop - log.start) < 2.0 * PERIODS:
            what = f"a filter of {cutoff:g} Hz leaves 0 rows of {log.stop - log.start:.4g} s"
            raise InputError(what, remedy="choose a higher --cutoff", file=log.path)
        if cutoff >= 0.5 / log.step:
            what = f"a cutoff of {cutoff:g} Hz is above half the sampling rate, {0.5 / log.step:.4g} Hz"
            raise InputError(what, remedy="choose a lower --cutoff", file=log.path)


def check_rows(plain: Gathered, structure: Structure, logs: Sequence[Log], cutoff: float, holds: bool) -> None:
    """Raise if the filter leaves too few rows for the parameters, or none to hold out."""
    folds = len(plain.parts) - 1
    rows = int(counts(plain, range(folds)).sum())
    R, _ = system(plain, range(folds), structure, np.ones(len(plain.regressor.measured)))
    rank = base_of(R, structure.names).rank if rows else len(structure.names)
    told = sum(bool(counts(plain, [fold]).any()) for fold in range(folds))
    if rows < _LEAST * rank or told < _FOLDS:
        what = f"a filter of {cutoff:.3g} Hz leaves {rows} rows to fit {rank} parameters to"
        raise InputError(what, remedy="give a longer log, a higher --cutoff or a larger --split", file=logs[0].path)
    if holds and not counts(plain, [folds]).all():
        what = f"a filter of {cutoff:.3g} Hz leaves nothing of what is held out"
        raise InputError(what, remedy="give a longer log, a higher --cutoff, or --split 1", file=logs[-1].path)
