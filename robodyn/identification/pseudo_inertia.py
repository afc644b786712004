"""The pseudo-inertia of a body: ten parameters as one 4 x 4 matrix, positive definite where the body can exist."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robodyn.support.floats import Floats
from robodyn.support.sums import einsum


def _map() -> Floats:
    """Return (10, 4, 4): the pseudo-inertia of each parameter alone, in the order of the regressor."""
    P = np.zeros((10, 4, 4))
    P[0, 3, 3] = 1.0
    for i in range(3):
        P[1 + i, i, 3] = P[1 + i, 3, i] = 1.0
    for k, (i, j) in zip(range(4, 10), ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)), strict=True):
        if i == j:
            P[k, :3, :3] = 0.5 * np.eye(3)
            P[k, i, i] = -0.5
        else:
            P[k, i, j] = P[k, j, i] = -1.0
    return P


_OF_PARAMETERS = _map()


def pseudo_inertia(parameters: ArrayLike) -> Floats:
    """P = [[S, m c], [m c^T, m]] with S = tr(I) / 2 1 - I, the integral of (x, 1) (x, 1)^T dm about the frame's origin.

    P is positive definite if and only if some body of positive density has these parameters: mass positive, principal
    moments about the centre of mass positive and within the triangle inequality (Wensing, Kim, Slotine 2018).

    Args:
        parameters: (..., 10) m, m c, and Ixx Ixy Ixz Iyy Iyz Izz about the origin [kg, kg m, kg m^2].

    Returns:
        (..., 4, 4).

    Accuracy: each entry within 2 eps of the largest of its kind; `parameters_of` undoes it likewise.
    """
    P: Floats = einsum("...k,kij->...ij", np.asarray(parameters, dtype=float), _OF_PARAMETERS)
    return P


def parameters_of(P: ArrayLike) -> Floats:
    """Return the ten parameters (..., 10) of pseudo-inertias (..., 4, 4), I = tr(S) 1 - S; undoes `pseudo_inertia`."""
    P = np.asarray(P, dtype=float)
    xx, yy, zz = P[..., 0, 0], P[..., 1, 1], P[..., 2, 2]
    first = (P[..., 3, 3], P[..., 0, 3], P[..., 1, 3], P[..., 2, 3])
    moments = (yy + zz, -P[..., 0, 1], -P[..., 0, 2], xx + zz, -P[..., 1, 2], xx + yy)
    return np.stack((*first, *moments), axis=-1)


def divergence(P: Floats, P0: Floats) -> Floats:
    """D(P || P0) = tr(P0^-1 P) - log det(P0^-1 P) - 4, zero for P = P0 alone (Lee, Wensing, Park 2020).

    It does not depend on units, axes or origin: D(T P T^T || T P0 T^T) = D(P || P0).

    Args:
        P, P0: (..., 4, 4) positive definite.
    """
    L = np.linalg.cholesky(P0)
    half = np.linalg.solve(L, P)
    values = np.linalg.eigvalsh(np.linalg.solve(L, np.swapaxes(half, -1, -2)))
    found: Floats = np.sum(values - 1.0 - np.log(values), axis=-1)
    return found
