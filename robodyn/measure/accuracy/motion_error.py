"""How far a motion is from another one: one number for angles, lengths, turns and their rates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robodyn.robot.model import Model
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
    """States (N, nq + n) at any times of a motion, by polynomials between those recorded.

    Of degree 7 where steps are of one length; else cubic ones with the slopes of the states, which stay between records
    that are far apart.
    """
    from scipy.interpolate import CubicHermiteSpline, make_interp_spline

    states = np.hstack((motion.q, motion.qd))
    if motion.step is None:
        spline = CubicHermiteSpline(motion.time, states, np.hstack((_slopes(motion), motion.qdd)))
    else:
        degree = min(7, len(motion.time) - 1)
        spline = make_interp_spline(motion.time, states, k=degree - 1 + degree % 2)
    return lambda times: np.asarray(spline(times), dtype=float)


def _slopes(motion: Simulation) -> Floats:
    """(N, nq) the rates of positions; of a quaternion h those of `h (w / 2)`, w along the body's axes."""
    slopes = np.zeros_like(motion.q)
    for joint in motion.model.independent:
        k, i = joint.coordinate, joint.rate
        if joint.kind == "floating":
            w, x = 0.5 * motion.qd[:, i : i + 3], motion.q[:, k + 3 : k + 7]
            slopes[:, k : k + 3] = motion.qd[:, i + 3 : i + 6]
            slopes[:, k + 3 : k + 6] = x[:, 3:] * w + np.cross(x[:, :3], w)
            slopes[:, k + 6] = -(x[:, :3] * w).sum(axis=1)
        else:
            slopes[:, k] = motion.qd[:, i]
    return slopes


def _kinds(model: Model) -> NDArray[np.int64]:
    q, qd = np.full(model.nq, _ANGLE), np.full(model.n, _RATE)
    for joint in model.independent:
        k, i = joint.coordinate, joint.rate
        if joint.kind == "floating":
            q[k : k + 3], q[k + 3 : k + 7], qd[i + 3 : i + 6] = _LENGTH, _TURN, _SPEED
        elif joint.kind == "prismatic":
            q[k], qd[i] = _LENGTH, _SPEED
    return np.concatenate((q, qd))
