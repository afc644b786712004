"""Base parameters: the combinations of parameters that torques tell apart, by rank-revealing QR."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import HALF_UP, Floats, einsum, unit_columns

TOLERANCE = 1e-8
"""Of a column's length: what lies off the span of the others by less is dependent on them. Rounding reaches 1e-13, and
angles that a description truncates 1e-9; while columns of the regressor at random states are at least 0.1 apart."""
_EARLY_ENOUGH = 1e-3
"""An earlier parameter is preferred to a later one whose column is up to a thousand times farther from the others."""
_NOTHING, _ROUNDING = 1e-9, 1e-13
"""Of the longest column of the same unit: a shorter one is zero but for rounding and truncated angles; and of a sum's
terms."""
_LONG = 8  # words of a group, about three terms
_UNITS = {name: "kg" if name == "m" else "kg m" if name.startswith("m") else "kg m^2" for name in INERTIAL}


class Estimate(NamedTuple):
    """Base parameters (r,) by least squares, in SI units."""

    values: Floats
    standard_errors: Floats
    covariance: Floats


@dataclass(frozen=True, eq=False)
class Base:
    """Y theta = Y[:, independent] beta with beta = matrix theta, for every row Y that the motion has.

    Attributes:
        names: (p,) of the parameters theta; independent: (r,) those that groups are named after, ascending.
        matrix: (r, p) the groups: 1 at each one's own parameter, 0 at those of the others.
        kept, dropped: parts of their lengths by which the nearest of the chosen columns and the farthest of the others
            are off the span: the gap in which the rank was decided.
        condition: of the columns of `independent` at unit length.
    """

    names: tuple[str, ...]
    independent: tuple[int, ...]
    matrix: Floats
    kept: float
    dropped: float
    condition: float

    @property
    def rank(self) -> int:
        return len(self.independent)

    @property
    def invisible(self) -> tuple[int, ...]:
        """Which parameters are in no group: no torque shows them."""
        return tuple(np.flatnonzero(~self.matrix.any(axis=0)).tolist())

    @cached_property
    def groups(self) -> tuple[str, ...]:
        """The base parameters in words: "forearm.Izz + 0.1849 hand.m"; coefficients in SI units to four digits."""
        found = []
        for row, own in zip(self.matrix, self.independent, strict=True):
            text = self.names[own]
            for k in np.flatnonzero(row):
                if k != own:
                    size = f"{abs(row[k]) * HALF_UP:.4g}"
                    text += f" {'-' if row[k] < 0 else '+'} {'' if size == '1' else size + ' '}{self.names[k]}"
            found.append(text)
        return tuple(found)

    @property
    def short_groups(self) -> tuple[str, ...]:
        """The same; in the place of a long one its first parameter and the number of the others."""
        return tuple(
            group if group.count(" ") < _LONG else f"{self.names[own]} + {np.count_nonzero(row) - 1} others"
            for group, own, row in zip(self.groups, self.independent, self.matrix, strict=True)
        )

    def values(self, theta: Floats) -> Floats:
        """Return beta (..., r) of parameters theta (..., p); 0 for what is rounding alone beside its terms."""
        found = einsum("rp,...p->...r", self.matrix, theta)
        size = einsum("rp,...p->...r", np.abs(self.matrix), np.abs(theta))
        return np.asarray(np.where(np.abs(found) > _ROUNDING * size, found, 0.0))

    def estimate(self, R: Floats, z: Floats) -> Estimate:
        """Return the beta that minimises |R[:, independent] beta - z|, with cov(beta) = (R_b^T R_b)^-1.

        Args:
            R: (k, p) rows of the regressor over the torques' standard deviations, or their triangular factor; z: (k,)
                torques, alike.

        Accuracy: within 10 eps r times `condition` of noise-free parameters.
        """
        unit, lengths = unit_columns(np.asarray(R, dtype=float)[:, self.independent])
        inverse = np.linalg.pinv(unit) / lengths[:, None]
        covariance = inverse @ inverse.T
        return Estimate(inverse @ z, np.sqrt(np.diagonal(covariance)), covariance)

    def within(self, R: Floats, tolerance: float = TOLERANCE) -> Base:
        """Return the base of a motion whose rows (or their factor) are R: what it shows of these base parameters."""
        inner = base_of(np.asarray(R)[:, self.independent], [self.names[k] for k in self.independent], tolerance)
        chosen = tuple(self.independent[k] for k in inner.independent)
        return replace(inner, names=self.names, independent=chosen, matrix=inner.matrix @ self.matrix)


def base_of(R: Floats, names: Sequence[str], tolerance: float = TOLERANCE) -> Base:
    """Return the base parameters of a regressor.

    Method: columns at unit length, so that units do not count, then Gram and Schmidt's QR with pivots (Gautier 1991,
    "Numerical calculation of the base inertial parameters of robots"). Each pivot is the first column that is at least
    a thousandth as far from the span of those before as the farthest: parameters of bodies near the base stay, and
    what hangs on them is added to them, as in the tables of Khalil and Dombre; no rounding turns the choice.

    Args:
        R: (k, p) rows of the regressor, or their triangular factor (R^T R = Y^T W Y).
        tolerance: part of a column's length off the span of others, under which it depends on them.

    Accuracy: `matrix` within 1e-10 of exact coefficients at random states.
    """
    A = np.array(R, dtype=float)
    visible = np.flatnonzero(shown(A, names))
    unit, lengths = unit_columns(A[:, visible])
    rest, Q, chosen, kept, off = unit.copy(), np.zeros((len(unit), 0)), list[int](), 1.0, _lengths(unit)
    while len(chosen) < min(unit.shape) and off.max() > tolerance:
        pivot = int(np.argmax(off >= max(_EARLY_ENOUGH * off.max(), tolerance)))
        chosen.append(pivot)
        kept = min(kept, float(off[pivot]))
        q = rest[:, pivot] - Q @ (Q.T @ rest[:, pivot])
        q /= np.linalg.norm(q)
        Q = np.column_stack((Q, q))
        rest -= np.outer(q, q @ rest)
        rest[:, chosen] = 0.0
        off = _lengths(rest)
    own = np.array(sorted(chosen), dtype=int)
    others = np.setdiff1d(np.arange(len(visible)), own)
    tail = np.linalg.lstsq(unit[:, own], unit[:, others], rcond=None)[0]
    tail = np.where(np.abs(tail) > _NOTHING, tail, 0.0) / lengths[own, None] * lengths[others]
    matrix = np.zeros((len(own), len(names)))
    matrix[np.arange(len(own)), visible[own]] = 1.0
    matrix[:, visible[others]] = tail
    values = np.linalg.svd(unit[:, own], compute_uv=False)
    condition = float(f"{values[0] / values[-1]:.6g}") if len(values) else 1.0
    dropped = float(off[others].max(initial=0.0))
    return Base(tuple(names), tuple(visible[own].tolist()), matrix, kept, dropped, condition)


def shown(R: Floats, names: Sequence[str]) -> NDArray[np.bool_]:
    """Return (p,) which columns of rows R (k, p) are more than rounding beside the longest of the same unit."""
    lengths = _lengths(R)
    kinds = (name.rpartition(".")[2] for name in names)
    units = np.array([_UNITS.get(kind, kind) for kind in kinds], dtype=object)
    longest = {unit: lengths[units == unit].max() for unit in set(units)}
    return np.asarray(lengths > _NOTHING * np.array([longest[unit] for unit in units]))


def _lengths(A: Floats) -> Floats:
    return np.asarray(np.sqrt(einsum("ij,ij->j", A, A)))


def structural_base(model: Model, scene: Scene = DEFAULT) -> Base:
    """Return the base parameters of a tree in a scene, whose friction and gravity count, from the regressor at random
    states; SceneError for loops or contacts. `Y[:, independent] matrix` is within 1e-10 of Y's columns' largest."""
    rows, names = random_rows(model, scene)
    return base_of(np.asarray(np.linalg.qr(rows, mode="r")), names)


def random_rows(model: Model, scene: Scene = DEFAULT) -> tuple[Floats, tuple[str, ...]]:
    """Return rows of the regressor at random states, three for each parameter, and the parameters' names. Half of the
    states are slow, so that Stribeck's friction is there."""
    rng = np.random.default_rng(19)
    inner = replace(scene, wrenches=(), immersed=())
    still = np.zeros((1, model.n))
    rest = np.zeros(model.nq)
    rest[[first + 3 for _, first in model.quaternions]] = 1.0
    names = regressor(model, rest, still, still, scene=inner, executor="numpy").names
    samples = 2 + 3 * len(names) // max(model.n, 1)
    q = rng.uniform(-2.0, 2.0, (samples, model.nq))
    qd, qdd = rng.uniform(-3.0, 3.0, (2, samples, model.n))
    for _, joint, friction in joints_with_friction(model, scene):
        if friction.stribeck is not None:
            qd[::2, joint.rate] *= friction.stribeck_velocity / 2.0
    return regressor(model, q, qd, qdd, scene=inner).Y.reshape(-1, len(names)), names
