"""What was fitted, told: errors of what is fitted and held out, whether bodies can exist, warnings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.regressor import INERTIAL
from robodyn.identification.log.rows import kernel
from robodyn.identification.parameters.prior import Prior, pseudo_inertia
from robodyn.identification.parameters.qr_accumulation import Gathered
from robodyn.identification.parameters.structure import Structure, counts, least_squares, squares, without_one
from robodyn.identification.passes import FOLDS, RESTS, First, Run
from robodyn.identification.result import BaseFit, Errors, Identified, MotorFit, motor_fits, outcome
from robodyn.support.floats import Floats

_COSTLY, _SMALL = 1.5, 2e-3
_FAR, _TOLD = 2.0, 0.05
"""Times the fitted error of a joint, and of its torque: held-out errors that are told."""
_GAIN = (
    "torques alone cannot tell a gain of all their sensors, or of torque constants, from masses: weigh a body, or log "
    "a payload that is known"
)
_RANK, _ALIKE = 1e-8, 0.35


def _errors(run: Run, off: Floats, of: Floats) -> Errors:
    """Relative errors of sums of squares by joint."""
    rates = [run.model.rates[j] for j in run.measured]
    return Errors(_ratio(off.sum(), of.sum()), dict(zip(rates, map(_ratio, off, of), strict=True)))


def _ratio(off: float, of: float) -> float:
    return float(np.sqrt(off / of)) if of > 0.0 else 0.0


def identified(
    run: Run,
    structure: Structure,
    plain: Gathered,
    fits: tuple[Floats, Floats],
    base: BaseFit,
    prior: Prior,
    chosen: float,
    first: First,
    left: Misfit,
    alike: list[str],
) -> Identified:
    """Return what was found.

    Args:
        fits: the parameters of the structure: those of bodies that can exist, and by least squares.
        chosen: strength of the prior. alike: see `like_weight`.
    """
    theta, _ = fits

    def off(folds: list[int], values: Floats) -> Floats:
        return np.asarray(sum(squares(plain, fold, structure, values) for fold in folds))

    def errors(folds: list[int]) -> list[Errors]:
        sums = (*(off(folds, each) for each in fits), plain.described[folds].sum(axis=0))
        return [_errors(run, each, plain.squares[folds].sum(axis=0)) for each in sums]

    train = [*range(FOLDS)]
    holds = run.holds and bool(plain.squares[FOLDS].any())
    fitted_errors, held = errors(train), errors([FOLDS]) if holds else [None] * 3
    alone, of = _told_by_description(structure, theta), [FOLDS] if holds else train
    motors = motor_fits(structure, theta)
    found = outcome(run.model, run.scene, structure, theta, run.slip_speed)
    shown = [body for body in prior.bodies if base.base.matrix[:, body.columns].any()]
    return Identified(
        model=run.model,
        scene=found.scene,
        names=found.names,
        described=found.described,
        theta=found.theta,
        base=base,
        motors=motors,
        coupled=first.coupled,
        train=fitted_errors[0],
        held_out=held[0],
        bound_train=fitted_errors[1],
        bound_held_out=held[1],
        original_train=fitted_errors[2],
        original_held_out=held[2],
        discrepancy={run.model.rates[j]: float(each) for j, each in zip(run.measured, left.deviation, strict=True)},
        delays={run.model.rates[j]: float(run.logs[0].delays[j]) for j in run.measured},
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
        warnings=(
            *first.faults,
            *_late(run),
            *first.caveats,
            *(_worse(fitted_errors[0], held[0], errors([FOLDS])[2]) if held[0] else ()),
            *left.words([run.model.rates[j] for j in run.measured]),
            *alike,
            *_assumed(run, first.coupled, *fitted_errors[:2]),
            *(() if held[0] else ("nothing is held out: the errors are of what was fitted",)),
            *prior.notes,
            *_offsets(motors),
            _GAIN,
        ),
    )


def _late(run: Run) -> Iterator[str]:
    """Yield a line if torques are late, and by how much."""
    delays = run.logs[0].delays
    late = [f"{1e3 * delays[j]:.3g} ms ({run.model.rates[j]})" for j in run.measured if delays[j]]
    if late:
        yield f"torques are logged late beside positions, which is taken out: {', '.join(late)}"


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
    """Return (p,) what a description can say of the parameters: bodies, and of joints viscous and Coulomb friction."""
    found = dict(zip(structure.names, theta.tolist(), strict=True))
    for k, shape in structure.shapes.items():
        motor = structure.regressor.motors[k]
        own = motor.name in structure.regressor.model.rates
        for name in shape.names(motor):
            kind = name.rpartition(".")[2]
            if kind == "stribeck":
                found[name] = found[f"{motor.name}.coulomb"]
            elif not own or kind not in ("viscous", "coulomb"):
                found[name] = 0.0
    return np.array([found[name] for name in structure.names])


def _offsets(motors: Mapping[str, MotorFit]) -> Iterator[str]:
    """Yield a warning for each motor with an offset that is no friction."""
    for name, fit in motors.items():
        beyond = abs(fit.offset) - fit.coulomb
        if beyond > 0.0:
            yield f"{name}: {beyond:.3g} N m of its offset are no friction, and in no file: the torque sensor's?"


def like_weight(structure: Structure, R: Floats) -> list[str]:
    """Return a line if constant torques look much like what bodies weigh: of which joints.

    Args:
        R: (k, p) weighted rows of the structure's parameters.
    """
    kinds = [name.rpartition(".")[2] for name in structure.names]
    bodies = R[:, [k for k, kind in enumerate(kinds) if kind in INERTIAL]]
    lengths = np.linalg.norm(bodies, axis=0)
    axes, size, _ = np.linalg.svd(bodies / np.where(lengths > 0.0, lengths, 1.0), full_matrices=False)
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


_ABSORBED = 3.0
"""Times what is left: a fit hides a part of what the model has not in its parameters, where it comes back on another
motion. Chosen on one half of the logs of which the documentation has the other."""
_CHANCE = 1.0
"""Standard deviations by which noise alone is larger in one part of a log than in another."""
_LEAST = 1e-3
"""Of a joint's torque: no model is nearer to a robot."""
_LOUD = 2.0
"""Times the noise: what is told."""


