"""Logs -> a description that explains them: the door to this package."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robodyn.dynamics.effects.gyroscopic_moment import spins
from robodyn.dynamics.effects.rotor_inertia import rotor_of
from robodyn.dynamics.effects.viscous_friction import joints_with_friction
from robodyn.errors import InputError
from robodyn.identify.atoms import Atoms
from robodyn.identify.base import base_of
from robodyn.identify.choose import (
    coupled,
    coupled_motors,
    joint_motors,
    scene_motors,
    strength,
    with_speeds,
    with_stribeck,
)
from robodyn.identify.consistent import consistent_parameters
from robodyn.identify.correlated import covariance
from robodyn.identify.filters import kernel, rates
from robodyn.identify.gather import Gathered, Guess, gather
from robodyn.identify.gross_faults import told
from robodyn.identify.identified import BaseFit, Errors, Identified
from robodyn.identify.log import Log
from robodyn.identify.moments import Moments
from robodyn.identify.motors import PARAMETERS, Motor
from robodyn.identify.outcome import motor_fits, outcome
from robodyn.identify.prior import Prior, PriorBody, prior_of
from robodyn.identify.pseudo_inertia import pseudo_inertia
from robodyn.identify.refusals import check_files, check_rows
from robodyn.identify.rows import POSITIONS, states
from robodyn.identify.structure import Structure, counts, fitted, squares, system
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_load
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats

FOLDS = 5
_COSTLY, _ROUNDING = 1.5, 1e-6
_NOISE = 4.0
_SLOW = 1e-5
"""Of the largest speed: below it, derived speeds do not tell the sign of friction."""
_RESTS = 1e-6
"""rad/s (m/s): a joint that is never faster rests."""


def identify(
    logs: Sequence[Log],
    scene: Scene = DEFAULT,
    *,
    validate: Sequence[Log] = (),
    split: float = 0.7,
    cutoff: float | None = None,
    shapes: bool = True,
    on_progress: Callable[[str], None] = lambda _: None,
) -> Identified:
    """Return the parameters of bodies and motors that explain measured torques, physically consistent.

    Rows of the regressor and torques pass the same zero-phase filter (`rows.filtered`), in blocks, and are kept as
    triangular factors by joint and fold. Joints weigh by their residuals; outliers as Huber has them. Stribeck's
    speeds, coupled motors and the strength of the prior are chosen by cross-validation over `FOLDS` parts of it.

    Args:
        logs: of `read_log`, of one model.
        validate: logs that are held out; without any, what comes after the part `split` of each log is.
        cutoff: of the filter [Hz]; None: the lowest of the logs' own.
        shapes: whether bodies lie within ellipsoids around their shapes.
        on_progress: called with a line at each stage.

    Raises:
        InputError: no joint moves, the logs measure different joints, leave too few rows, or one is given twice; or the
            scene says the axes of rotors.
    """
    refuse_load(scene)
    run = _begun(logs, validate, scene, 1.0 if validate else split, cutoff)
    on_progress("comparing motors")
    motors, ratios, guess, faults = _motors(run)
    on_progress("fitting")
    plain, weighted, moments = _weighted(run, motors, guess)
    atoms, folds = plain.atoms, range(FOLDS)
    structure = with_stribeck(weighted, folds, Structure(atoms, dict.fromkeys(range(len(motors)))))
    loose, sigma = fitted(weighted, folds, structure)
    on_progress("choosing the strength of the prior")
    prior = _prior(run, structure, shapes)
    chosen = strength(weighted, plain, folds, structure, prior, sigma).value
    R, z = system(weighted, folds, structure, sigma)
    fit = consistent_parameters(R, z, prior, chosen)
    theta = fit.theta
    if not np.isfinite(fit.gap):
        raise InputError("no consistent parameters were found near the description", remedy="mend its inertials first")
    base = _base(structure, R, z, moments, sigma, theta)
    return _result(run, structure, plain, (theta, loose), base, prior, chosen, ratios, faults)


@dataclass(frozen=True, eq=False)
class _Run:
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

    def gathered(self, atoms: Atoms, guess: Guess | None = None) -> tuple[Gathered, Gathered]:
        """Return the factors of one pass over all logs, and the weighted ones."""
        plain, weighted = Gathered(FOLDS + 1, atoms), Gathered(FOLDS + 1, atoms)
        for log, edges in zip(self.logs, self.edges, strict=True):
            gather(log, self.cutoff, atoms, edges, plain, weighted, guess)
        plain.finish()
        weighted.finish()
        return plain, weighted


def _begun(logs: Sequence[Log], validate: Sequence[Log], scene: Scene, split: float, cutoff: float | None) -> _Run:
    """Go through the logs once for the largest speeds."""
    every = (*logs, *validate)
    model = every[0].model
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
            speeds = np.einsum("kj,mj->km", samples.qd, np.stack([motor.direction for motor in candidates]))
            top = np.maximum(top, np.abs(speeds).max(axis=0, initial=0.0))
        if log.derived and not scene.slip_speed:
            slip = max(slip, _SLOW * float(top[: model.n].max()), _NOISE * _speed_noise(log, cutoff))
        largest = np.maximum(largest, top)
    if largest[: model.n].max() <= max(_RESTS, 2.0 * slip if slip != scene.slip_speed else 0.0):
        what = "no joint moves: the log shows nothing of masses and friction"
        raise InputError(what, remedy="log an exciting motion, see robodyn excite", file=every[0].path)
    motors = {each.name: with_speeds(each, float(top), slip) for each, top in zip(candidates, largest, strict=True)}
    ends = [log.start + (log.stop - log.start) * split * np.arange(1, FOLDS + 1) / FOLDS for log in logs]
    edges = (*(tuple(each.tolist()) for each in ends), *((-np.inf,) * FOLDS for _ in validate))
    holds = bool(validate) or split < 1.0
    return _Run(every, edges, measured, scene, cutoff, float(f"{slip:.3g}"), motors, holds)


def _speed_noise(log: Log, cutoff: float) -> float:
    """Return the standard deviation of the speeds of smoothed positions."""
    if not log.noisy:
        return 0.0
    _, first, _ = rates(kernel(min(POSITIONS * cutoff, 0.4 / log.step), log.step), log.step)
    return log.noise * float(np.sqrt((first**2).sum()))


def _motors(run: _Run) -> tuple[list[Motor], dict[str, float], tuple[dict[str, float], Floats], list[str]]:
    """Return the motors that count, what coupled ones leave, a first fit (atom -> torque), and gross faults."""
    names = run.model.rates
    given = {*names, *(motor.name for motor in run.scene.coupled)}
    slow = max(_RESTS, 2.0 * run.slip_speed)
    motors = [
        each
        for name, each in run.directions.items()
        if (names.index(name) in run.measured if name in names else name in given or each.scale > slow)
    ]
    bare = [replace(motor, stribeck=()) for motor in motors]
    atoms = Atoms(run.model, run.scene, run.measured, bare, run.slip_speed)
    plain, _ = run.gathered(atoms)
    joints = [k for k, motor in enumerate(motors) if motor.name in given]
    first = Structure(atoms, dict.fromkeys(joints))
    check_rows(plain, first, run.logs, run.cutoff, run.holds)
    faults = told([triangle.R for triangle in plain.channels]).words([names[j] for j in run.measured])
    ratios = {motor.name: part for motor, part in coupled(plain, range(FOLDS), first)}
    chosen = [k for k, motor in enumerate(motors) if k in joints or motor.name in ratios]
    second = Structure(atoms, dict.fromkeys(chosen))
    theta, sigma = fitted(plain, range(FOLDS), second)
    values = dict(zip(atoms.names, (second.shape @ theta).tolist(), strict=True))
    return [motors[k] for k in chosen], ratios, (values, sigma), faults


def _weighted(
    run: _Run, motors: list[Motor], first: tuple[dict[str, float], Floats]
) -> tuple[Gathered, Gathered, Moments]:
    """Return factors of all columns, plain and with outliers weighing less, and what tells how rows are correlated."""
    values, sigma = first
    atoms = Atoms(run.model, run.scene, run.measured, motors, run.slip_speed)
    guess = Guess(atoms, np.array([values.get(name, 0.0) for name in atoms.names]), sigma)
    return *run.gathered(atoms, guess), guess.moments


def _prior(run: _Run, structure: Structure, shapes: bool) -> Prior:
    """Return the prior of the structure's parameters: what the description and the scene say."""
    values = dict(zip(structure.atoms.bodies, structure.atoms.described.tolist(), strict=True))
    motors = [(motor.name, motor.friction, motor.reflected) for motor in run.scene.coupled]
    for _, joint, friction in joints_with_friction(run.model, run.scene):
        rotor, gear = rotor_of(joint, run.scene)
        motors.append((joint.name, friction, rotor * gear * gear))
    for motor, friction, reflected in motors:
        coulomb, offset = (friction.forward - friction.backward) / 2, (friction.forward + friction.backward) / 2
        own = (friction.viscous, coulomb, offset, friction.dry, reflected)
        values |= {f"{motor}.{kind}": value for kind, value in zip(PARAMETERS, own, strict=True)}
    theta = np.array([values.get(name, 0.0) for name in structure.names])
    return prior_of(run.model, structure.names, theta, shapes=shapes)


