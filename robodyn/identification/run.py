"""Passes over the logs that are fitted and those that are held out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.motors import spins
from robodyn.dynamics.regressor import INERTIAL
from robodyn.errors import InputError
from robodyn.identification.atoms import Atoms
from robodyn.identification.choose import coupled, coupled_motors, joint_motors, scene_motors, with_speeds
from robodyn.identification.faults.channels import magnitudes, told
from robodyn.identification.filters import kernel, rates
from robodyn.identification.gather import Gathered, Guess, gather
from robodyn.identification.installation import CLEAR, Raw
from robodyn.identification.log import Log
from robodyn.identification.misread_positions import misread
from robodyn.identification.moments import Moments
from robodyn.identification.motors import PLAIN, Motor
from robodyn.identification.refusals import check_files, check_rows, check_size
from robodyn.identification.rows import POSITIONS, states
from robodyn.identification.structure import Structure, fitted
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.caveats import WrongUnits
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

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

    @property
    def fitted(self) -> tuple[Log, ...]:
        """The logs of which something is fitted."""
        return tuple(log for log, edges in zip(self.logs, self.edges, strict=True) if edges[-1] > log.start)

    def delayed(self, delays: Floats) -> Run:
        """Return the run through logs whose torques are (n,) late [s]."""
        return replace(self, logs=tuple(replace(log, delays=delays) for log in self.logs))

    def gathered(self, atoms: Atoms, guess: Guess | None = None) -> tuple[Gathered, Gathered]:
        """Return the factors of one pass over all logs, and the weighted ones."""
        plain, weighted = Gathered(FOLDS + 1, atoms), Gathered(FOLDS + 1, atoms)
        for log, edges in zip(self.logs, self.edges, strict=True):
            gather(log, self.cutoff, atoms, edges, plain, weighted, guess)
        plain.finish()
        weighted.finish()
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
    candidates = [*joint_motors(model, np.zeros(model.n)), *known, *coupled_motors(model, measured, known)]
    largest = np.zeros(len(candidates))
    slip = scene.slip_speed
    for log in every:
        top = np.zeros(len(candidates))
        for samples in states(log, cutoff):
            speeds = einsum("kj,mj->km", samples.qd, np.stack([motor.direction for motor in candidates]))
            top = np.maximum(top, np.abs(speeds).max(axis=0, initial=0.0))
        if log.derived and not scene.slip_speed:
            slip = max(slip, _SLOW * float(top[: model.n].max()), _NOISE * _speed_noise(log, cutoff))
        largest = np.maximum(largest, top)
    if largest[: model.n].max() <= max(RESTS, 2.0 * slip if slip != scene.slip_speed else 0.0):
        what = "; ".join(
            (
                "no joint moves: the log shows nothing of masses and friction",
                *(caveat.text for caveat in every[0].caveats),
            )
        )
        raise InputError(what, remedy="log an exciting motion, see robodyn excite", file=every[0].path)
    motors = {each.name: with_speeds(each, float(top), slip) for each, top in zip(candidates, largest, strict=True)}
    ends = [log.start + (log.stop - log.start) * split * np.arange(1, FOLDS + 1) / FOLDS for log in logs]
    edges = (*(tuple(each.tolist()) for each in ends), *((-np.inf,) * FOLDS for _ in validate))
    holds = bool(validate) or split < 1.0
    return Run(every, edges, measured, scene, cutoff, float(f"{slip:.3g}"), motors, holds)


def _speed_noise(log: Log, cutoff: float) -> float:
    """Return the standard deviation of the speeds of smoothed positions."""
    if not log.noisy:
        return 0.0
    _, first, _ = rates(kernel(min(POSITIONS * cutoff, 0.4 / log.step), log.step), log.step)
    return log.noise * float(np.sqrt((first**2).sum()))


class First(NamedTuple):
    """What a first fit tells.

    Attributes:
        motors: that count; coupled: what those of several joints leave of the squares.
        values: by atom; sigma: (joints,) of residuals [N m].
        faults: of the logs, for which nothing is written.
        caveats: of how gravity points, a line.
        run: through the logs, with torques where they belong.
    """

    run: Run
    motors: list[Motor]
    coupled: dict[str, float]
    values: dict[str, float]
    sigma: Floats
    faults: list[str]
    caveats: list[str]


def first_fit(run: Run) -> First:
    """Return what a fit with plain motors tells."""
    names = run.model.rates
    given = {*names, *(motor.name for motor in run.scene.coupled)}
    slow = max(RESTS, 2.0 * run.slip_speed)
    motors = [
        each
        for name, each in run.directions.items()
        if (names.index(name) in run.measured if name in names else name in given or each.scale > slow)
    ]
    bare = [replace(motor, stribeck=()) for motor in motors]
    atoms = Atoms(run.model, run.scene, run.measured, bare, run.slip_speed)
    raw = Raw(run.fitted, run.cutoff, atoms, [edges[-1] for edges in run.edges if np.isfinite(edges[-1])])
    plain, _ = run.gathered(atoms)
    joints = [k for k, motor in enumerate(motors) if motor.name in given]
    first = Structure(atoms, dict.fromkeys(joints, PLAIN))
    check_rows(plain, first, run.logs, run.cutoff, run.holds)
    run, plain = _in_time(run, plain, first, raw)
    channels, measured = [triangle.R for triangle in plain.channels], [names[j] for j in run.measured]
    faults = told(channels).words(measured)
    ratios = {motor.name: part for motor, part in coupled(plain, range(FOLDS), first)}
    chosen = [k for k, motor in enumerate(motors) if k in joints or motor.name in ratios]
    second = Structure(atoms, dict.fromkeys(chosen, PLAIN))
    theta, sigma = fitted(plain, range(FOLDS), second)
    faults = faults or misread(run.fitted, run.cutoff, second, sigma)
    caveats = [] if faults else raw.leaning(second, theta, sigma, run.scene)
    values = dict(zip(atoms.names, (second.shape @ theta).tolist(), strict=True))
    units = [
        caveat.text if len(run.logs) == 1 else f"{log.path}: {caveat.text}"
        for log in run.logs
        for caveat in log.caveats
        if isinstance(caveat, WrongUnits)
    ]
    faults = [*units, *faults, *magnitudes(channels, measured)]
    return First(run, [motors[k] for k in chosen], ratios, values, sigma, faults, caveats)


def _in_time(run: Run, plain: Gathered, structure: Structure, raw: Raw) -> tuple[Run, Gathered]:
    """Return the run with torques that are logged late where they belong, and its factors.

    A delay counts if it leaves much less of its joint's torque also where all joints are fitted together.
    """
    found = raw.delays()
    if not found.any():
        return run, plain
    _, before = fitted(plain, range(FOLDS), structure)
    _, after = fitted(run.delayed(found).gathered(structure.atoms)[0], range(FOLDS), structure)
    found[list(run.measured)] *= after**2 < CLEAR * before**2
    run = run.delayed(found)
    return run, run.gathered(structure.atoms)[0]


def weighted_rows(run: Run, first: First) -> tuple[Gathered, Gathered, Moments]:
    """Return factors of all columns, plain and with outliers weighing less, and what tells how rows are correlated."""
    motors, values = first.motors, first.values
    shared = {
        int(j) for motor in motors for j in np.flatnonzero(motor.direction) if np.count_nonzero(motor.direction) > 1
    }
    alone = [motor.name in run.model.rates and run.model.rates.index(motor.name) not in shared for motor in motors]
    motors = [replace(motor, loaded=own) for motor, own in zip(motors, alone, strict=True)]
    bodies = np.array([value for name, value in values.items() if name.rpartition(".")[2] in INERTIAL])
    atoms = Atoms(run.model, run.scene, run.measured, motors, run.slip_speed, bodies)
    guess = Guess(atoms, np.array([values.get(name, 0.0) for name in atoms.names]), first.sigma)
    return *run.gathered(atoms, guess), guess.moments


def repeated(
    run: Run, structure: Structure, theta: Floats, sigma: Floats
) -> tuple[Structure, Gathered, Gathered, Moments]:
    """Return the structure and what `weighted_rows` returns, linear near theta (p,): see `Atoms.near`."""
    found = dict(zip(structure.names, theta.tolist(), strict=True))
    loads = {k: found[f"{structure.atoms.motors[k].name}.load"] for k, shape in structure.shapes.items() if shape.load}
    atoms = structure.atoms.near(theta[: len(structure.atoms.bodies)], loads)
    guess = Guess(atoms, structure.shape @ theta, sigma)
    return replace(structure, atoms=atoms), *run.gathered(atoms, guess), guess.moments
