"""Which parameters a log is explained by, and how that is chosen: coupled motors, how friction decays, the prior."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robodyn.identification.parameters.base import Base, shown
from robodyn.identification.parameters.consistent import Prior, consistent_parameters
from robodyn.identification.parameters.regressor_columns import (
    LAGS,
    PLAIN,
    Gathered,
    Moments,
    Motor,
    RegressorColumns,
    Shape,
    stacked,
)
from robodyn.robot.model import Model
from robodyn.support.floats import Floats, einsum, unit_columns

_RIDGE, _LEAST, _ROUNDS = 1e-4, 1e-13, 6
"""Of a column's length: what is shown by less is left where it is in comparisons; of a joint's torques: residuals are
not taken for smaller; rounds of weights."""
_LAG = np.arange(LAGS + 1)
_TAPER = np.where(2 * _LAG < LAGS + 1, 1.0 - 6.0 * (x := _LAG / (LAGS + 1.0)) ** 2 * (1.0 - x), 2.0 * (1.0 - x) ** 3)
"""Parzen's, of each lag."""
_BOTH = np.where(_LAG > 0, 2.0, 1.0) * _TAPER  # how often each lag counts, forwards and backwards, times its taper


@dataclass(frozen=True, eq=False)
class Structure:
    """Parameters as sums of columns; `shapes` says of each motor that counts, by its place, how it is modelled."""

    regressor: RegressorColumns
    shapes: dict[int, Shape]

    @property
    def names(self) -> tuple[str, ...]:
        """(p,) of the parameters: those of bodies, then of motors (`motors.PARAMETERS`)."""
        motors = (shape.names(self.regressor.motors[k]) for k, shape in self.shapes.items())
        return (*self.regressor.bodies, *(name for names in motors for name in names))

    @property
    def shape(self) -> Floats:
        """(a, p): which sums of regressor the parameters stand for."""
        bodies = len(self.regressor.bodies)
        found = np.zeros((len(self.regressor.names), len(self.names)))
        found[np.arange(bodies), np.arange(bodies)] = 1.0
        starts = np.cumsum([bodies, *(len(motor.column_names) for motor in self.regressor.motors)])
        column = bodies
        for k, shape in self.shapes.items():
            part = shape.matrix(self.regressor.motors[k])
            found[starts[k] : starts[k + 1], column : column + part.shape[1]] = part
            column += part.shape[1]
        return found

    @property
    def driving(self) -> NDArray[np.bool_]:
        """(p,) which parameters make power if they are negative: viscous and Coulomb friction and rotors."""
        return np.array([name.rpartition(".")[2] in ("viscous", "coulomb", "rotor") for name in self.names])

    @property
    def loaded(self) -> bool:
        """Whether friction of a motor grows with load."""
        return any(shape.load for shape in self.shapes.values())

    def loads(self, theta: Floats) -> dict[int, float]:
        """Return by the places of motors whose friction grows with load which part of it that is."""
        found = dict(zip(self.names, theta.tolist(), strict=True))
        loaded = [k for k, shape in self.shapes.items() if shape.load]
        return {k: found[f"{self.regressor.motors[k].name}.load"] for k in loaded}

    def reshaped(self, shapes: dict[int, Shape]) -> Structure:
        return replace(self, shapes={**self.shapes, **shapes})


def system(gathered: Gathered, folds: Sequence[int], structure: Structure, sigma: Floats) -> tuple[Floats, Floats]:
    """Return R (k, p) and z (k,) with |R theta - z|^2 = sum over joints of (|Y_j theta - tau_j| / sigma_j)^2. Columns
    of R that are rounding alone are zero: at unit length they would explain torques at random."""
    return whole_system([_of_fold(gathered, fold, structure, sigma) for fold in folds], structure.names)


def without_one(
    gathered: Gathered, folds: Sequence[int], structure: Structure, sigma: Floats
) -> list[tuple[Floats, Floats]]:
    """Return for each fold the `system` of all others."""
    parts = [_of_fold(gathered, fold, structure, sigma) for fold in folds]
    others = ([part for k, part in enumerate(parts) if k != left] for left in range(len(parts)))
    return [whole_system(each, structure.names) for each in others]


