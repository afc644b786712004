"""Parameters of bodies and motors that explain logs: what `robodyn identify` finds.

1. `log/log.py` reads logs; `log/rows.py` puts motion and torques through one filter.
2. `passes.py` goes over them: a first fit, what is wrong with the logs (`faults/`), rows of all columns.
3. `parameters/regressor_columns.py` has the columns and keeps their triangular factors.
4. `model_selection.py` chooses coupled motors, breakaway, friction under load, the strength of the prior.
5. `parameters/consistent.py` fits bodies that can exist, `parameters/base.py` the base parameters.
6. Here errors, intervals and warnings are told; `result.py` holds and writes what was found.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

import numpy as np

from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.dynamics.effects.motors import rotor_of
from robodyn.dynamics.regressor import INERTIAL
from robodyn.errors import InputError
from robodyn.identification.log.log import Log
from robodyn.identification.log.rows import kernel
from robodyn.identification.model_selection import (
    Structure,
    counts,
    covariance,
    fitted,
    least_squares,
    squares,
    strength,
    system,
    with_friction,
    with_possible_loads,
    without_one,
)
from robodyn.identification.parameters.base import base_of
from robodyn.identification.parameters.consistent import Prior, consistent_parameters, prior_of, pseudo_inertia
from robodyn.identification.parameters.regressor_columns import PARAMETERS, PLAIN, Gathered
from robodyn.identification.passes import FOLDS, RESTS, Run, begun, curves_along, first_fit, repeated, weighted_rows
from robodyn.identification.result import BaseFit, Errors, Identified, motor_fits, outcome
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats, unit_columns

_REPEATED = 3  # Gauss-Newton's steps where friction grows with load, which is not linear in the parameters
_COSTLY, _SMALL = 1.5, 2e-3
_FAR, _TOLD = 2.0, 0.05  # times the fitted error of a joint, and of its torque: held-out errors that are told
_GAIN = (
    "torques alone cannot tell a gain of all their sensors, or of torque constants, from masses: weigh a body, or log "
    "a payload that is known"
)
_RANK, _ALIKE = 1e-8, 0.35
_ABSORBED = 3.0
"""Times what is left: a fit hides a part of what the model has not in its parameters, where it comes back on another
motion. Chosen on one half of the logs of which the documentation has the other."""
_CHANCE, _LEAST, _LOUD = 1.0, 1e-3, 2.0
"""Standard deviations by which noise alone is larger in one part of a log than in another; of a joint's torque: no
model is nearer to a robot; times the noise: what is told."""


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
    run = begun(logs, validate, scene, 1.0 if validate else split, cutoff)
    on_progress("comparing motors")
    first = first_fit(run)
    run = first.run
    on_progress("fitting")
    plain, weighted, moments = weighted_rows(run, first)
    regressor, folds = plain.regressor, range(FOLDS)
    structure = with_friction(weighted, folds, Structure(regressor, dict.fromkeys(range(len(first.motors)), PLAIN)))
    loose, sigma = fitted(weighted, folds, structure)
    for _ in range(_REPEATED if structure.loaded else 0):
        structure, plain, weighted, moments = repeated(run, structure, loose, sigma)
        structure = with_possible_loads(structure, fitted(weighted, folds, structure)[0])
        loose, sigma = fitted(weighted, folds, structure)
    on_progress("choosing the strength of the prior")
    prior = _prior(run, structure, shapes)
    chosen = strength(weighted, plain, folds, structure, prior, sigma)
    R, z = system(weighted, folds, structure, sigma)
    fit = consistent_parameters(R, z, prior, chosen)
    theta = fit.theta
    if not np.isfinite(fit.gap):
        raise InputError("no consistent parameters were found near the description", remedy="mend its inertials first")
    base = base_of(R, structure.names)
    C, alike = covariance(moments, structure, base, R, sigma), _like_weight(structure, R)
    if structure.loaded:
        structure, plain, weighted, _ = repeated(run, structure, theta, sigma)
    deviation, lacking = _misfit(run, structure, plain, weighted, theta, sigma)
    train, rates = [*range(FOLDS)], [run.model.rates[j] for j in run.measured]
    holds = run.holds and bool(plain.squares[FOLDS].any())

    def off(folds: list[int], values: Floats) -> Floats:
        return np.asarray(sum(squares(plain, fold, structure, values) for fold in folds))

    def errors(folds: list[int]) -> list[Errors]:
        """Of the consistent parameters, of least squares, and of the description."""
        of = plain.squares[folds].sum(axis=0)
        sums = off(folds, theta), off(folds, loose), plain.described[folds].sum(axis=0)
        return [
            Errors(_ratio(each.sum(), of.sum()), dict(zip(rates, map(_ratio, each, of), strict=True))) for each in sums
        ]

    of_train, held = errors(train), errors([FOLDS]) if holds else [None] * 3
    alone, of = _told_by_description(structure, theta), [FOLDS] if holds else train
    motors = motor_fits(structure, theta)
    delays = {run.model.rates[j]: float(run.logs[0].delays[j]) for j in run.measured}
    late = ", ".join(f"{1e3 * delay:.3g} ms ({name})" for name, delay in delays.items() if delay)
    names, described, calibrated, after = outcome(run.model, run.scene, structure, theta, run.slip_speed)
    shown = [body for body in prior.bodies if base.matrix[:, body.columns].any()]
    return Identified(
        model=run.model,
        scene=after,
        names=names,
        described=described,
        theta=calibrated,
        base=BaseFit(base, base.estimate(R, z).values, C, base.values(theta), base.values(prior.described)),
        motors=motors,
        coupled=first.coupled,
        train=of_train[0],
        held_out=held[0],
        bound_train=of_train[1],
        bound_held_out=held[1],
        original_train=of_train[2],
        original_held_out=held[2],
        discrepancy=dict(zip(rates, deviation.tolist(), strict=True)),
        delays=delays,
        alone=_ratio(float(off(of, alone).sum()), float(plain.squares[of].sum())),
        strength=chosen,
        cutoff=run.cutoff,
        slip_speed=run.slip_speed,
        consistent=all(np.linalg.eigvalsh(pseudo_inertia(theta[body.columns])).min() > 0.0 for body in shown),
        unseen=tuple(body.name for body in prior.bodies if body not in shown),
        rows=int(counts(plain, range(FOLDS + 1)).sum()),
        samples=sum(log.samples for log in run.logs),
        duration=sum(log.stop - log.start for log in run.logs),
        hashes={log.path: log.sha256 for log in run.logs},
        faults=tuple(first.faults),
        curves=partial(curves_along, run, structure, theta),
        warnings=(
            *first.faults,
            *([f"torques are logged late beside positions, which is taken out: {late}"] if late else ()),
            *first.caveats,
            *(_worse(of_train[0], held[0], held[2]) if held[0] and held[2] else ()),
            *lacking,
            *alike,
            *_assumed(run, first.coupled, *of_train[:2]),
            *(() if held[0] else ("nothing is held out: the errors are of what was fitted",)),
            *prior.notes,
            *(
                f"{name}: {beyond:.3g} N m of its offset are no friction, and in no file: the torque sensor's?"
                for name, each in motors.items()
                if (beyond := abs(each.offset) - each.coulomb) > 0.0
            ),
            _GAIN,
        ),
    )


def _prior(run: Run, structure: Structure, shapes: bool) -> Prior:
    values = dict(zip(structure.regressor.bodies, structure.regressor.described.tolist(), strict=True))
    motors = [(motor.name, motor.friction, motor.reflected) for motor in run.scene.coupled]
    for _, joint, friction in joints_with_friction(run.model, run.scene):
        rotor, gear = rotor_of(joint, run.scene)
        motors.append((joint.name, friction, rotor * gear * gear))
    for motor, friction, reflected in motors:
        coulomb, offset = (friction.forward - friction.backward) / 2, (friction.forward + friction.backward) / 2
        own = (friction.viscous, coulomb, offset, friction.dry, reflected, friction.load)
        values |= {f"{motor}.{kind}": value for kind, value in zip(PARAMETERS, own, strict=True)}
    theta = np.array([values.get(name, 0.0) for name in structure.names])
    return prior_of(run.model, structure.names, theta, shapes=shapes)


def _ratio(off: float, of: float) -> float:
    return float(np.sqrt(off / of)) if of > 0.0 else 0.0


def _worse(fitted: Errors, held: Errors, described: Errors) -> Iterator[str]:
    """Yield a line for each joint that is held out much worse than it was fitted, or than the description has it."""
    for name, error in held.joints.items():
        before, given = fitted.joints[name], described.joints[name]
        what = f"{name}: held-out torques are off by {100 * error:.2g} %"
        if error > given:
            yield f"{what}, more than by the description, {100 * given:.2g} %"
        elif error > _FAR * before and error > _TOLD:
            yield f"{what}, fitted ones by {100 * before:.2g} %"


def _told_by_description(structure: Structure, theta: Floats) -> Floats:
    """Return (p,) what a description can say: of bodies, and of joints viscous and Coulomb friction."""
    found = dict(zip(structure.names, theta.tolist(), strict=True))
    for name in structure.names[len(structure.regressor.bodies) :]:
        motor, _, kind = name.rpartition(".")
        if kind == "stribeck":
            found[name] = found[f"{motor}.coulomb"]
        elif motor not in structure.regressor.model.rates or kind not in ("viscous", "coulomb"):
            found[name] = 0.0
    return np.array([found[name] for name in structure.names])


def _like_weight(structure: Structure, R: Floats) -> list[str]:
    """Return a line if constant torques, columns of weighted rows R (k, p), look much like what bodies weigh."""
    kinds = [name.rpartition(".")[2] for name in structure.names]
    bodies = R[:, [k for k, kind in enumerate(kinds) if kind in INERTIAL]]
    axes, size, _ = np.linalg.svd(unit_columns(bodies)[0], full_matrices=False)
    axes = axes[:, size > _RANK * size.max(initial=0.0)]
    alike = []
    for name, kind, column in zip(structure.names, kinds, R.T, strict=True):
        if kind == "offset" and np.linalg.norm(column - axes @ (axes.T @ column)) < _ALIKE * np.linalg.norm(column):
            alike.append(name.removesuffix(".offset"))
    if not alike:
        return []
    what = f"constant torques of {', '.join(alike)} look much like weights in this motion"
    return [f"{what}: an offset of the sensor may be taken for mass"]


def _assumed(run: Run, ratios: Mapping[str, float], fitted: Errors, bound: Errors) -> Iterator[str]:
    """Yield what was assumed and what cannot be told, a line each."""
    yield from (f"{log.path}: {note}" for log in run.logs for note in log.notes)
    still = {name for log in run.logs for name in log.held}
    for name in run.model.rates:
        if run.directions[name].scale <= RESTS and name not in still:
            yield f"joint {name} rests: nothing is shown of its friction"
    if still:
        yield "no interval counts what bodies and friction are of joints that the log has not"
    for name, part in ratios.items():
        yield f"a motor that turns with {name} explains {100.0 * (1.0 - part):.0f} % of what is left of both joints"
    if fitted.relative_error > _COSTLY * bound.relative_error + _SMALL:
        yield (
            f"least squares fit {100.0 * bound.relative_error:.2f}%, bodies and motors that can exist no better than "
            f"{100.0 * fitted.relative_error:.2f}%: an effect is missing, or a torque has the wrong sign or joint"
        )


def _misfit(
    run: Run, structure: Structure, plain: Gathered, weighted: Gathered, theta: Floats, sigma: Floats
) -> tuple[Floats, list[str]]:
    """Return (joints,) the standard error of predicted torques beside that of the parameters [N m], and a line if
    something is missing in the model. Each part of the logs where the other parts were fitted, and what is held out,
    stand for other motions: their errors have in them how residuals go along with the motion, and how they differ
    between the parts."""
    parts = [least_squares(R, z) for R, z in without_one(weighted, range(FOLDS), structure, sigma)]
    off, least = [], np.zeros(len(sigma))
    passed = [np.linalg.norm(kernel(run.cutoff, log.step)) * log.loud for log in run.logs]
    noise = np.min(passed, axis=0)[list(run.measured)]
    for fold, values in enumerate([*parts, theta]):
        rows = counts(plain, [fold])
        if rows.all():
            off.append(squares(plain, fold, structure, values) / rows)
            least = np.maximum(least, noise * (1.0 + _CHANCE / np.sqrt(2.0 * rows)))
    left = np.sqrt(np.max(off, axis=0))
    size = np.sqrt(plain.squares.sum(axis=0) / np.maximum(counts(plain, range(FOLDS + 1)), 1.0))
    deviation = np.hypot(_ABSORBED * np.sqrt(np.maximum(left**2 - least**2, 0.0)), _LEAST * size)
    loud = [
        f"{run.model.rates[run.measured[k]]} +- {deviation[k]:.2g} N m" for k in np.flatnonzero(left > _LOUD * noise)
    ]
    if not loud:
        return deviation, []
    what = "the model lacks something (friction that changes or sticks, joints that bend, a load)"
    return deviation, [f"more than noise is left of some torques: {what}; intervals are wider by {', '.join(loud)}"]
