"""How a log is explained: which motors are coupled, how friction decays, how strongly the description draws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robodyn.identification.parameters.consistent import consistent_parameters
from robodyn.identification.parameters.prior import Prior
from robodyn.identification.parameters.qr_accumulation import Gathered
from robodyn.identification.parameters.regressor_columns import PLAIN, Motor, Shape
from robodyn.identification.parameters.structure import (
    Structure,
    counts,
    fitted,
    least_squares,
    left_out,
    squares,
    system,
    without_one,
)
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats

SPEEDS = (0.01, 0.03, 0.1, 0.2, 0.4)
"""Speeds of Stribeck's excess that are compared, in parts of a motor's largest."""
_ROUNDED = 5.0
"""Times the slip speed: breakaway that decays faster would make up for the rounded sign of Coulomb's friction."""
_COUPLED, _MOST = 0.5, 0.8
"""A coupled motor counts if it makes the squares of what is left of both joints, on average, so much less; friction
that is a larger part of the load is no friction of a gear."""
_WORTH, _CHANCE = 0.97, 15.0
"""Stribeck's excess counts if it makes the squares of what is left so much less, and by so many mean squares: of five
speeds the best takes more than that from noise in one of a thousand logs."""
STRENGTHS = (0.01, 0.1, 1.0, 10.0, 100.0, 1000.0)
"""Of the prior, in units of one standard deviation, that are compared."""


def joint_motors(model: Model) -> list[Motor]:
    """The motor of every joint."""
    return [Motor(name, axis, 0.0) for name, axis in zip(model.rates, np.eye(model.n), strict=True)]


def scene_motors(model: Model, scene: Scene) -> list[Motor]:
    """The coupled motors of a scene."""
    turns = ((motor.name, [motor.joints.get(name, 0.0) for name in model.rates]) for motor in scene.coupled)
    return [Motor(name, np.array(direction), 0.0) for name, direction in turns]


def coupled_motors(model: Model, measured: Sequence[int], known: Sequence[Motor]) -> list[Motor]:
    """Return motors that turn with the sum or the difference of two joints, one after another in a chain, of which no
    known coupled motor turns with one.
    """
    found, axes = [], np.eye(model.n)
    taken = {int(j) for motor in known for j in np.flatnonzero(motor.direction)}
    open_rates = set(measured) - taken
    order = [body.joint.rate for body in model.bodies[1:]]
    parents = {body.joint.rate: model.bodies[body.parent].joint.rate for body in model.bodies[1:] if body.parent > 0}
    for j in dict.fromkeys(order):
        i = parents.get(j)
        if i is not None and i != j and {i, j} <= open_rates:
            for sign, mark in ((1.0, "+"), (-1.0, "-")):
                name = f"{model.rates[i]}{mark}{model.rates[j]}"
                found.append(Motor(name, axes[i] + sign * axes[j], 0.0))
    return found


def coupled(gathered: Gathered, folds: Sequence[int], plain: Structure) -> list[tuple[Motor, float]]:
    """Return the motors of two joints that explain much of what is left, and what part of its squares stays.

    Of motors that share a joint the one that explains most.
    """
    _, sigma = fitted(gathered, folds, plain)
    before = np.maximum(left_out(gathered, folds, plain, sigma), 1e-300)
    ranked = []
    measured = plain.regressor.measured
    for k, motor in enumerate(plain.regressor.motors):
        if k not in plain.shapes:
            other = plain.reshaped({k: PLAIN})
            joints = [place for place, j in enumerate(measured) if motor.direction[j]]
            part = float((left_out(gathered, folds, other, sigma) / before)[joints].mean())
            if part < _COUPLED:
                values = least_squares(*system(gathered, folds, other, sigma))
                theta = dict(zip(other.names, values.tolist(), strict=True))
                if theta[f"{motor.name}.viscous"] > 0.0 and theta[f"{motor.name}.coulomb"] > 0.0:
                    ranked.append((part, motor))
    found: list[tuple[Motor, float]] = []
    taken = np.zeros(plain.regressor.model.n)
    for part, motor in sorted(ranked, key=lambda pair: pair[0]):
        if not (taken * motor.direction).any():
            found.append((motor, part))
            taken += np.abs(motor.direction)
    return found


def with_stribeck(gathered: Gathered, folds: Sequence[int], plain: Structure) -> Structure:
    """Return the structure with Stribeck's excess of those motors whose joint it explains, each at its best speed."""
    speeds = {k: plain.regressor.motors[k].stribeck for k in plain.shapes}
    tried = [
        {k: replace(plain.shapes[k], stribeck=each[-step]) for k, each in speeds.items() if step <= len(each)}
        for step in range(1, len(SPEEDS) + 1)
    ]
    return _best(gathered, folds, plain, tried)


def with_load(gathered: Gathered, folds: Sequence[int], plain: Structure) -> Structure:
    """Return the structure with friction that grows with load in those motors whose joint it explains."""
    loaded = {k: replace(shape, load=True) for k, shape in plain.shapes.items() if plain.regressor.motors[k].loaded}
    return _best(gathered, folds, plain, [loaded])


def with_possible_loads(structure: Structure, theta: Floats) -> Structure:
    """Return the structure without friction that would grow against the load, or almost as fast as it.

    Args:
        theta: (p,) of least squares.
    """
    wrong = [k for k, load in structure.loads(theta).items() if not 0.0 < load < _MOST]
    return structure.reshaped({k: replace(structure.shapes[k], load=False) for k in wrong})


def _best(gathered: Gathered, folds: Sequence[int], plain: Structure, tried: Sequence[dict[int, Shape]]) -> Structure:
    """Return the structure with every motor shaped as explains its joint best, if by more than chance."""
    _, sigma = fitted(gathered, folds, plain)
    best = {k: (1.0, shape) for k, shape in plain.shapes.items()}
    before = np.maximum(left_out(gathered, folds, plain, sigma), 1e-300)
    places = {j: place for place, j in enumerate(plain.regressor.measured)}
    worth = np.minimum(_WORTH, 1.0 - _CHANCE / np.maximum(counts(gathered, folds), 1.0))
    for shapes in tried:
        ratio = left_out(gathered, folds, plain.reshaped(shapes), sigma) / before
        for k, shape in shapes.items():
            own = [places[int(j)] for j in np.flatnonzero(plain.regressor.motors[k].direction) if int(j) in places]
            if own and ratio[own[-1]] < min(float(worth[own[-1]]), best[k][0]):
                best[k] = float(ratio[own[-1]]), shape
    return plain.reshaped({k: shape for k, (_, shape) in best.items()})


def strength(
    gathered: Gathered, plain: Gathered, folds: Sequence[int], structure: Structure, prior: Prior, sigma: Floats
) -> float:
    """Return the strength whose fits of all folds but one explain that one best."""
    rows = without_one(gathered, folds, structure, sigma)

    def error(value: float) -> float:
        left = (
            squares(plain, fold, structure, consistent_parameters(R, z, prior, value).theta)
            for fold, (R, z) in zip(folds, rows, strict=True)
        )
        return sum(float((each / sigma**2).sum()) for each in left)

    return min(STRENGTHS, key=error)


def with_speeds(motor: Motor, largest: float, slip_speed: float) -> Motor:
    """Return a motor whose largest speed is known; breakaway decays over more than a sign does that is rounded off."""
    speeds = (part * largest for part in SPEEDS)
    return replace(motor, scale=largest, stribeck=tuple(speed for speed in speeds if speed > _ROUNDED * slip_speed))
