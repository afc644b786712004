"""Parameters of bodies and motors that explain logs: what `robodyn identify` finds.

1. `log/log.py` reads logs; `log/rows.py` puts motion and torques through one filter.
2. `passes.py` goes over them: a first fit, what is wrong with the logs (`faults/`), rows of all columns.
3. `parameters/regressor_columns.py` has the columns, `parameters/qr_accumulation.py` keeps their triangular factors.
4. `model_selection.py` chooses coupled motors, breakaway, friction under load, the strength of the prior.
5. `parameters/consistent.py` fits bodies that can exist, `parameters/base.py` the base parameters.
6. `summary.py` tells errors, intervals and warnings; `result.py` holds what was found, `calibrated.py` writes it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.dynamics.effects.motors import rotor_of
from robodyn.errors import InputError
from robodyn.identification.log.log import Log
from robodyn.identification.model_selection import strength, with_load, with_possible_loads, with_stribeck
from robodyn.identification.parameters.base import base_of
from robodyn.identification.parameters.consistent import consistent_parameters
from robodyn.identification.parameters.prior import Prior, prior_of
from robodyn.identification.parameters.qr_accumulation import Moments
from robodyn.identification.parameters.regressor_columns import PARAMETERS, PLAIN
from robodyn.identification.parameters.structure import Structure, covariance, fitted, system
from robodyn.identification.passes import FOLDS, Run, begun, first_fit, repeated, weighted_rows
from robodyn.identification.result import BaseFit, Identified
from robodyn.identification.summary import identified, like_weight, misfit
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

_REPEATED = 3
"""Gauss-Newton's steps where friction grows with load, which is not linear in the parameters."""


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
    structure = with_stribeck(weighted, folds, Structure(regressor, dict.fromkeys(range(len(first.motors)), PLAIN)))
    structure = with_load(weighted, folds, structure)
    loose, sigma = fitted(weighted, folds, structure)
    for _ in range(_REPEATED if structure.loaded else 0):
        structure, plain, weighted, moments = repeated(run, structure, loose, sigma)
        structure = with_possible_loads(structure, fitted(weighted, folds, structure)[0])
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
    if structure.loaded:
        structure, plain, weighted, _ = repeated(run, structure, theta, sigma)
    left = misfit(run, structure, plain, weighted, theta, sigma)
    alike = like_weight(structure, R)
    return identified(run, structure, plain, (theta, loose), base, prior, chosen, first, left, alike)


def _prior(run: Run, structure: Structure, shapes: bool) -> Prior:
    """Return the prior of the structure's parameters: what the description and the scene say."""
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


def _base(structure: Structure, R: Floats, z: Floats, moments: Moments, sigma: Floats, theta: Floats) -> BaseFit:
    base = base_of(R, structure.names)
    C = covariance(moments, structure, base, R, sigma)
    return BaseFit(base, base.estimate(R, z).values, np.sqrt(einsum("ii->i", C)), base.values(theta), C)
