"""Small motions about a state, as equations of second order and of first."""

from __future__ import annotations

from typing import NamedTuple

from robodyn.support.floats import Floats


class SmallMotion(NamedTuple):
    """M dx'' + damping dx' + stiffness dx = directions^T u, drives closed; z' = A z + B u with z = (dx, dx').

    Attributes:
        directions: (n, k) how all joints move with x; without loops the unit matrix.
        M, damping, stiffness: (k, k).
        doubt: (k, k) by how much the stiffness may be another where an equilibrium is off.
        A, B: (2 k, 2 k), (2 k, n).
        inertia: (n,) of each joint, the others at rest [kg m^2 or kg].
        weight: (k,) the stiffness that the weight can make at each coordinate at most [N m or N/m].
        condition: number of M, scaled to a unit diagonal.
        at_rest: whether the state is one.
    """

    directions: Floats
    M: Floats
    damping: Floats
    stiffness: Floats
    doubt: Floats
    A: Floats
    B: Floats
    inertia: Floats
    weight: Floats
    condition: float
    at_rest: bool
