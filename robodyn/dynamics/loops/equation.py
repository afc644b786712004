"""The equations of a closure: what must be zero, as linear functions of one link's place in the axes of the other."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import IDENTITY, Array, Scalar, cross, product, rotation_from_rpy, skew, snapped
from robodyn.scene.parts import Loop
from robodyn.support.floats import Floats


class Equation(NamedTuple):
    """`D . d + sum_ij E_ij B_ij = 0` for the point at d and the axes B of the link, both in the axes of the other.

    Being linear in d and B it gives its rates from theirs: `D . v + E : [w] B`, and so on.

    Attributes:
        D, E: (3,), (3, 3).
        unit: "m" or "rad".
        about: what it holds, in a few words.
    """

    D: Floats
    E: Floats
    unit: str
    about: str

    def of(self, d: Array, B: Array) -> Scalar:
        """Return the left side."""
        value: Scalar = product(self.D, d)
        return value + (self.E * B).sum() if self.E.any() else value

    def force(self) -> Floats:
        """Return (3,) on the link, in the axes of the other, for lambda = 1."""
        return self.D

    def moment(self, B: Array) -> Array:
        """Return (3,) on the link about its point, in the axes of the other, for lambda = 1: `n_j = E : [e_j] B`."""
        return np.array([(self.E * product(skew(axis), B)).sum() for axis in IDENTITY])


def equations_of(loop: Loop) -> tuple[Equation, ...]:
    """Return all equations of a closure: those of the point, then those of the axes.

    A point is held along three axes, or along the loop's directions. A hinge moreover keeps its axis s across two
    vectors t that stand across the hinge's axis in the other link: `t . B s = 0`. A weld keeps the turn `X = B R^T`
    from its own R symmetric, which near no turn is none: `(X_32 - X_23) / 2 = 0` and so on.
    """
    along = [_unit(direction) for direction in loop.directions] or list(IDENTITY)
    held = [Equation(D, np.zeros((3, 3)), "m", f"along {_shown(D)}") for D in along]
    if loop.kind == "hinge":
        s = _unit(loop.axis)
        held += [Equation(np.zeros(3), np.outer(t, s), "rad", f"axis across {_shown(t)}") for t in _across(loop)]
    if loop.kind == "weld":
        R = rotation_from_rpy(*loop.rpy)
        for i, axis in enumerate(IDENTITY):
            j, k = (i + 1) % 3, (i + 2) % 3
            E = 0.5 * (np.outer(IDENTITY[k], R[j]) - np.outer(IDENTITY[j], R[k]))
            held.append(Equation(np.zeros(3), E, "rad", f"turn about {_shown(axis)}"))
    return tuple(held)


def _across(loop: Loop) -> tuple[Floats, Floats]:
    """Return two vectors across the hinge's axis in the other link, along coordinate axes where it is along one."""
    s = _unit(loop.to_axis)
    t = np.roll(IDENTITY[int(np.argmax(np.abs(s)))], 1)
    t = _unit(t - s * product(s, t))
    return t, snapped(cross(s, t))


def _unit(values: object) -> Floats:
    x = np.asarray(values, dtype=float)
    return snapped(x / np.sqrt(product(x, x)))


def _shown(axis: Floats) -> str:
    for name, one in zip("xyz", IDENTITY, strict=True):
        if np.array_equal(np.abs(axis), one):
            return name
    return f"({', '.join(f'{x:.3g}' for x in axis)})"
