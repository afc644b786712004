"""Three-vectors and rotations whose entries may be any scalar.

A scalar is whatever has +, -, *, /: a float, an `mpmath.mpf`, a SymPy expression, a traced scalar.
Vectors have shape (3,) and matrices (3, 3); their dtype is float64 for floats and object for every other scalar.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats, einsum

Array = NDArray[Any]
"""A NumPy array of any scalar."""

Scalar = Any
"""Any scalar; see the module's docstring."""

Arrays = TypeVar("Arrays", bound=tuple[Array, ...])
"""A named tuple of arrays."""

ZERO = np.zeros(3)
ZERO.flags.writeable = False
IDENTITY = np.eye(3)
IDENTITY.flags.writeable = False
_SUMS = ("j,j->", "j,...jk->...k"), ("...ij,j->...i", "...ij,...jk->...ik")


def _elementary(name: str, of_float: Callable[[float], float]) -> Callable[[Scalar], Scalar]:
    def function(x: Scalar) -> Scalar:
        if isinstance(x, (float, int)):
            return of_float(x)
        context = getattr(x, "context", None)  # mpmath's numbers carry their precision here, and an `exp` that is none
        if context is not None:
            return getattr(context, name)(x)
        own = getattr(x, name, None)
        if own is not None:
            return own()
        import sympy

        return getattr(sympy, name)(x)

    function.__name__ = name
    function.__doc__ = f"{name}(x) for any scalar."
    return function


sin = _elementary("sin", math.sin)
cos = _elementary("cos", math.cos)
exp = _elementary("exp", math.exp)
sqrt = _elementary("sqrt", math.sqrt)
sign = _elementary("sign", lambda x: float(x > 0) - float(x < 0))


def vector(x: Scalar, y: Scalar, z: Scalar) -> Array:
    return np.array((x, y, z))


def product(*factors: Array) -> Any:
    """Return the product of factors (k,), (m, k) or (..., m, k), like `A @ B`, summed in the same order everywhere.

    On float64 `A @ B` is BLAS, whose order of sums, and with it the last digit, depends on the processor. On any other
    scalar NumPy itself multiplies, in order; so do recursions, which say `A @ B` for all scalars.
    """
    A: Any = factors[0]
    for B in factors[1:]:
        objects = A.dtype.hasobject or B.dtype.hasobject
        A = A @ B if objects else einsum(_SUMS[A.ndim > 1][B.ndim > 1], A, B)
    return A


def narrowed(x: Array) -> Array:
    """Return the array in float64 where its entries are floats, as recursions leave them, else as it is."""
    return np.array(x.tolist()).reshape(x.shape)


def narrowed_all(places: Iterable[Arrays]) -> list[Arrays]:
    """Return the same tuples of arrays, each of these `narrowed`."""
    return [type(place)(*map(narrowed, place)) for place in places]


def length(x: Array) -> float:
    """Return the 2-norm of a few floats, summed in order."""
    return float(np.sqrt((x * x).sum()))


def arctan2(y: Array, x: Array) -> Array:
    """Return the angles of points (n,), by the C library: NumPy's own function ends in other digits with AVX-512."""
    return np.fromiter(map(math.atan2, y.tolist(), x.tolist()), float, len(y))


def frame(axis: Floats) -> Floats:
    """Return (3, 3) rows u, v and the axis, right-handed. u and v are the coordinate axes that follow the axis in x, y,
    z, x if it is along one of them (-v if it is against it); otherwise u is at right angles to the axis and to the
    coordinate axis that it is furthest from."""
    along = np.abs(axis)
    if along.max() == 1.0:
        k = int(along.argmax())
        u = np.roll(np.eye(3)[k], 1)
    else:
        u = np.cross(axis, np.eye(3)[int(along.argmin())])
        u /= length(u)
    return np.array([u, np.cross(axis, u), axis])


def total(values: Iterable[Scalar]) -> Scalar:
    """Return the sum, from left to right; 0.0 for none."""
    out: Scalar = 0.0
    for value in values:
        out = out + value
    return out


def cross(a: Array, b: Array) -> Array:
    a1, a2, a3 = a
    b1, b2, b3 = b
    return np.array((a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1), dtype=np.result_type(a, b))


def skew(a: Array) -> Array:
    x, y, z = a
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)), dtype=np.result_type(a, float))


def rotation_about(axis: Array, angle: Scalar) -> Array:
    """Rotation by `angle` [rad] about the unit vector `axis`: a a^T + cos (1 - a a^T) + sin [a] (Rodrigues). Written so
    that the entries for a coordinate axis are exactly 0, 1, cos and +-sin. Accuracy: each entry within 4 eps for a unit
    axis."""
    along = np.outer(axis, axis)
    R: Array = along + (IDENTITY - along) * cos(angle) + skew(axis) * sin(angle)
    return R


def rotation_from_quaternion(x: Scalar, y: Scalar, z: Scalar, w: Scalar) -> Array:
    """Rotation of the quaternion w + x i + y j + z k of any length but zero (homogeneous form). Accuracy: each entry
    within 8 eps."""
    s = 2.0 / (x * x + y * y + z * z + w * w)
    sx, sy, sz = s * x, s * y, s * z
    xx, yy, zz = sx * x, sy * y, sz * z
    xy, xz, yz = sx * y, sx * z, sy * z
    wx, wy, wz = sx * w, sy * w, sz * w
    return np.array(
        (
            (1.0 - (yy + zz), xy - wz, xz + wy),
            (xy + wz, 1.0 - (xx + zz), yz - wx),
            (xz - wy, yz + wx, 1.0 - (xx + yy)),
        )
    )


def rotation_from_rpy(roll: float, pitch: float, yaw: float) -> Floats:
    """URDF's fixed-axis rotation Rz(yaw) Ry(pitch) Rx(roll) [rad].

    Entries within one rounding of 0, 1 or -1 are made exact: a right angle written as 1.5707963267948966 is then a
    permutation of axes, and a recursion that folds zeros and ones sees it.

    Accuracy: each entry within 4 eps.
    """
    return _rotation(roll, pitch, yaw).copy()


def rpy_from_rotation(R: Floats) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a rotation; where the pitch is a right angle, one of many. Accuracy:
    `rotation_from_rpy` gives the rotation back within 8 eps."""
    yaw = math.atan2(R[1, 0], R[0, 0])
    left = product(rotation_from_rpy(0.0, 0.0, -yaw), R)
    return math.atan2(-left[1, 2], left[1, 1]), math.atan2(-left[2, 0], left[0, 0]), yaw


@lru_cache(maxsize=4096)
def _rotation(roll: float, pitch: float, yaw: float) -> Floats:
    """Most angles of a description are met again and again; of -0 all entries are those of 0."""
    cr, sr, cp, sp, cy, sy = (f(angle) for angle in (roll, pitch, yaw) for f in (math.cos, math.sin))
    rows = (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )
    return snapped(np.array(rows))


def snapped(R: Floats) -> Floats:
    """`R` with the entries that lie within one rounding (2^-52) of 0, 1 or -1 replaced by exactly these."""
    nearest = np.round(R)
    return np.where(np.abs(R - nearest) <= 2.0**-52, nearest, R) + 0.0