def whole_system(parts: list[Floats], names: Sequence[str]) -> tuple[Floats, Floats]:
    """Return R (k, p) and z (k,) of weighted rows [columns of the parameters, torques] in parts."""
    whole = stacked(parts)
    R = whole[:, :-1]
    return np.where(shown(R, names), R, 0.0), whole[:, -1]


def _of_fold(gathered: Gathered, fold: int, structure: Structure, sigma: Floats) -> Floats:
    """Return the triangular factor of [columns of the parameters, torques] of all joints of a fold, weighted."""
    shape, rows = structure.shape, []
    for used, triangle, scale in zip(structure.regressor.used, gathered.parts[fold], sigma, strict=True):
        own = triangle.R[:, :-1] @ shape[used]
        rows.append(np.concatenate([own, triangle.R[:, -1:]], axis=1) / scale)
    return stacked(rows)


def squares(gathered: Gathered, fold: int, structure: Structure, theta: Floats) -> Floats:
    """Return (joints,) the sums of squares of the residuals of a fold [N^2 m^2]."""
    values = structure.shape @ theta
    pairs = zip(structure.regressor.used, gathered.parts[fold], strict=True)
    off = [triangle.R[:, :-1] @ values[used] - triangle.R[:, -1] for used, triangle in pairs]
    return np.array([each @ each for each in off])


def counts(gathered: Gathered, folds: Sequence[int]) -> Floats:
    return np.asarray(np.sum([[float(each.count) for each in gathered.parts[fold]] for fold in folds], axis=0))


def least_squares(R: Floats, z: Floats, signed: NDArray[np.bool_] | None = None) -> Floats:
    """Return theta (p,) of least |R theta - z|^2, short where little is shown; signed: (p,) which are not negative."""
    unit, lengths = unit_columns(R)
    rows = np.concatenate([unit, _RIDGE * np.eye(len(lengths))])
    signed = np.zeros(len(lengths), dtype=bool) if signed is None else signed
    order, free = np.argsort(signed, kind="stable"), int(np.sum(~signed))
    whole = stacked([np.column_stack((rows[:, order], np.concatenate((z, np.zeros(len(lengths))))))])
    triangle, right = whole[: len(lengths), :-1], whole[: len(lengths), -1]
    theta = np.zeros(len(lengths))
    if free < len(lengths):
        from scipy.optimize import nnls

        theta[order[free:]] = nnls(triangle[free:, free:], right[free:])[0]
    rest = right - triangle @ theta[order]
    theta[order[:free]] = np.linalg.solve(triangle[:free, :free], rest[:free])
    return theta / lengths


def fitted(gathered: Gathered, folds: Sequence[int], structure: Structure) -> tuple[Floats, Floats]:
    """Return theta (p,) and each joint's sigma by iterated weights: the least sum of logarithms of sigma."""
    rows = np.maximum(counts(gathered, folds), 1.0)
    sigma = np.sqrt(gathered.squares[list(folds)].sum(axis=0) / rows)
    least = np.maximum(_LEAST * sigma, 1e-300)
    sigma = np.maximum(sigma, least)
    theta = np.zeros(len(structure.names))
    for _ in range(_ROUNDS):
        theta = least_squares(*system(gathered, folds, structure, sigma))
        off = np.asarray(sum(squares(gathered, fold, structure, theta) for fold in folds))
        sigma = np.maximum(np.sqrt(off / rows), least)
    return theta, sigma


def left_out(gathered: Gathered, folds: Sequence[int], structure: Structure, sigma: Floats) -> Floats:
    """Return (joints,) the sums of squares in each fold of the fit of the others: cross-validation."""
    rest = without_one(gathered, folds, structure, sigma)
    parts = [squares(gathered, fold, structure, least_squares(*each)) for fold, each in zip(folds, rest, strict=True)]
    return np.asarray(sum(parts))


