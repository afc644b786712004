"""Euler's equations of a rigid body, for any scalar.

All vectors have components in one set of axes; the body's own are those in which I is constant. Velocities and
accelerations are those relative to an inertial frame.
"""

from __future__ import annotations

from robodyn.programs.vectors import Array, cross, vector


def euler(I: Array, w: Array, wd: Array) -> Array:
    """Return the moment I wd + w x (I w) that turns a body: Euler's second law about its mass centre or a fixed point.

    Expanded by entries of I, as Euler wrote it for principal axes: three factors of the off-diagonal entries are also
    entries of the acceleration matrix [wd] + [w][w], and the diagonal enters by differences, so a traced program needs
    30 operations for it where the two products and the cross product take 42, and few for a diagonal I.

    Args:
        I: (3, 3) symmetric inertia matrix [kg m^2]; w, wd: (3,) rad/s, rad/s^2; all in the body's axes.

    Returns:
        (3,) N m, in the body's axes.

    Accuracy: 8 eps (|I| |wd| + |I| |w|^2).
    """
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = I
    x, y, z = w
    dx, dy, dz = wd
    return vector(
        xx * dx + (zz - yy) * (y * z) - xy * (x * z - dy) + xz * (x * y + dz) + yz * (y * y - z * z),
        yy * dy + (xx - zz) * (x * z) - yz * (x * y - dz) + xy * (y * z + dx) + xz * (z * z - x * x),
        zz * dz + (yy - xx) * (x * y) - xz * (y * z - dx) + yz * (x * z + dy) + xy * (x * x - y * y),
    )


def acceleration_of_point(a_p: Array, r: Array, w: Array, wd: Array) -> Array:
    """Return the acceleration of the body's point at r from p: `a = a_p + wd x r + w x (w x r)`.

    Args:
        a_p: (3,) acceleration of the point p of the body [m/s^2].
        r: (3,) from p [m].
        w, wd: (3,) angular velocity and acceleration [rad/s, rad/s^2].

    Accuracy: 8 eps (|a_p| + |wd| |r| + |w|^2 |r|).
    """
    a: Array = a_p + cross(wd, r) + cross(w, cross(w, r))
    return a
