"""A motion for a robot that has none yet: every joint swings within its limits."""

from __future__ import annotations

from math import inf, pi, tau

import numpy as np
from numpy.typing import NDArray

from robodyn.model import Joint, Model

Floats = NDArray[np.float64]

DURATION, RATE = 10.0, 200.0
"""Seconds, and samples per second."""
_SWING = {"revolute": 0.5, "prismatic": 0.1}
"""Largest distance from the middle of a swing [rad, m]."""
_SHARE = 0.4
"""Of the range and of the largest speed that a swing takes."""
_CLEAR = 1.1
"""Half-widths from the middle to a limit, so that a swing does not touch it."""
_PERIODS = (1, 2, 3)
"""In the duration, joint by joint in turn, so that they do not move in step."""


def example_motion(model: Model) -> tuple[tuple[str, ...], Floats, Floats]:
    """An example for `torques`: `q = c - h cos(w t)`, at rest at both ends, with exact velocities and accelerations.

    The middle c is zero, or as near to it as the swing stays within the limits; a base that floats stands still.

    Returns:
        Names of columns, time (N,) and columns (N, k): `q_`, `qd_`, `qdd_` of every coordinate and rate.
    """
    time = np.arange(int(DURATION * RATE) + 1) / RATE
    q, qd, qdd = (np.zeros((len(time), k)) for k in (model.nq, model.n, model.n))
    for k, joint in enumerate(model.independent):
        if joint.kind == "floating":
            q[:, joint.coordinate + 6] = 1.0
            continue
        w = tau * _PERIODS[k % len(_PERIODS)] / DURATION
        c, h = _swing(joint, w)
        q[:, joint.coordinate] = c - h * np.cos(w * time)
        qd[:, joint.rate] = h * w * np.sin(w * time)
        qdd[:, joint.rate] = h * w * w * np.cos(w * time)
    names = [f"q_{name}" for name in model.coordinates]
    names += [f"{kind}_{name}" for kind in ("qd", "qdd") for name in model.rates]
    return tuple(names), time, np.hstack((q, qd, qdd))


def _swing(joint: Joint, w: float) -> tuple[float, float]:
    """Middle and half-width of a joint's swing of angular frequency w."""
    lower = -inf if joint.lower is None else joint.lower
    upper = inf if joint.upper is None else joint.upper
    if not lower < upper:
        lower, upper = -pi, pi
    h = min(_SWING.get(joint.kind, 0.1), _SHARE * (upper - lower))
    if joint.velocity is not None:
        h = min(h, _SHARE * max(joint.velocity, 0.0) / w)
    return min(max(0.0, lower + _CLEAR * h), upper - _CLEAR * h), h
