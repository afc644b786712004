"""Principal moments and axes of inertia, and which of the axes are not unique."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robodyn.programs.linear import eigen
from robodyn.programs.vectors import IDENTITY, Array, cross, length, product
from robodyn.solids.inertia.laws import exact, principal_moments, rounded
from robodyn.support.floats import Floats, first_largest

EQUAL = 1e-9


@dataclass(frozen=True, eq=False)
class Principal:
    """Principal moments of inertia about one point, in ascending order.

    Attributes:
        moments: (3,) kg m^2.
        axes: (3, 3) the unit axes as rows, right-handed: I = axes^T diag(moments) axes.
        second: (3,) second moments along the axes [kg m^2]; moments[i] is the sum of the two others of these.
        groups: numbers of the axes whose moments are equal; the rows of a group span an invariant subspace, any
            orthonormal basis of which is as good as the one given.
        tolerance: what "equal" means, relative to the largest moment.
    """

    moments: Floats
    axes: Floats
    second: Floats
    groups: tuple[tuple[int, ...], ...]
    tolerance: float

    def __post_init__(self) -> None:
        for array in (self.moments, self.axes, self.second):
            array.flags.writeable = False

    @property
    def unique(self) -> bool:
        """Whether the three moments differ, so that the axes are unique but for their signs."""
        return len(self.groups) == 3

    @property
    def remark(self) -> str | None:
        """Which axes are not unique, in words; None where all are."""
        if self.unique:
            return None
        equal = f"equal within {self.tolerance:g}"
        if len(self.groups) == 1:
            return f"all principal moments are {equal}: every axis is principal"
        (lone,) = (group[0] for group in self.groups if len(group) == 1)
        ((first, other),) = (group for group in self.groups if len(group) == 2)
        along = ", ".join(f"{x:.6g}" for x in self.axes[lone])
        return (
            f"principal moments {first + 1} and {other + 1} are {equal}: "
            f"every axis normal to axis {lone + 1} = ({along}) is principal"
        )


def principal_axes(S: Array, S_low: Array | float = 0.0, tolerance: float = EQUAL) -> Principal:
    """Principal moments and axes of the second moments S + S_low: I v_i = I_i v_i with I = tr(S) 1 - S.

    Method: Jacobi's, in floats; then once more on the matrix seen from the axes found, which is computed in fractions.
    That matrix is diagonal but for rounding, so that its small entries are as accurate as its large ones.

    Unique axes point so that their largest component is positive, the last so that they are right-handed. Of equal
    moments the axes follow the coordinate axes: all three are these, or the first of two is the projection of the
    coordinate axis nearest to their plane.

    Args:
        S: (3, 3) kg m^2, floats or fractions.
        S_low: (3, 3) what floats leave of it.
        tolerance: moments are equal if they differ by no more than this part of the largest.

    Accuracy: each principal moment and second moment within 16 eps of that of the matrix as given, however small, if
        it is positive definite with second moments down to 1e-20 of the largest. Axes orthonormal within 8 eps, and
        axes I axes^T diagonal within 16 eps of the largest moment, where no two are counted as equal.
    """
    given = exact(S) + exact(S_low)
    _, rough = eigen(rounded(given))
    second, correction = eigen(rounded(product(exact(rough), given, exact(rough).T)))
    moments = principal_moments(second)
    within, equal = tolerance * np.abs(moments).max(), [[0]]
    for i in (1, 2):
        if second[i - 1] - second[i] <= within:
            equal[-1].append(i)
        else:
            equal.append([i])
    groups = tuple(map(tuple, equal))
    return Principal(moments, _oriented(product(correction, rough), groups) + 0.0, second, groups, tolerance)


def _oriented(axes: Floats, groups: tuple[tuple[int, ...], ...]) -> Floats:
    if len(groups) == 1:
        return IDENTITY.copy()
    if len(groups) == 3:
        first, second = pointed(axes[0]), pointed(axes[1])
        return np.array((first, second, cross(first, second)))
    lone_first = len(groups[0]) == 1
    lone = pointed(axes[0 if lone_first else 2])
    nearest = IDENTITY[first_largest(-np.abs(lone), noise=EQUAL)]
    projection = nearest - lone * product(lone, nearest)
    first = projection / length(projection)
    second = cross(lone, first)
    return np.array((lone, first, second) if lone_first else (first, second, lone))


def pointed(axis: Floats) -> Floats:
    """Return the axis or its opposite, with the largest component (the first of several) positive."""
    return np.asarray(axis * np.sign(axis[first_largest(np.abs(axis))]), dtype=float)