class Misfit(NamedTuple):
    """What is left of each measured joint's torque in parts of the logs that were not fitted.

    Attributes:
        left: (joints,) its RMS in the worst part; noise: that of the noise of torques, filtered [N m].
        deviation: (joints,) standard error of predicted torques beside that of the parameters [N m].
    """

    left: Floats
    noise: Floats
    deviation: Floats

    def words(self, names: list[str]) -> list[str]:
        """Return a line if something is missing in the model."""
        rows = zip(names, self.left.tolist(), self.noise.tolist(), self.deviation.tolist(), strict=True)
        loud = [f"{name} +- {more:.2g} N m" for name, left, noise, more in rows if left > _LOUD * noise]
        if not loud:
            return []
        what = "the model lacks something (friction that changes or sticks, joints that bend, a load)"
        return [f"more than noise is left of some torques: {what}; intervals are wider by {', '.join(loud)}"]


def misfit(run: Run, structure: Structure, plain: Gathered, weighted: Gathered, theta: Floats, sigma: Floats) -> Misfit:
    """Return how far off torques are in each part of the logs where the other parts were fitted, and what is held out.

    Blocks of the log stand for other motions: their errors have in them how residuals go along with the motion, and how
    they differ between the parts of a log.

    Args:
        theta: (p,) fitted to all parts; sigma: (joints,) by which joints weigh [N m].
    """
    folds, parts = range(FOLDS), []
    for fold, (R, z) in enumerate(without_one(weighted, folds, structure, sigma)):
        parts.append((fold, least_squares(R, z)))
    off, least = [], np.zeros(len(sigma))
    passed = [np.linalg.norm(kernel(run.cutoff, log.step)) * log.loud for log in run.logs]
    noise = np.min(passed, axis=0)[list(run.measured)]
    for fold, values in (*parts, (FOLDS, theta)):
        rows = counts(plain, [fold])
        if rows.all():
            off.append(squares(plain, fold, structure, values) / rows)
            least = np.maximum(least, noise * (1.0 + _CHANCE / np.sqrt(2.0 * rows)))
    left = np.sqrt(np.max(off, axis=0))
    size = np.sqrt(plain.squares.sum(axis=0) / np.maximum(counts(plain, range(FOLDS + 1)), 1.0))
    deviation = np.hypot(_ABSORBED * np.sqrt(np.maximum(left**2 - least**2, 0.0)), _LEAST * size)
    return Misfit(left, noise, deviation)
