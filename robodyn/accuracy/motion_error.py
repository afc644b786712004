"""How far a motion is from another one: one number for angles, lengths, turns and their rates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robodyn.model import Model
from robodyn.simulation.result import Simulation

Floats = NDArray[np.float64]
_ANGLE, _LENGTH, _TURN, _RATE, _SPEED = range(5)


@dataclass(frozen=True, eq=False)
class MotionError:
    """Differences of states (N, nq + n) relative to the largest number of their kind in a motion.

    Kinds are angles, lengths, quaternions (whose largest is 1), angular and linear rates.

    Attributes:
        scale: (nq + n,).
    """

    scale: Floats

    @classmethod
    def over(cls, model: Model, states: Floats) -> MotionError:
        """Args: states: (N, nq + n) of a motion that is nearly right."""
        kinds = _kinds(model)
        largest = np.abs(states).max(axis=0, initial=0.0)
        sizes = np.array([largest[kinds == kind].max(initial=0.0) for kind in range(5)])
        sizes[_TURN] = 1.0
        sizes[sizes == 0.0] = 1.0
        return cls(sizes[kinds])

    def __call__(self, found: Floats, expected: Floats) -> Floats:
        """(N,) the largest relative difference at each time; nan where a number is not finite."""
        off: Floats = (np.abs(found - expected) / self.scale).max(axis=1)
        return off


def between_records(motion: Simulation) -> Callable[[Floats], Floats]:
    """States (N, nq + n) at any times of a motion, by polynomials of degree 7 between those recorded."""
    from scipy.interpolate import make_interp_spline

    degree = min(7, len(motion.time) - 1)
    degree -= 1 - degree % 2
    spline = make_interp_spline(motion.time, np.hstack((motion.q, motion.qd)), k=degree)
    return lambda times: np.asarray(spline(times), dtype=float)


def _kinds(model: Model) -> NDArray[np.int64]:
    q, qd = np.full(model.nq, _ANGLE), np.full(model.n, _RATE)
    for joint in model.independent:
        k, i = joint.coordinate, joint.rate
        if joint.kind == "floating":
            q[k : k + 3], q[k + 3 : k + 7], qd[i + 3 : i + 6] = _LENGTH, _TURN, _SPEED
        elif joint.kind == "prismatic":
            q[k], qd[i] = _LENGTH, _SPEED
    return np.concatenate((q, qd))
