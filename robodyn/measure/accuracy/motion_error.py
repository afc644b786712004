"""How far a motion is from another one, as one number for angles, lengths, turns and rates; two simulations apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np

from robodyn.dynamics.recursions.momentum import position_rates
from robodyn.robot.model import Model
from robodyn.simulation.result import Simulation
from robodyn.support.floats import Floats

_ANGLE, _LENGTH, _TURN, _RATE, _SPEED = range(5)


@dataclass(frozen=True, eq=False)
class MotionError:
    """Differences of states (N, nq + n) relative to the largest number of their kind in a motion, `scale`.

    Kinds are angles, lengths, quaternions (whose largest is 1), angular and linear rates.
    """

    scale: Floats

    @classmethod
    def over(cls, model: Model, states: Floats) -> MotionError:
        """Args: states: (N, nq + n) of a motion that is nearly right."""
        q, qd = np.full(model.nq, _ANGLE), np.full(model.n, _RATE)
        for joint in model.independent:
            k, i = joint.coordinate, joint.rate
            if joint.kind == "floating":
                q[k : k + 3], q[k + 3 : k + 7], qd[i + 3 : i + 6] = _LENGTH, _TURN, _SPEED
            elif joint.kind == "prismatic":
                q[k], qd[i] = _LENGTH, _SPEED
        kinds = np.concatenate((q, qd))
        largest = np.abs(states).max(axis=0, initial=0.0)
        sizes = np.array([largest[kinds == kind].max(initial=0.0) for kind in range(5)])
        sizes[_TURN] = 1.0
        sizes[sizes == 0.0] = 1.0
        return cls(sizes[kinds])

    def __call__(self, found: Floats, expected: Floats) -> Floats:
        """Return (N,) the largest relative difference at each time; nan where a number is not finite."""
        off: Floats = (np.abs(found - expected) / self.scale).max(axis=1)
        return off


def between_records(motion: Simulation) -> Callable[[Floats], Floats]:
    """Return states (N, nq + n) at any times of a motion, by polynomials between those recorded.

    Of degree 7 where steps are of one length; else cubic ones with the slopes of the states, which stay between records
    that are far apart.
    """
    from scipy.interpolate import CubicHermiteSpline, make_interp_spline

    states = np.hstack((motion.q, motion.qd))
    if motion.step is None:
        slopes = position_rates(motion.model, list(motion.q.T), list(motion.qd.T))
        spline = CubicHermiteSpline(motion.time, states, np.column_stack((*slopes, motion.qdd)))
    else:
        degree = min(7, len(motion.time) - 1)
        spline = make_interp_spline(motion.time, states, k=degree - 1 + degree % 2)
    return lambda times: np.asarray(spline(times), dtype=float)


SEEN, SAME = 50, 1e-12
"""Records at which motions by different methods are compared; times nearer than this part of them are the same."""


def apart(coarse: Simulation, fine: Simulation) -> float:
    """Return how far a motion is from a finer one: at times that both record, up to a limit that ends either.

    Where there are few of these, at those of the coarser, between records of the other. inf where one ends at another
    limit than the other, or both are too short.
    """
    if coarse.ended.rpartition(" at ")[0] != fine.ended.rpartition(" at ")[0]:
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
    late = abs(float(coarse.time[-1] - fine.time[-1])) / float(fine.time[-1]) if coarse.ended else 0.0
    return max(float(off.max()), late)


def seen(motion: Simulation | None) -> list[float]:
    """Return times of some records of a motion, spread over it, at which another one is compared with it."""
    if motion is None:
        return []
    last = len(motion.time) - (2 if motion.ended else 1)
    rows = np.unique(np.linspace(0, max(last, 0), min(last, SEEN) + 1).astype(int))
    times: list[float] = motion.time[rows[1:]].tolist()
    return times


def states_of(motion: Simulation) -> Floats:
    return np.hstack((motion.q, motion.qd))