def _base(structure: Structure, R: Floats, z: Floats, moments: Moments, sigma: Floats, theta: Floats) -> BaseFit:
    base = base_of(R, structure.names)
    C = covariance(moments, structure, base, R, sigma)
    return BaseFit(base, base.estimate(R, z).values, np.sqrt(np.einsum("ii->i", C)), base.values(theta), C)


def _errors(run: _Run, off: Floats, of: Floats) -> Errors:
    """Return relative errors of sums of squares by joint."""
    joints = {
        run.model.rates[j]: _ratio(*pair) for j, *pair in zip(run.measured, off.tolist(), of.tolist(), strict=True)
    }
    return Errors(_ratio(float(off.sum()), float(of.sum())), joints)


def _ratio(off: float, of: float) -> float:
    return float(np.sqrt(off / of)) if of > 0.0 else 0.0


def _result(
    run: _Run,
    structure: Structure,
    plain: Gathered,
    fits: tuple[Floats, Floats],
    base: BaseFit,
    prior: Prior,
    chosen: float,
    ratios: dict[str, float],
    faults: list[str],
) -> Identified:
    theta, _ = fits
    train = list(range(FOLDS))

    def errors(folds: list[int]) -> list[Errors]:
        of = plain.squares[folds].sum(axis=0)
        sums = [sum(squares(plain, fold, structure, each) for fold in folds) for each in fits]
        return [_errors(run, np.asarray(off), of) for off in (*sums, plain.described[folds].sum(axis=0))]

    fitted_errors = errors(train)
    held = errors([FOLDS]) if run.holds and plain.squares[FOLDS].any() else [None] * 3
    found = outcome(run.model, run.scene, structure, theta, run.slip_speed)
    return Identified(
        run.model,
        found.scene,
        found.names,
        found.described,
        found.theta,
        base,
        motor_fits(structure, theta),
        ratios,
        fitted_errors[0],
        held[0],
        fitted_errors[1],
        held[1],
        fitted_errors[2],
        held[2],
        chosen,
        run.cutoff,
        run.slip_speed,
        _possible([body for body in prior.bodies if base.base.matrix[:, body.columns].any()], theta),
        tuple(body.name for body in prior.bodies if not base.base.matrix[:, body.columns].any()),
        int(counts(plain, range(FOLDS + 1)).sum()),
        sum(log.samples for log in run.logs),
        sum(log.stop - log.start for log in run.logs),
        {log.path: log.sha256 for log in run.logs},
        tuple(faults),
        (*faults, *_warnings(run, prior, ratios, (fitted_errors[0], fitted_errors[1]), held[0] is not None)),
    )