def covariance(moments: Moments, structure: Structure, base: Base, R: Floats, sigma: Floats) -> Floats:
    """Return (r, r) the covariance of base parameters that were fitted to rows with weights 1 / sigma.

    T W T^T with T^T R^T R T = 1 of the columns of the base, rows R (k, p), and W = sum over joints and lags of
    rho_lag w_lag C_lag: residuals are taken for stationary, so that their correlation rho at each lag, tapered by
    Parzen's w, meets the sums C of products of (orthonormal) columns at that lag. Residuals are smaller than the noise
    and of another colour, for a part of it was fitted: rho solves the linear equations of what is expected of their
    products, to the first order (Newey and West 1987 do without).
    """
    unit, lengths = unit_columns(R[:, base.independent])
    _, size, axes = np.linalg.svd(unit, full_matrices=False)
    inverse = axes.T / size / lengths[:, None]
    shape = structure.shape[:, base.independent] @ inverse
    C = []
    for used, scale, sums in zip(structure.regressor.used, sigma, moments.columns, strict=True):
        own = shape[used] / scale
        products = einsum("ar,lab,bs->lrs", own, sums, own, optimize=True)
        C.append((products + products.swapaxes(1, 2)) / 2.0)
    rows = moments.count - _LAG.astype(float)
    first = np.where(moments.residuals[0] > 0.0, moments.residuals[0], 1.0)
    rho = moments.residuals / first * moments.count / np.maximum(rows, 1.0)[:, None]
    W = _meat(C, rho)
    for j, own in enumerate(C):
        traces = einsum("lrr->l", own)  # what is fitted of the correlation at one lag from the products at another
        lost = (traces[_LAG[:, None] + _LAG] + traces[np.abs(_LAG[:, None] - _LAG)]) * np.where(_LAG > 0, 1.0, 0.5)
        left = rho[:, j] * rows - einsum("lrs,rs->l", own[: LAGS + 1], W)
        rho[:, j] = np.linalg.solve(np.diag(rows) - 2.0 * lost * _TAPER, left)
    values, axes = np.linalg.eigh(_meat(C, rho))
    # W lies between the least and the largest power of all joints' residuals, but for rounding.
    power = np.cos(np.outer(np.linspace(0.0, np.pi, 8 * LAGS), _LAG)) @ (_BOTH[:, None] * rho)
    half = inverse @ axes * np.sqrt(np.clip(values, max(float(power.min()), 0.0), max(float(power.max()), 0.0)))
    return np.asarray(half @ half.T)


def _meat(C: Sequence[Floats], rho: Floats) -> Floats:
    parts = [einsum("l,lrs->rs", _BOTH * rho[:, j], own[: LAGS + 1]) for j, own in enumerate(C)]
    return np.asarray(np.sum(parts, axis=0))


SPEEDS = (0.01, 0.03, 0.1, 0.2, 0.4)  # speeds of Stribeck's excess that are compared, in parts of a motor's largest
ROUNDED = 5.0
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
    return [Motor(name, axis, 0.0) for name, axis in zip(model.rates, np.eye(model.n), strict=True)]


def coupled_motors(model: Model, measured: Sequence[int], known: Sequence[Motor]) -> list[Motor]:
    """Return motors that turn with the sum or the difference of two joints, one after another in a chain, of which no
    known coupled motor turns with one."""
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
    """Return the motors of two joints that explain much of what is left, and what part of its squares stays. Of motors
    that share a joint the one that explains most."""
    _, sigma = fitted(gathered, folds, plain)
    before = np.maximum(left_out(gathered, folds, plain, sigma), 1e-300)
    ranked, measured = [], plain.regressor.measured
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


def with_friction(gathered: Gathered, folds: Sequence[int], plain: Structure) -> Structure:
    """Return the structure with Stribeck's excess of those motors whose joint it explains, each at its best speed, and
    then with friction that grows with load, likewise."""
    motors = plain.regressor.motors
    speeds = {k: motors[k].stribeck for k in plain.shapes}
    tried = [
        {k: replace(plain.shapes[k], stribeck=each[-step]) for k, each in speeds.items() if step <= len(each)}
        for step in range(1, len(SPEEDS) + 1)
    ]
    decaying = _best(gathered, folds, plain, tried)
    loaded = {k: replace(shape, load=True) for k, shape in decaying.shapes.items() if motors[k].loaded}
    return _best(gathered, folds, decaying, [loaded])


def with_possible_loads(structure: Structure, theta: Floats) -> Structure:
    """Return the structure without friction that would grow against the load, or almost as fast as it."""
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
