"""Logs of robots whose parameters are known: two families of motions, bodies that differ, noise of two kinds."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BPoly, PPoly

from robodyn.identification.log.log import Samples
from robodyn.identification.log.rows import convolved, decimation, kernel
from robodyn.identification.model_selection import Structure, covariance, fitted, joint_motors, system
from robodyn.identification.parameters.base import base_of
from robodyn.identification.parameters.regressor_columns import PLAIN, Gathered, Guess, Moments, RegressorColumns
from robodyn.scene.scene import DEFAULT


def waves(rng, time, joints, scale=1.0):
    """Four sines of each joint up to 1.2 Hz; each joint may have a scale of its own."""
    q, qd, qdd = np.zeros((3, len(time), joints))
    for j, size in enumerate(np.broadcast_to(scale, joints)):
        for w in 2.0 * np.pi * rng.uniform(0.1, 1.2, 4):
            a, p = size * rng.uniform(0.1, 0.5) / (1.0 + w / 3.0), rng.uniform(0.0, 6.28)
            q[:, j] += a * np.sin(w * time + p)
            qd[:, j] += a * w * np.cos(w * time + p)
            qdd[:, j] -= a * w * w * np.sin(w * time + p)
    return q, qd, qdd


def between(knots, places, still=2):
    """A curve through places at knots, at each of which so many derivatives vanish."""
    return BPoly.from_derivatives(knots, np.column_stack([places, np.zeros((len(places), still))]))


def quintics(rng, time, joints, scale=1.0):
    """Moves from point to point, each joint in its own time, without rests."""
    curves = []
    for _ in range(joints):
        knots = np.cumsum(np.concatenate([[time[0]], rng.uniform(0.6, 1.6, int(2.0 * (time[-1] - time[0])) + 4)]))
        curves.append(between(knots, scale * rng.uniform(-1.0, 1.0, len(knots))))
    return tuple(np.stack([curve(time, k) for curve in curves], axis=1) for k in range(3))


def white(rng, shape):
    return rng.standard_normal(shape)


def coloured(rng, shape, memory=0.9):
    """Of unit variance: each sample keeps a part of the one before."""
    from scipy.signal import lfilter

    steps = np.sqrt(1.0 - memory * memory) * rng.standard_normal((shape[0] + 100, shape[1]))
    return lfilter([1.0], [1.0, -memory], steps, axis=0)[100:]


def trapezoids(rng, time, joints):
    """Speeds that are trapezoids, with rests: accelerations jump."""
    found = np.zeros((3, len(time), joints))
    for j in range(joints):
        parts, sign = [], 1.0
        while sum(duration for duration, _ in parts) <= time[-1]:
            a, ramp, cruise = rng.uniform(2, 20) * sign, rng.uniform(0.06, 0.3), rng.uniform(0, 0.3)
            rest = rng.uniform(0, 0.3) * (rng.random() < 0.7)
            parts += [(ramp, a), (cruise, 0.0), (ramp, -a), (rest + 1e-9, 0.0)]
            sign = -sign if rng.random() < 0.8 else sign
        h, a = np.array(parts).T
        curve = PPoly(a[None], np.cumsum([0.0, *h])).antiderivative(2)
        found[:, :, j] = [curve(time, k) for k in range(3)]
    return tuple(found)


MOTORS = {"viscous": 0.5, "coulomb": 0.8, "offset": 0.1, "rotor": 0.02}


class Bench:
    """A robot on one motion, whose filtered rows are computed once: noise of torques changes the torques alone.

    Attributes:
        structure: bodies and a motor for each joint; theta: (p,) the truth, `base.values(theta)` of a base.
        rows: of each joint (k, p) columns of the structure's parameters; loud: standard deviation of noise [N m].
    """

    STEP, CUTOFF, SAMPLES, NOISE = 0.004, 6.0, 5000, 0.05

    def __init__(self, model, motion, seed):
        self.rng = np.random.default_rng(seed)
        self.taps, self.every = kernel(self.CUTOFF, self.STEP), decimation(self.CUTOFF, self.STEP)
        self.model, joints = model, range(model.n)
        self.regressor = RegressorColumns(model, DEFAULT, joints, joint_motors(model), 0.0)
        self.structure = Structure(self.regressor, dict.fromkeys(joints, PLAIN))
        self.theta = self._truth()
        self.columns = self.filtered(motion)
        self.base = base_of(np.concatenate(self.rows(self.columns)), self.structure.names)
        self.beta = self.base.values(self.theta)
        self.clean = np.stack([rows @ self.theta for rows in self.rows(self.columns)], axis=1)
        self.loud = self.NOISE * np.sqrt((self.clean**2).mean(axis=0))

    def filtered(self, motion):
        time = self.STEP * np.arange(self.SAMPLES)
        samples = Samples(time, *motion(self.rng, time, self.model.n), np.zeros((len(time), self.model.n)), True)
        values = convolved(self.regressor.compute(samples), self.taps, self.every)
        return [part[:, :-2] for part in self.regressor.by_joint(values)]

    def rows(self, columns):
        pairs = zip(columns, self.regressor.used, strict=True)
        return [part @ self.structure.shape[used] for part, used in pairs]

    def _truth(self):
        """Bodies each denser by a part of its own, and friction."""
        density = {}
        theta = []
        described = dict(zip(self.regressor.bodies, self.regressor.described, strict=True))
        for name in self.structure.names:
            owner, _, kind = name.rpartition(".")
            part = density.setdefault(owner, self.rng.uniform(0.8, 1.25))
            theta.append(MOTORS[kind] if kind in MOTORS else part * described[name])
        return np.array(theta)

    def fit(self, tau):
        """Return base parameters and their covariance of torques, as `identify` finds them."""
        plain, weighted = Gathered(1, self.regressor), Gathered(1, self.regressor)
        plain.squares[0] = weighted.squares[0] = (tau**2).sum(axis=0)
        for joint, part in enumerate(self.columns):
            plain.parts[0][joint].add(np.column_stack((part, tau[:, joint])))
        theta, sigma = fitted(plain, [0], self.structure)
        guess = Guess(self.structure.shape @ theta, sigma, Moments(self.regressor))
        off = np.stack([rows @ theta for rows in self.rows(self.columns)], axis=1) - tau
        weights = guess.weights(self.columns, off, np.ones(len(tau), dtype=bool))
        for joint, part in enumerate(self.columns):
            weighted.parts[0][joint].add(np.column_stack((part, tau[:, joint])) * weights[:, joint, None])
        _, sigma = fitted(weighted, [0], self.structure)
        R, z = system(weighted, [0], self.structure, sigma)
        C = covariance(guess.moments, self.structure, self.base, R, sigma)
        return self.base.estimate(R, z).values, C

    def logs(self, noise, count):
        """Yield base parameters and their covariance of noisy logs."""
        for _ in range(count):
            disturbed = noise(self.rng, (self.SAMPLES, self.model.n)) * self.loud
            yield self.fit(self.clean + convolved(disturbed, self.taps, self.every))


def write_log(path, model, time, q, tau, qd=None, qdd=None, left_out=()):
    """Write a table of a log as CSV, with the velocities and accelerations that are given, without some joints."""
    parts = [
        (kind, values) for kind, values in (("q", q), ("qd", qd), ("qdd", qdd), ("tau", tau)) if values is not None
    ]
    columns = {f"{kind}_{n}": x[:, j] for kind, x in parts for j, n in enumerate(model.rates) if n not in left_out}
    rows = np.column_stack([time, *columns.values()])
    np.savetxt(path, rows, delimiter=",", header=",".join(["time", *columns]), comments="", fmt="%.17g")
