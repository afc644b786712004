"""Logs of robots whose parameters are known: two families of motions, bodies that differ, noise of two kinds."""

from __future__ import annotations

from itertools import pairwise

import numpy as np


def waves(rng, time, joints, scale=1.0):
    """Four sines of each joint up to 1.2 Hz."""
    q, qd, qdd = np.zeros((3, len(time), joints))
    for j in range(joints):
        for w in 2.0 * np.pi * rng.uniform(0.1, 1.2, 4):
            a, p = scale * rng.uniform(0.1, 0.5) / (1.0 + w / 3.0), rng.uniform(0.0, 6.28)
            q[:, j] += a * np.sin(w * time + p)
            qd[:, j] += a * w * np.cos(w * time + p)
            qdd[:, j] -= a * w * w * np.sin(w * time + p)
    return q, qd, qdd


def quintics(rng, time, joints, scale=1.0):
    """Moves from point to point, each joint in its own time, without rests."""
    q, qd, qdd = np.zeros((3, len(time), joints))
    for j in range(joints):
        knots = np.cumsum(np.concatenate([[time[0]], rng.uniform(0.6, 1.6, int(2.0 * (time[-1] - time[0])) + 4)]))
        places = scale * rng.uniform(-1.0, 1.0, len(knots))
        for (a, b), (x, y) in zip(pairwise(knots), pairwise(places), strict=True):
            own = (time >= a) & (time < b)
            s, T = (time[own] - a) / (b - a), b - a
            q[own, j] = x + (y - x) * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
            qd[own, j] = (y - x) * 30.0 * s * s * (1.0 - s) ** 2 / T
            qdd[own, j] = (y - x) * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / T**2
    return q, qd, qdd


def truth(atoms, rng):
    """(a,) parameters of bodies that can exist and of motors: each body is denser by its own part, and friction."""
    values = dict(zip(atoms.names, np.zeros(len(atoms.names)), strict=True))
    for first in range(0, len(atoms.bodies), 10):
        part = rng.uniform(0.8, 1.25)
        values |= {atoms.bodies[k]: part * atoms.described[k] for k in range(first, first + 10)}
    return values


def white(rng, shape):
    return rng.standard_normal(shape)


def coloured(rng, shape, memory=0.9):
    """Of unit variance: each sample keeps a part of the one before."""
    from scipy.signal import lfilter

    steps = np.sqrt(1.0 - memory * memory) * rng.standard_normal((shape[0] + 100, shape[1]))
    return lfilter([1.0], [1.0, -memory], steps, axis=0)[100:]
