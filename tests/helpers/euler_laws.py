"""Euler's two laws for one rigid body, the second in each of its forms, for any scalar.

All vectors have components in one set of axes; the body's own are those in which I is constant. Velocities and
accelerations are those relative to an inertial frame.
"""

from __future__ import annotations

from robodyn.dynamics.recursions.newton_euler import euler
from robodyn.programs.vectors import Array, Scalar, cross, product, skew


def first_law(m: Scalar, a_c: Array) -> Array:
    """Euler's first law: the resultant force is `F = m a_c`, a_c being the acceleration of the mass centre."""
    F: Array = m * a_c
    return F


def about_fixed_point(I_o: Array, w: Array, wd: Array) -> Array:
    """Euler's second law about a point o of the body that is fixed in space: `M_o = I_o wd + w x I_o w`.

    Args:
        I_o: (3, 3) inertia matrix about o [kg m^2].
        w, wd: (3,) rad/s, rad/s^2.

    Returns:
        (3,) the resultant moment about o [N m].

    Accuracy: 8 eps (|I| |wd| + |I| |w|^2).
    """
    return euler(I_o, w, wd)


def about_mass_centre(I_c: Array, w: Array, wd: Array) -> Array:
    """Euler's second law about the mass centre, however it moves: `M_c = I_c wd + w x I_c w`.

    Args, returns and accuracy: as for `about_fixed_point`, with the inertia matrix about the mass centre.
    """
    return euler(I_c, w, wd)


def about_body_point(I_p: Array, w: Array, wd: Array, m: Scalar, r: Array, a_p: Array) -> Array:
    """Euler's second law about any point p of the body: `M_p = I_p wd + w x I_p w + m r x a_p`.

    The last term vanishes at a fixed point (a_p = 0), at the mass centre (r = 0), and where a_p points along r.

    Args:
        I_p: (3, 3) inertia matrix about p [kg m^2].
        m: kg.
        r: (3,) the mass centre from p, c - p [m].
        a_p: (3,) acceleration of p [m/s^2].

    Accuracy: 8 eps (|I| |wd| + |I| |w|^2 + m |r| |a_p|).
    """
    M_p: Array = euler(I_p, w, wd) + m * cross(r, a_p)
    return M_p


def moment_about(M: Array, F: Array, r: Array) -> Array:
    """The moment about p of a system of forces with the moment M about another point, r from p: `M_p = M + r x F`."""
    return M + cross(r, F)


def inertia_about(I_c: Array, m: Scalar, r: Array) -> Array:
    """Return the inertia matrix about a point from which the mass centre is at r: `I_c - m [r][r]` (parallel axes)."""
    I: Array = I_c - m * product(skew(r), skew(r))
    return I


def inertia_about_centre(I_p: Array, m: Scalar, r: Array) -> Array:
    """Return the inertia matrix about the mass centre from that about p, r being c - p: `I_p + m [r][r]`."""
    I: Array = I_p + m * product(skew(r), skew(r))
    return I


def angular_momentum(I_p: Array, w: Array, m: Scalar, r: Array, v_p: Array) -> Array:
    """The angular momentum about a point p of the body: `H_p = I_p w + m r x v_p`, v_p being the velocity of p."""
    H: Array = I_p @ w + m * cross(r, v_p)
    return H
