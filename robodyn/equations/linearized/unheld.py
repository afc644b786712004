"""What nothing holds: motions without stiffness, split off before eigenvalues are sought."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.equations.linearized.small_motion import SmallMotion
from robodyn.programs.linear import null_space, range_basis
from robodyn.programs.vectors import length, product
from robodyn.support.floats import Floats

_WRITTEN = 5e-10
"""Half a unit of the tenth digit, with which descriptions write right angles (1.570796327): an axis is so far off, and
a weight turns by this part into stiffness that is none."""
_ROUNDED = 16.0 * float(np.finfo(float).eps)


class Split(NamedTuple):
    """Coordinates x = scale * y, in which rows of `basis` and `rest` together are orthonormal.

    Attributes:
        scale: (k,) of the coordinates and of their speeds.
        drift: (r, k) motions without stiffness.
        basis: (r + s, 2 k) these, and the speeds of the s of them that nothing slows either.
        rest: what stands across them; A maps the basis onto itself.
    """

    scale: Floats
    drift: Floats
    basis: Floats
    rest: Floats


def split(found: SmallMotion) -> Split:
    """Return what nothing holds: no stiffness above 5e-10 of what the robot's weight can make at each joint.

    Coordinates are scaled so that this, or a joint's own stiffness where that is larger, is 1. Of a state that moves
    nothing is split off.
    """
    k = len(found.M)
    inertia = np.abs(np.diag(found.M))
    stiff = np.maximum(found.weight, np.abs(np.diag(found.stiffness)))
    scale = 1.0 / np.sqrt(np.where(stiff > 0.0, stiff, np.where(inertia > 0.0, inertia, 1.0)))
    none = np.zeros((0, 2 * k))
    if not found.at_rest:
        return Split(scale, none[:, :k], none, np.eye(2 * k))
    drift = _null(found.stiffness * np.outer(scale, scale), k * _WRITTEN)
    free = _undamped(found.damping * np.outer(scale, scale), drift)
    basis = np.vstack((np.hstack((drift, np.zeros_like(drift))), np.hstack((np.zeros_like(free), free))))
    return Split(scale, drift, basis, null_space(basis, 0.0) if len(basis) else np.eye(2 * k))


def _null(rows: Floats, nothing: float) -> Floats:
    """Return an orthonormal basis (r, n) of what rows (m, n) of a size of 1 map to less than this."""
    largest = float(np.sqrt((rows * rows).sum(axis=1)).max(initial=0.0))
    return null_space(rows, nothing / largest) if largest > nothing else np.eye(rows.shape[1])


def _undamped(damping: Floats, drift: Floats) -> Floats:
    """Return (s, n) an orthonormal basis of the drift that nothing slows."""
    slowed = product(damping, drift.T)
    nothing = _ROUNDED * length(damping.ravel())
    if not len(drift) or length(slowed.ravel()) <= nothing:
        return drift
    free = _null(slowed, nothing)
    return range_basis(product(free, drift), 0.0) if len(free) else drift[:0]
