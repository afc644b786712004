"""How well the stiffness is known at an equilibrium that is known so well."""

from __future__ import annotations

import numpy as np

from robodyn.equations.linearized.equilibrium import newton_step
from robodyn.equations.linearized.static_balance import Balance, Standing
from robodyn.programs.vectors import product
from robodyn.support.floats import Floats

_STEPS = 4.0
"""Of Newton's, to be on the far side of an equilibrium: where two meet, at a fold, each of his goes half the way."""
_ROUNDED = 4.0 * float(np.finfo(float).eps)
_LONGEST = 0.1
"""rad, or the same part of the robot's reach [m]."""


def along(stiffness: Floats, directions: Floats, own: list[int]) -> Floats:
    """Return the stiffness (k, k) of the coordinates `own` of motions in these directions (n, k)."""
    N = np.linalg.solve(directions[own].T, directions.T).T
    return np.asarray(product(N.T, stiffness, N))


def stiffness_in_doubt(robot: Standing, q: Floats, here: Balance, own: list[int]) -> Floats:
    """Return how the stiffness (k, k) changes on the way to where the equilibrium may be, which is off by what is
    missing and by rounding: next to nothing, but near a fold, where a stable equilibrium meets an unstable one."""
    missing = np.where(np.abs(here.missing) < _ROUNDED * here.scale, _ROUNDED * here.scale, here.missing)
    step = _STEPS * newton_step(robot, here._replace(missing=missing))
    step /= max(1.0, float(np.abs(step / robot.lengths).max(initial=0.0)) / _LONGEST)
    if (there := robot.moved(q, step)) is None:
        return np.zeros((len(own), len(own)))
    other = robot.balance(there)
    return along(other.stiffness, other.directions, own) - along(here.stiffness, here.directions, own)
