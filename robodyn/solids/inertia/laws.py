"""Inertia matrices, second and first moments, the parallel axis theorem, the rotation law; fractions for them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import InputError
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, product, skew
from robodyn.support.floats import Floats


def exact(numbers: ArrayLike) -> Array:
    """Return floats of any width, integers or fractions as an array of fractions; InputError if one is not finite."""
    from fractions import Fraction

    given = np.asarray(numbers)
    try:
        fractions = [Fraction(*number.as_integer_ratio()) for number in given.ravel().tolist()]
    except (ValueError, OverflowError):
        raise InputError("a number of the mass properties is infinite or not a number") from None
    return np.array(fractions, dtype=object).reshape(given.shape)


def fraction(number: ArrayLike) -> Scalar:
    """Return the same number as a fraction; raises what `exact` does."""
    return exact(number).item()


def rounded(fractions: Array) -> Floats:
    """Return the nearest floats; raises InputError where one is beyond the range of a float."""
    try:
        return fractions.astype(float)
    except OverflowError:
        raise InputError("a mass property exceeds 1.8e308", remedy="use metres and kilograms") from None


def symmetric(entries: Iterable[Scalar]) -> Array:
    """Return the matrix of ixx, ixy, ixz, iyy, iyz, izz."""
    xx, xy, xz, yy, yz, zz = entries
    return np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))


def inertia_matrix(S: Floats) -> Floats:
    """I = tr(S) 1 - S, the inertia matrix of second moments S = integral of x x^T dm about the same point. Accuracy:
    each entry within eps / 2."""
    I = 0.0 - S  # diagonal entries are sums of two, so that those of a needle keep their digits
    for i in range(3):
        I[i, i] = S[i - 1, i - 1] + S[i - 2, i - 2]
    return I


def principal_moments(second: Floats) -> Floats:
    """I_1 = s_2 + s_3, I_2 = s_1 + s_3, I_3 = s_1 + s_2: ascending, of second moments along principal axes descending.
    Accuracy: each within eps / 2."""
    return np.array([second[i - 2] + second[i - 1] for i in range(3)])


def second_moments(I: Array) -> Array:
    """S = tr(I) / 2 1 - I, the inverse of `inertia_matrix`. Accuracy: exact for fractions; of floats each entry within
    2 eps of the largest moment of inertia."""
    half = I / 2
    S: Array = 0 * I - I
    for i in range(3):
        S[i, i] = half[i - 1, i - 1] + half[i - 2, i - 2] - half[i, i]
    return S


class Inertia(NamedTuple):
    """Mass [kg], first moment [kg m] and inertia matrix [kg m^2] of a body about the origin of its axes, in these."""

    m: Scalar
    mc: Array
    I: Array

    @property
    def centre_of_mass(self) -> Array:
        """c = mc / m [m]; the origin where there is no mass."""
        return self.mc / self.m if self.m else ZERO

    @property
    def about_centre(self) -> Array:
        """The inertia matrix about the centre of mass, in the same axes [kg m^2]."""
        return about_centre(self.I, self.m, self.centre_of_mass)


MASSLESS = Inertia(0.0, ZERO, np.zeros((3, 3)))


def inertia_of(m: Scalar, c: Array, I_c: Array, R: Array = IDENTITY, p: Array = ZERO) -> Inertia:
    """Return the moments of a body whose frame stands at rotation R and origin p, about the origin of the outer frame.

    With c' = R c + p: `m`, `m c'`, `R I_c R^T - m [c'][c']`, the inertia rotation law and the parallel axis theorem.

    Args:
        c: (3,) centre of mass in the body's frame [m].
        I_c: (3, 3) inertia matrix about the centre of mass, in the body's axes [kg m^2].

    Accuracy: each entry within 16 eps of the sum of the magnitudes that add up to it.
    """
    centre, turned = product(R, c) + p, product(R, I_c, R.T)
    return Inertia(m, m * centre, turned - m * product(skew(centre), skew(centre)))


def combined(bodies: Iterable[Inertia]) -> Inertia:
    """Return the moments of several bodies fixed to each other, all given in the same frame: their sums."""
    m, mc, I = MASSLESS
    for body in bodies:
        m, mc, I = m + body.m, mc + body.mc, I + body.I
    return Inertia(m, mc, I)


def parallel_axis(I_c: Array, m: Scalar, d: Array) -> Array:
    """I = I_c + m (|d|^2 1 - d d^T), the inertia about a point at distance d from the centre of mass. The parallel axis
    theorem of Huygens and Steiner; d (3,) [m] and I_c (3, 3) [kg m^2] in the same axes."""
    return inertia_of(m, d, I_c).I


def about_centre(I: Array, m: Scalar, d: Array) -> Array:
    """I_c = I - m (|d|^2 1 - d d^T), `parallel_axis` backwards: most digits go where the body is small against d."""
    return parallel_axis(I, -m, d)


def rotation_law(I: Array, R: Array) -> Array:
    """R I R^T, the inertia matrix in the outer axes of a frame that stands at rotation R in them; R^T leads back."""
    turned: Array = product(R, I, R.T)
    return turned


def orthogonal(R: Array) -> Array:
    """R, if its rows are orthonormal within 1e-9; raises InputError, with the largest entry of R R^T - 1, if not."""
    error = np.abs(product(R, R.T) - IDENTITY).max() if np.shape(R) == (3, 3) else np.inf
    if not error <= 1e-9:
        raise InputError(
            f"the rotation is not orthogonal: R R^T differs from 1 by {error:.3g}",
            remedy="give a 3 x 3 matrix to all its digits, as robodyn.programs.vectors.rotation_from_rpy does",
        )
    return R
