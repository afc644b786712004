"""Whether two texts describe the same dynamics, by computing both."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from robodyn.errors import InputError

if TYPE_CHECKING:
    from robodyn.robot.model import Model

STATES = 16
SAME = 64 * 2.0**-52
"""Of the largest torque: what rounding may make of the same dynamics."""


def change_of_dynamics(before: bytes, after: bytes) -> float:
    """Return max |tau' - tau| / max |tau| of inverse dynamics in random states; infinite where the coordinates differ.

    The base is free, so that its inertia counts, and positions, rates and accelerations are normally distributed with
    a variance of 1, from a fixed seed; both texts are given the same.

    Raises:
        InputError: one of the texts cannot be loaded, or is beyond what can be computed.

    Accuracy: of descriptions that differ in rounding alone, below `SAME`.
    """
    import numpy as np

    from robodyn.dynamics.inverse import inverse_dynamics
    from robodyn.robot.assemble import load

    old, new = load(before, moving_base=True), load(after, moving_base=True)
    if _coordinates(old) != _coordinates(new):
        return math.inf
    random = np.random.default_rng(0)
    q, qd, qdd = (random.standard_normal((STATES, count)) for count in (old.nq, old.n, old.n))
    torques = [inverse_dynamics(model, q, qd, qdd, executor="numpy") for model in (old, new)]
    largest, change = np.max(np.abs(torques[0])), np.max(np.abs(torques[1] - torques[0]))
    if change == 0:
        return 0.0
    ratio = float(change / largest) if largest > 0 else math.inf
    return ratio if math.isfinite(ratio) else math.inf


def unproven(before: bytes, after: bytes) -> str | None:
    """Return why it is not shown that both describe the same dynamics; None where it is."""
    try:
        change = change_of_dynamics(before, after)
    except InputError as error:
        return f"the dynamics cannot be computed: {error.what}"
    return None if change <= SAME else f"it changes the dynamics by {change:.2g} of the largest torque"


def _coordinates(model: Model) -> tuple[object, ...]:
    return model.rates, model.nq