def _possible(bodies: Sequence[PriorBody], theta: Floats) -> bool:
    """Return whether the pseudo-inertia of every body that is shown is positive definite."""
    return all(np.linalg.eigvalsh(pseudo_inertia(theta[body.columns])).min() > 0.0 for body in bodies)


def _warnings(
    run: _Run, prior: Prior, ratios: dict[str, float], off: tuple[Errors, Errors], held: bool
) -> tuple[str, ...]:
    """Return what was assumed and what cannot be told, a line each."""
    lines = [f"{log.path}: {note}" for log in run.logs for note in log.notes]
    names = run.model.rates
    lines += [f"joint {name} has no measured torque" for j, name in enumerate(names) if j not in run.measured]
    resting = [name for name in names if run.directions[name].scale <= _RESTS]
    lines += [f"joint {name} rests: nothing is shown of its friction" for name in resting]
    for name, part in ratios.items():
        lines.append(
            f"a motor that turns with {name} explains {100.0 * (1.0 - part):.0f} % of what is left of both joints"
        )
    if off[0].relative_error > _COSTLY * off[1].relative_error + _ROUNDING:
        lines.append(
            f"least squares fit {100.0 * off[1].relative_error:.2f}%, bodies and motors that can exist no better than "
            f"{100.0 * off[0].relative_error:.2f}%: an effect is missing, or a torque has the wrong sign or joint"
        )
    if not held:
        lines.append("nothing is held out: the errors are of what was fitted")
    return (*lines, *prior.notes)
