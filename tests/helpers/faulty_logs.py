"""Motions of a robot with torques that have known faults and noise."""

from __future__ import annotations

from functools import cached_property

import numpy as np

import robodyn
from robodyn.dynamics.regressor import INERTIAL
from robodyn.identification.faults.faults import OWN, Evidence
from robodyn.identification.log.rows import convolved, decimation, kernel

LOAD = np.array([2.0, 0.1, 0.02, 0.2, 0.05, 0.0, 0.0, 0.05, 0.0, 0.02])
"""A payload: mass, first moments and moments about the link's origin."""
CUTOFF = 8.0


class Bench:
    """A robot that moves by five harmonics of 0.1 Hz, so that every effect shows.

    Attributes:
        time: (N,) s; q, qd, qdd, tau: (N, n).
    """

    def __init__(self, path: str, duration: float = 25.0, step: float = 0.005, seed: int = 1) -> None:
        self.model = robodyn.load(path)
        self.step, n, rng = step, self.model.n, np.random.default_rng(seed)
        self.time = np.arange(0.0, duration, step)
        w = 2.0 * np.pi * 0.1 * np.arange(1, 6)
        a, p = 0.8 * rng.normal(size=(n, 5)) / np.sqrt(np.arange(1, 6)), rng.uniform(0.0, 2.0 * np.pi, (n, 5))
        angle = w * self.time[:, None, None] + p
        self.q = (a * np.sin(angle)).sum(axis=2)
        self.qd = (a * w * np.cos(angle)).sum(axis=2)
        self.qdd = -(a * w * w * np.sin(angle)).sum(axis=2)
        self.tau = robodyn.inverse_dynamics(self.model, self.q, self.qd, self.qdd)

    @cached_property
    def load(self):
        """Return (N, n, 10) the columns of a payload at the last body."""
        found, last = robodyn.regressor(self.model, self.q, self.qd, self.qdd), self.model.bodies[-1].name
        return found.Y[:, :, [found.names.index(f"{last}.{each}") for each in INERTIAL]]

    @cached_property
    def scale(self):
        """Return sizes of torques, none far below the largest."""
        size = np.sqrt((self.tau**2).mean(axis=0))
        return np.maximum(size, 0.02 * size.max())

    def injected(self, faults) -> np.ndarray:
        """Return torques with faults (kind, joint, size), of a payload with `LOAD`; gains and delays come last."""
        order = ("payload", "viscous", "coulomb", "rotor", "gain", "offset", "delay")
        tau = self.tau.copy()
        for kind, j, size in sorted(faults, key=lambda fault: order.index(fault[0])):
            if kind == "payload":
                tau += self.load @ LOAD
            elif kind == "gain":
                tau[:, j] *= 1.0 + size
            elif kind == "delay":
                from scipy.interpolate import CubicSpline

                tau[:, j] = CubicSpline(self.time, tau[:, j])(np.maximum(self.time - size, 0.0))
            else:
                column = {"viscous": self.qd, "coulomb": np.sign(self.qd), "rotor": self.qdd}
                tau[:, j] += size * (column[kind][:, j] if kind in column else 1.0)
        return tau

    def size(self, kind: str, j: int) -> float:
        """Return a size of a fault that is a third of the joint's torque; of gains 0.2 and of delays 20 ms."""
        of = {"viscous": self.qd, "rotor": self.qdd}.get(kind)
        fixed = {"gain": 0.2, "delay": 0.02, "payload": 0.0}
        return fixed.get(kind, 0.3 * self.scale[j] / (1.0 if of is None else of[:, j].std()))

    def noise(self, rng, kind: str, share: float = 0.05) -> np.ndarray:
        """Return noise of this share of the torques: "white", "band" (below 3 Hz), or "red" (0.1 s)."""
        N, n = self.tau.shape
        white = rng.normal(size=(N + 4000, n))
        if kind == "band":
            white = convolved(white, kernel(3.0, self.step))
        elif kind == "red":
            from scipy.signal import lfilter

            white = lfilter([1.0], [1.0, -np.exp(-self.step / 0.1)], white, axis=0)[2000:]
        return share * self.scale * white[:N] / white.std()

    def evidence(self, tau) -> Evidence:
        taps, every = kernel(CUTOFF, self.step), decimation(CUTOFF, self.step)
        own, load, computed = self._filtered
        return Evidence(self.step * every, convolved(tau, taps, every), computed, own, load)

    @cached_property
    def _filtered(self):
        own = np.stack([self.qd, np.sign(self.qd), self.qdd], axis=2)
        taps, every = kernel(CUTOFF, self.step), decimation(CUTOFF, self.step)
        return [convolved(each, taps, every) for each in (own, self.load, self.tau)]

    def truth(self, faults) -> np.ndarray:
        """Return all parameters as `Evidence` orders them."""
        n = self.model.n
        found = np.zeros(len(OWN) * n + len(LOAD))
        for kind, j, size in faults:
            if kind == "payload":
                found[len(OWN) * n :] = LOAD
            else:
                found[len(OWN) * j + OWN.index(kind)] = size
        return found
