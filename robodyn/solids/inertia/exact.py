"""Fractions, which add and multiply without rounding, and their storage as the sum of two floats."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import InputError
from robodyn.programs.vectors import Array, Scalar
from robodyn.support.floats import Floats


def exact(numbers: ArrayLike) -> Array:
    """Return the same numbers as an array of fractions.

    Args:
        numbers: floats of any width, integers or fractions, of any shape.

    Raises:
        InputError: one of them is infinite or not a number.
    """
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
    """Return the nearest floats.

    Raises:
        InputError: one of them is beyond the range of a float.

    Accuracy: correctly rounded.
    """
    try:
        return fractions.astype(float)
    except OverflowError:
        raise InputError("a mass property exceeds 1.8e308", remedy="use metres and kilograms") from None


def two_floats(fractions: Array) -> tuple[Floats, Floats]:
    """Return the nearest floats, and the floats nearest to what they leave.

    Accuracy: their sum within 2^-106 of each number, where the rest is not below the range of a float.
    """
    high = rounded(fractions)
    return high, rounded(fractions - exact(high))
