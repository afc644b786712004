"""The laws of inertia matrices: the parallel axis theorem and the inertia rotation law."""

from __future__ import annotations

import numpy as np

from robodyn.errors import InputError
from robodyn.programs.vectors import IDENTITY, Array, product
from robodyn.solids.inertia.moments import inertia_of

_ORTHOGONAL = 1e-9


def parallel_axis(I_c: Array, m: float, d: Array) -> Array:
    """I = I_c + m (|d|^2 1 - d d^T), the inertia about a point at distance d from the centre of mass.

    The parallel axis theorem of Huygens and Steiner, as `robodyn.solids.inertia.moments.inertia_of` has it for a whole
    pose.

    Args:
        I_c: (3, 3) about the centre of mass [kg m^2].
        m: kg.
        d: (3,) from the point to the centre of mass or back, in the axes of I_c [m].

    Accuracy: each entry within 16 eps of the sum of the magnitudes that add up to it.
    """
    return inertia_of(m, d, I_c).I


def about_centre(I: Array, m: float, d: Array) -> Array:
    """I_c = I - m (|d|^2 1 - d d^T), the parallel axis theorem backwards: from a point to the centre of mass.

    Args:
        I: (3, 3) about the point [kg m^2].
        m, d: as for `parallel_axis`.

    Accuracy: each entry within 16 eps of the sum of the magnitudes that add up to it; most digits go where the body is
        small against d.
    """
    return parallel_axis(I, -m, d)


def rotation_law(I: Array, R: Array) -> Array:
    """R I R^T, the inertia matrix in the outer axes of a frame that stands at rotation R in them.

    With R^T it leads from the outer axes to the frame's.

    Accuracy: each entry within 16 eps of the sum of the magnitudes that add up to it, for R as given.
    """
    turned: Array = product(R, I, R.T)
    return turned


def orthogonal(R: Array) -> Array:
    """R, if its rows are orthonormal within 1e-9.

    Raises:
        InputError: with the largest entry of R R^T - 1.
    """
    error = np.abs(product(R, R.T) - IDENTITY).max() if np.shape(R) == (3, 3) else np.inf
    if not error <= _ORTHOGONAL:
        raise InputError(
            f"the rotation is not orthogonal: R R^T differs from 1 by {error:.3g}",
            remedy="give a 3 x 3 matrix to all its digits, as robodyn.programs.vectors.rotation_from_rpy does",
        )
    return R
