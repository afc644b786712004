"""How far derived accelerations can be trusted: their error bars, and what too few samples leave open beyond them."""

from __future__ import annotations

import numpy as np

from robodyn.support.floats import Floats
from robodyn.trajectory.derive import Plan, straight
from robodyn.trajectory.estimates import NOISY
from robodyn.trajectory.motion import FEW, Sampling, Trajectory


def sampling(samples: Trajectory, plan: Plan, noise: Floats, off: Floats, rows: slice) -> Sampling:
    """Return by how much derived accelerations of some rows may be off.

    In a table of fewer than 24 rows, any motion that rests in every row is within the bars.

    Args:
        samples: a block, derived, with its neighbours; noise, off: of its derived accelerations (N, n).
    """
    if few := len(samples) < FEW:
        off = np.maximum(off, _guess(samples, plan) + np.abs(samples.qdd))
    off[:, _given(plan, off.shape[1])] = 0.0
    off, noise, qdd = off[rows], noise[rows], samples.qdd[rows]
    with np.errstate(over="ignore"):
        off_squares, squares = ((values**2).sum(axis=0) for values in (off, qdd))
    if len(samples) >= NOISY:
        off_squares[_noisy(plan)] = 0.0
    guessed = few and any(group.velocity for group in plan.groups)
    return Sampling(off, noise, off_squares, squares, guessed)


def _given(plan: Plan, width: int) -> list[int]:
    """Return the columns of qdd that are not derived."""
    derived = {column for group in plan.groups for _, column in group.acceleration}
    return [column for column in range(width) if column not in derived]


def _noisy(plan: Plan) -> list[int]:
    """Return the columns of qdd whose errors come of noise, not of the number of samples."""
    pairs = zip(plan.groups, plan.trusts, strict=True)
    return [column for group, trust in pairs if trust.noisy for _, column in group.acceleration]


def _guess(samples: Trajectory, plan: Plan) -> Floats:
    """Return (N, n) the largest accelerations of a motion that rests in every row: 6 |dq| / h^2, 2 |dqd| / h."""
    guess, steps = np.zeros_like(samples.qdd), np.diff(samples.time)[:, None]
    for group in plan.groups:
        moved = np.abs(np.diff(straight(group, samples), axis=0))
        if group.kind == "quaternion":
            moved = 2.0 * np.sqrt((moved**2).sum(axis=1, keepdims=True)) * np.ones(3)
        needed = 2.0 * moved / steps if group.source == "qd" else 6.0 * moved / steps**2
        for component, column in group.acceleration:
            guess[:-1, column] = needed[:, component]
            guess[1:, column] = np.maximum(guess[1:, column], needed[:, component])
    return guess
