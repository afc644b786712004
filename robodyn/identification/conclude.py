"""What was fitted, told: errors of what is fitted and held out, whether bodies can exist, warnings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from robodyn.identification.gather import Gathered
from robodyn.identification.identified import BaseFit, Errors, Identified, MotorFit
from robodyn.identification.outcome import motor_fits, outcome
from robodyn.identification.prior import Prior, PriorBody
from robodyn.identification.pseudo_inertia import pseudo_inertia
from robodyn.identification.run import FOLDS, RESTS, Run
from robodyn.identification.structure import Structure, counts, squares
from robodyn.support.floats import Floats

_COSTLY, _ROUNDING, _UNLIKELY = 1.5, 1e-6, 5.0


def _errors(run: Run, off: Floats, of: Floats) -> Errors:
    """Return relative errors of sums of squares by joint."""
    joints = {
        run.model.rates[j]: _ratio(*pair) for j, *pair in zip(run.measured, off.tolist(), of.tolist(), strict=True)
    }
    return Errors(_ratio(float(off.sum()), float(of.sum())), joints)


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
    ratios: dict[str, float],
    faults: list[str],
) -> Identified:
    """Return what was found.

    Args:
        fits: the parameters of the structure: those of bodies that can exist, and by least squares.
        chosen: strength of the prior. ratios: of coupled motors, what they leave. faults: gross ones, a line each.
    """
    theta, _ = fits

    def errors(folds: list[int]) -> list[Errors]:
        of = plain.squares[folds].sum(axis=0)
        sums = [sum(squares(plain, fold, structure, each) for fold in folds) for each in fits]
        return [_errors(run, np.asarray(off), of) for off in (*sums, plain.described[folds].sum(axis=0))]

    fitted_errors = errors([*range(FOLDS)])
    held = errors([FOLDS]) if run.holds and plain.squares[FOLDS].any() else [None] * 3
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
        coupled=ratios,
        train=fitted_errors[0],
        held_out=held[0],
        bound_train=fitted_errors[1],
        bound_held_out=held[1],
        original_train=fitted_errors[2],
        original_held_out=held[2],
        strength=chosen,
        cutoff=run.cutoff,
        slip_speed=run.slip_speed,
        consistent=_possible(shown, theta),
        unseen=tuple(body.name for body in prior.bodies if body not in shown),
        rows=int(counts(plain, range(FOLDS + 1)).sum()),
        samples=sum(log.samples for log in run.logs),
        duration=sum(log.stop - log.start for log in run.logs),
        hashes={log.path: log.sha256 for log in run.logs},
        faults=tuple(faults),
        warnings=(
            *faults,
            *_warnings(run, prior, ratios, (fitted_errors[0], fitted_errors[1]), held[0] is not None),
            *_offsets(motors),
            *_weights(shown, prior, theta),
        ),
    )


def _possible(bodies: Sequence[PriorBody], theta: Floats) -> bool:
    """Return whether the pseudo-inertia of every body that is shown is positive definite."""
    return all(np.linalg.eigvalsh(pseudo_inertia(theta[body.columns])).min() > 0.0 for body in bodies)


def _offsets(motors: Mapping[str, MotorFit]) -> Iterator[str]:
    """Yield a warning for each motor with an offset that is no friction."""
    for name, fit in motors.items():
        beyond = abs(fit.offset) - fit.coulomb
        if beyond > 0.0:
            yield f"{name}: {beyond:.3g} N m of its offset are no friction, and in no file: the torque sensor's?"


def _weights(bodies: Sequence[PriorBody], prior: Prior, theta: Floats) -> Iterator[str]:
    """Yield a warning if the bodies that the log shows weigh far more or less than described."""
    places = [body.columns.start for body in bodies]
    described, found = (float(np.sum(each[places])) for each in (prior.theta, theta))
    if places and not 1.0 / _UNLIKELY < found / described < _UNLIKELY:
        yield f"bodies weigh {found / described:.3g} times what is described: are torques in N m?"


def _warnings(
    run: Run, prior: Prior, ratios: dict[str, float], off: tuple[Errors, Errors], held: bool
) -> tuple[str, ...]:
    """Return what was assumed and what cannot be told, a line each."""
    lines = [f"{log.path}: {note}" for log in run.logs for note in log.notes]
    names = run.model.rates
    still = {name for log in run.logs for name in log.held}
    resting = [name for name in names if run.directions[name].scale <= RESTS and name not in still]
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
