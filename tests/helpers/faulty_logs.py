"""Motions of a robot with torques that have known faults and noise."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

import robodyn
from helpers.identified_logs import coloured
from robodyn.dynamics.regressor import INERTIAL
from robodyn.identification.faults.compare import load_body
from robodyn.identification.faults.faults import OWN, Evidence
from robodyn.identification.log.rows import convolved, decimation, kernel
from robodyn.scene.scene import Payload, Scene
from robodyn.solids.inertia.laws import symmetric

LOAD = Payload("", 2.0, (0.05, 0.01, 0.1), (0.0298, 0.001, 0.01, 0.025, 0.002, 0.0148))
"""On the body that carries loads."""
CUTOFF = 8.0


def ten(load: Payload):
    """Return mass, first moments and moments about the link's origin."""
    c = np.array(load.com)
    moments = symmetric(load.inertia) + load.mass * (c @ c * np.eye(3) - np.outer(c, c))
    return np.array([load.mass, *(load.mass * c), *moments[np.triu_indices(3)]])


class Log:
    """A motion of a robot with its torques.

    Attributes:
        time: (N,) s; q, qd, qdd, tau: (N, n); scale: (n,) sizes of torques, none far below the largest [N m].
    """

    def __init__(self, model, time, motion) -> None:
        self.model, self.time, self.motion = model, time, motion
        self.q, self.qd, self.qdd = motion
        self.tau = robodyn.inverse_dynamics(model, *motion)
        size = np.sqrt((self.tau**2).mean(axis=0))
        self.scale = np.maximum(size, 0.02 * size.max())

    def injected(self, faults, load=LOAD) -> np.ndarray:
        """Return torques with faults (kind, joint, size), of a payload with this load; gains and delays come last."""
        order = ("payload", "viscous", "coulomb", "rotor", "gain", "offset", "delay")
        tau = self.tau.copy()
        columns = {"viscous": self.qd, "coulomb": np.sign(self.qd), "rotor": self.qdd, "offset": np.ones_like(self.q)}
        for kind, j, size in sorted(faults, key=lambda fault: order.index(fault[0])):
            if kind == "payload":
                scene = Scene(payloads=(replace(load, link=load_body(self.model)),))
                tau += robodyn.inverse_dynamics(self.model, *self.motion, scene=scene) - self.tau
            elif kind == "gain":
                tau[:, j] *= 1.0 + size
            elif kind == "delay":
                before = np.clip(self.time - size, *self.time[[0, -1]])
                tau[:, j] = CubicSpline(self.time, tau[:, j])(before)
            else:
                tau[:, j] += size * columns[kind][:, j]
        return tau


class Bench(Log):
    """A robot that moves by five harmonics of 0.1 Hz, so that every effect shows."""

    def __init__(self, path: str, duration: float = 25.0, step: float = 0.005, seed: int = 1) -> None:
        model = robodyn.load(path)
        self.step, n, rng = step, model.n, np.random.default_rng(seed)
        time = np.arange(0.0, duration, step)
        w = 2.0 * np.pi * 0.1 * np.arange(1, 6)
        a, p = 0.8 * rng.normal(size=(n, 5)) / np.sqrt(np.arange(1, 6)), rng.uniform(0.0, 2.0 * np.pi, (n, 5))
        angle = w * time[:, None, None] + p
        rates = (a * np.sin(angle), a * w * np.cos(angle), -a * w * w * np.sin(angle))
        super().__init__(model, time, [each.sum(axis=2) for each in rates])

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
            white = coloured(rng, (N, n), np.exp(-self.step / 0.1))
        return share * self.scale * white[:N] / white.std()

    def evidence(self, tau) -> Evidence:
        taps, every = kernel(CUTOFF, self.step), decimation(CUTOFF, self.step)
        own, load, computed = self._filtered
        return Evidence(self.step * every, convolved(tau, taps, every), computed, own, load)

    @cached_property
    def _filtered(self):
        """Columns of friction and rotors, those of a payload at the last body, and torques."""
        found, last = robodyn.regressor(self.model, *self.motion), load_body(self.model)
        load = found.Y[:, :, [found.names.index(f"{last}.{each}") for each in INERTIAL]]
        own = np.stack([self.qd, np.sign(self.qd), self.qdd], axis=2)
        taps, every = kernel(CUTOFF, self.step), decimation(CUTOFF, self.step)
        return [convolved(each, taps, every) for each in (own, load, self.tau)]

    def truth(self, faults) -> np.ndarray:
        """Return all parameters as `Evidence` orders them."""
        n = self.model.n
        found = np.zeros(len(OWN) * n + 10)
        for kind, j, size in faults:
            if kind == "payload":
                found[len(OWN) * n :] = ten(LOAD)
            else:
                found[len(OWN) * j + OWN.index(kind)] = size
        return found
