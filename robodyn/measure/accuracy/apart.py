"""How far two simulations of one motion are apart, at times that both record and where they end."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from robodyn.measure.accuracy.motion_error import MotionError, between_records
from robodyn.simulation.result import Simulation

Floats = NDArray[np.float64]
SEEN = 50
"""Records at which motions by different methods are compared."""
SAME = 1e-12
"""Times nearer than this part of them are the same."""


def apart(coarse: Simulation, fine: Simulation) -> float:
    """How far a motion is from a finer one: at times that both record, up to a limit that ends either.

    Where there are few of these, at those of the coarser, between records of the other. inf where one ends at another
    limit than the other, or both are too short.
    """
    if _limit(coarse) != _limit(fine):
        return inf
    end = min(coarse.time[-1], fine.time[-1])
    rows = np.flatnonzero(coarse.time < end if coarse.ended else coarse.time <= end)
    if len(rows) < 2:
        return inf
    times, states = coarse.time[rows], states_of(fine)
    near = np.searchsorted(fine.time, times * (1.0 - SAME))
    shared = np.abs(fine.time[near] - times) <= SAME * times
    few = shared.sum() < 0.5 * min(len(rows), SEEN)
    expected = between_records(fine)(times) if few else states[near[shared]]
    off = MotionError.over(fine.model, states)(states_of(coarse)[rows if few else rows[shared]], expected)
    return max(float(off.max()), _late(coarse, fine))


def seen(motion: Simulation | None) -> list[float]:
    """Times of some records of a motion, spread over it, at which another one is compared with it."""
    if motion is None:
        return []
    last = len(motion.time) - (2 if motion.ended else 1)
    rows = np.unique(np.linspace(0, max(last, 0), min(last, SEEN) + 1).astype(int))
    times: list[float] = motion.time[rows[1:]].tolist()
    return times


def _late(one: Simulation, other: Simulation) -> float:
    """By how much of the time two motions end apart."""
    return abs(float(one.time[-1] - other.time[-1])) / float(other.time[-1]) if one.ended else 0.0


def _limit(motion: Simulation) -> str:
    """The limit that ends a motion."""
    return motion.ended.rpartition(" at ")[0]


def states_of(motion: Simulation) -> Floats:
    return np.hstack((motion.q, motion.qd))
