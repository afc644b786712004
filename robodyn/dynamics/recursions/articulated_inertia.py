"""Inertia of bodies that joints connect: a symmetric matrix of angular before linear entries, for any scalar."""

from __future__ import annotations

import numpy as np

from robodyn.programs.vectors import Array, Scalar, cross, skew
from robodyn.solids.inertia.moments import Inertia

Turn = tuple[Scalar, Scalar]
"""Cosine and sine of an angle."""


def articulated(body: Inertia) -> Array:
    """((I, [m c]), ([m c]^T, m 1)): what takes (wd, a) of a rigid body to the moment and the force (n, f)."""
    H = skew(body.mc)
    return np.block([[body.I, H], [H.T, body.m * np.eye(3)]])


def at_parent(A: Array, turns: tuple[Turn, Turn, Turn], p: Array) -> Array:
    """The same inertia in the axes and about the origin of the parent.

    With `R = Rz Rx Rz` made of the three turns: I, H and M become `R I R^T` and so on, then `H' = H + [p] M` and
    `I' = I + [p] H'^T + ([p] H^T)^T`.

    Args:
        A: (6, 6) symmetric.
        turns: about the parent's z, the new x, the new z.
        p: (3,) the origin from the parent's, in the parent's axes [m].
    """
    outer, middle, inner = turns
    I, H, M = (
        _about_z(_about_x(_about_z(block, *inner), *middle), *outer) for block in (A[:3, :3], A[:3, 3:], A[3:, 3:])
    )
    shift = skew(p)
    H_p = H + shift @ M
    I_p = _mirrored(I + shift @ H_p.T + (shift @ H.T).T)
    return np.block([[I_p, H_p], [H_p.T, M]])


def _about_z(B: Array, c: Scalar, s: Scalar) -> Array:
    """R B R^T for a turn R about z: the plane's trace and its antisymmetric part stay, the rest turns twice as far."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = B
    stretch, shear = xx - yy, xy + yx
    sine2, product = s * s, c * s
    e, g = sine2 * stretch + product * shear, product * stretch - sine2 * shear
    return np.array(
        (
            (xx - e, xy + g, c * xz - s * yz),
            (yx + g, yy + e, s * xz + c * yz),
            (c * zx - s * zy, s * zx + c * zy, zz),
        )
    )


def _about_x(B: Array, c: Scalar, s: Scalar) -> Array:
    return np.roll(_about_z(np.roll(B, -1, (0, 1)), c, s), 1, (0, 1))


def _mirrored(B: Array) -> Array:
    """The symmetric matrix with the upper triangle of B."""
    return np.array(((B[0, 0], B[0, 1], B[0, 2]), (B[0, 1], B[1, 1], B[1, 2]), (B[0, 2], B[1, 2], B[2, 2])))


def wrench_at_parent(b: Array, R: Array, p: Array) -> Array:
    """The same wrench (n, f) about the parent's origin in the parent's axes: `R n + p x R f`, `R f`."""
    f = R @ b[3:]
    return np.concatenate((R @ b[:3] + cross(p, f), f))


def acceleration_from_parent(x: Array, R: Array, p: Array) -> Array:
    """The parent's (wd, a) at the body's origin, in the body's axes: `R^T wd`, `R^T (a + wd x p)`."""
    return np.concatenate((R.T @ x[:3], R.T @ (x[3:] + cross(x[:3], p))))
