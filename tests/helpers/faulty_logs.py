"""Logs with known faults and noise: of one motion, as rows; or drawn at random, and by a file as `torques` reads it.

Errors of `explain` were chosen by logs of four robots, puma560, scara, two_link_spatial and ur5_robot, which are not
among `OTHERS`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import polars
from scipy.interpolate import CubicSpline

import robodyn
from helpers.example_robots import path_of
from helpers.identified_logs import coloured, quintics, trapezoids, waves
from helpers.oracles import ROBOTS
from robodyn.dynamics.regressor import INERTIAL
from robodyn.identification.faults.compare import evidence_of, load_body
from robodyn.identification.faults.faults import OWN, Evidence, explain
from robodyn.identification.log.log import read_log
from robodyn.identification.log.rows import convolved, decimation, kernel
from robodyn.scene.scene import Payload, Scene
from robodyn.solids.inertia.laws import symmetric

LOAD = Payload("", 2.0, (0.05, 0.01, 0.1), (0.0298, 0.001, 0.01, 0.025, 0.002, 0.0148))
"""On the body that carries loads."""
CUTOFF = 8.0
OTHERS = ("puma", "meshed_arm", "kinova", "z1")
SEEN = 6.0
"""Standard errors beyond which a fault must not be missed."""


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


@cache
def robot(name):
    path = ROBOTS / f"{name}.urdf"
    return robodyn.load(path if path.exists() else Path(path_of(name)))


def spread(rng, low, high):
    """Return a number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


class Judged(NamedTuple):
    """What became of the faults of a log.

    Attributes:
        off: errors of injected parameters that are told, in standard errors; rest: of all others.
        false: certain faults that were not injected; missed: injected ones beyond `SEEN` errors that are not told.
    """

    off: list[float]
    rest: list[float]
    false: list[tuple[str, int | None]]
    missed: list[tuple[str, int | None]]


class Draw(Log):
    """A log that is drawn by its seed, with 0, 1 or 2 faults by kind and joint.

    Robot, motion, length, rate, noise of torques and positions are drawn, too. A log goes by a file, so that all of
    the reading counts: derivatives are of noisy positions.
    """

    def __init__(self, seed, robots, longest=60.0):
        rng = self.rng = np.random.default_rng([19, seed])
        model = robot(str(rng.choice(robots)))
        duration, rate = spread(rng, 5.0, longest), float(rng.choice([100.0, 250.0, 500.0, 1000.0]))
        self.memory = np.exp(-1.0 / (rate * rng.uniform(0.01, 0.1))) if rng.random() < 0.5 else 0.0
        self.loud, self.jitter = spread(rng, 0.005, 0.05), spread(rng, 1e-5, 1e-4)
        time = np.arange(0.0, duration, 1.0 / rate)
        super().__init__(model, time, (waves, quintics, trapezoids)[rng.integers(3)](rng, time, model.n))
        joints, count = rng.permutation(model.n), seed % 3
        kinds = rng.choice((*OWN, "payload"), count, replace=rng.random() < 0.2)
        mass = spread(rng, 0.2, 3.0)
        own = mass * 0.05**2
        self.load = Payload("", mass, tuple(rng.uniform(-0.1, 0.1, 3)), (own, 0.0, 0.0, own, 0.0, own))
        self.faults = [self._fault(str(kind), int(j)) for kind, j in zip(kinds, joints, strict=False)]

    def _fault(self, kind, j):
        part, sign = spread(self.rng, 0.03, 0.5), float(self.rng.choice([-1.0, 1.0]))
        if kind == "payload":
            return kind, None, ten(self.load)
        rates = {"viscous": self.qd, "rotor": self.qdd}
        sizes = {"delay": 0.06 * sign, "gain": 0.8 * sign, "offset": self.scale[j] * sign, "coulomb": self.scale[j]}
        return kind, j, part * (sizes[kind] if kind in sizes else self.scale[j] / rates[kind][:, j].std())

    def write(self, path):
        """Write times, positions with noise, and torques."""
        tau = self.injected(self.faults, self.load)
        tau += self.loud * self.scale * coloured(self.rng, tau.shape, self.memory)
        q = self.q + self.jitter * self.rng.standard_normal(self.q.shape)
        columns = {
            f"{kind}_{n}": x[:, j] for kind, x in (("q", q), ("tau", tau)) for j, n in enumerate(self.model.rates)
        }
        polars.DataFrame({"time": self.time, **columns}).write_parquet(path)

    def judged(self, path) -> Judged:
        """Return what is told of the log, written to a path."""
        self.write(path)
        evidence, _, joints, _ = evidence_of(read_log(str(path), self.model))
        found = explain(evidence)
        n, errors = len(joints), np.sqrt(np.diag(found.covariance))
        places = {(kind, j): [len(OWN) * k + OWN.index(kind)] for k, j in enumerate(joints) for kind in OWN}
        places["payload", None] = [*range(len(OWN) * n, len(OWN) * n + 10)]
        truth, injected = np.zeros(len(errors)), set()
        for kind, j, size in self.faults:
            truth[places[kind, j]] = size
            injected |= {*places[kind, j]} & found.told
        z = {place: (found.theta[place] - truth[place]) / errors[place] for place in sorted(found.told)}
        told = {(f.effect.kind, None if f.effect.joint is None else joints[f.effect.joint]): f for f in found.faults}
        faults = {(kind, j): {*places[kind, j]} & found.told for kind, j, _ in self.faults}
        return Judged(
            [z[place] for place in z if place in injected],
            [z[place] for place in z if place not in injected],
            [key for key, fault in told.items() if fault.certain and key not in faults],
            [
                key
                for key, own in faults.items()
                if key not in told and any(abs(truth[place]) > SEEN * errors[place] for place in own)
            ],
        )
