"""Logs drawn at random: robot, motion, length, rate, noise of torques and positions, faults; and what is told of them.

Torques come from `inverse_dynamics` with a scene, and go by a file, so that all of the reading counts: derivatives are
of noisy positions. Errors of `explain` were chosen by logs of `TUNED` robots only.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

import robodyn
from helpers.example_robots import path_of
from helpers.oracles import ROBOTS
from robodyn.identification.faults.compare import evidence_of, load_body
from robodyn.identification.faults.faults import OWN, explain
from robodyn.identification.log.log import read_log
from robodyn.scene.scene import Friction, Payload, Rotor, Scene

TUNED = ("puma560", "scara", "two_link_spatial", "ur5_robot")
OTHERS = ("puma", "meshed_arm", "kinova", "z1")
KINDS = (*OWN, "payload")
SEEN = 6.0
"""Standard errors beyond which a fault must not be missed."""


@cache
def robot(name):
    path = ROBOTS / f"{name}.urdf"
    return robodyn.load(path if path.exists() else Path(path_of(name)))


@cache
def described(model, name):
    """Return a parameter of friction or rotors that the description has."""
    rest = np.zeros(model.n)
    found = robodyn.regressor(model, np.zeros(model.nq), rest, rest)
    return float(dict(zip(found.names, found.theta, strict=True)).get(name, 0.0))


def spread(rng, low, high, shape=None):
    """Return numbers whose logarithms are uniform."""
    return np.exp(rng.uniform(np.log(low), np.log(high), shape))


def sines(rng, joints, duration):
    """Return a function of time (N,) that returns q, qd, qdd (3, N, joints): two to six sines of each joint."""
    count = int(rng.integers(2, 7))
    w = 2.0 * np.pi * spread(rng, 0.1, 1.5, (joints, count))
    a, p = rng.uniform(0.2, 1.0, (joints, count)) / (1.0 + w / 2.0), rng.uniform(0.0, 2.0 * np.pi, (joints, count))

    def motion(time):
        angle = w * time[:, None, None] + p
        rates = (a * np.sin(angle), a * w * np.cos(angle), -a * w * w * np.sin(angle))
        return np.stack([each.sum(axis=2) for each in rates])

    return motion


def quintic(u):
    return u**3 * (10.0 - 15.0 * u + 6.0 * u * u), 30.0 * (u * (1.0 - u)) ** 2, 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)


def trapezoid(u):
    """A quarter of the time faster, half of it as fast, a quarter slower."""
    a, v = 16.0 / 3.0, 4.0 / 3.0
    start, end = u < 0.25, u >= 0.75
    place = np.where(start, 0.5 * a * u * u, np.where(end, 1.0 - 0.5 * a * (1.0 - u) ** 2, v * (u - 0.125)))
    return place, np.where(start, a * u, np.where(end, a * (1.0 - u), v)), a * (1.0 * start - end) * ((u > 0) & (u < 1))


def moves(shape):
    """Return motions from point to point, each joint in its own time, of half of the logs with rests."""

    def of(rng, joints, duration):
        rest = rng.choice([0.0, 0.5])
        parts = []
        for _ in range(joints):
            lasts = rng.uniform(0.6, 2.0, int(2.0 * duration) + 8)
            begin = -1.0 + np.cumsum(np.concatenate([[0.0], lasts + rest * rng.random(len(lasts))]))
            parts.append((begin, lasts, rng.uniform(-1.2, 1.2, len(begin))))

        def motion(time):
            found = np.empty((3, len(time), joints))
            for j, (begin, lasts, places) in enumerate(parts):
                k = np.searchsorted(begin, time, side="right") - 1
                T, way = lasts[k], places[k + 1] - places[k]
                s, v, a = shape(np.clip((time - begin[k]) / T, 0.0, 1.0))
                found[:, :, j] = places[k] + way * s, way * v / T, way * a / T**2
            return found

        return motion

    return of


MOTIONS = {"sines": sines, "quintics": moves(quintic), "trapezoids": moves(trapezoid)}


@dataclass
class Judged:
    """What became of the faults of a log.

    Attributes:
        off: errors of injected parameters that are told, in standard errors; rest: of all others.
        false: certain faults that were not injected; missed: injected ones beyond `SEEN` errors that are not told.
    """

    off: list[float]
    rest: list[float]
    false: list[tuple[str, int | None]]
    missed: list[tuple[str, int | None]]


class Draw:
    """A log that is drawn by its seed, with 0, 1 or 2 faults by kind and joint; of a payload its ten parameters."""

    def __init__(self, seed, robots, longest=60.0):
        rng = self.rng = np.random.default_rng([19, seed])
        self.model = robot(str(rng.choice(robots)))
        motion = MOTIONS[str(rng.choice([*MOTIONS]))]
        duration, self.rate = float(spread(rng, 5.0, longest)), float(rng.choice([100.0, 250.0, 500.0, 1000.0]))
        self.coloured, self.loud = rng.random() < 0.5, float(spread(rng, 0.005, 0.05))
        self.jitter = float(spread(rng, 1e-5, 1e-4))
        self.time = np.arange(0.0, duration, 1.0 / self.rate)
        self.motion = motion(rng, self.model.n, duration)
        self.states = self.motion(self.time)
        size = np.sqrt((robodyn.inverse_dynamics(self.model, *self.states) ** 2).mean(axis=0))
        self.scale = np.maximum(size, 0.02 * size.max())
        joints, count = rng.permutation(self.model.n), seed % 3
        kinds = rng.choice(KINDS, count, replace=rng.random() < 0.2)
        self.faults = dict(self._fault(str(kind), int(j)) for kind, j in zip(kinds, joints, strict=False))

    def _fault(self, kind, j):
        rng, part, sign = self.rng, float(spread(self.rng, 0.03, 0.5)), float(self.rng.choice([-1.0, 1.0]))
        if kind == "payload":
            mass, com = float(spread(rng, 0.2, 3.0)), rng.uniform(-0.1, 0.1, 3)
            own = mass * 0.05**2
            self.payload = Payload(load_body(self.model), mass, tuple(com), (own, 0.0, 0.0, own, 0.0, own))
            moments = own * np.eye(3) + mass * (com @ com * np.eye(3) - np.outer(com, com))
            return (kind, None), np.array([mass, *(mass * com), *moments[np.triu_indices(3)]])
        if kind in ("delay", "gain"):
            return (kind, j), sign * part * {"delay": 0.06, "gain": 0.8}[kind]
        size = part * self.scale[j]
        rates = {"viscous": self.states[1], "rotor": self.states[2]}
        return (kind, j), size / rates[kind][:, j].std() if kind in rates else size * (
            sign if kind == "offset" else 1.0
        )

    def _of(self, kind):
        """Return the size of a kind of fault at each joint."""
        return np.array([float(self.faults.get((kind, j), 0.0)) for j in range(self.model.n)])

    def torques(self):
        """Return (N, n) torques with all faults and noise."""
        friction, rotor = {}, {}
        for name, viscous, coulomb, inertia in zip(
            self.model.rates, self._of("viscous"), self._of("coulomb"), self._of("rotor"), strict=True
        ):
            base = [described(self.model, f"{name}.{kind}") for kind in ("viscous", "forward", "backward", "rotor")]
            friction[name] = Friction(base[0] + viscous, base[1] + coulomb, base[2] - coulomb)
            rotor[name] = Rotor(base[3] + inertia, 1.0)
        payloads = (self.payload,) if ("payload", None) in self.faults else ()
        scene = Scene(friction=friction, rotor=rotor, payloads=payloads)
        tau, delays = np.empty_like(self.states[0]), self._of("delay")
        for delay in {*delays}:
            late = robodyn.inverse_dynamics(self.model, *self.motion(self.time - delay), scene=scene)
            tau[:, delays == delay] = late[:, delays == delay]
        return tau * (1.0 + self._of("gain")) + self._of("offset") + self._noise()

    def _noise(self):
        white = self.rng.standard_normal((len(self.time) + 8000, self.model.n))
        if self.coloured:
            keep = np.exp(-1.0 / (self.rate * self.rng.uniform(0.01, 0.1)))
            white = np.sqrt(1.0 - keep * keep) * lfilter([1.0], [1.0, -keep], white, axis=0)
        return self.loud * self.scale * white[-len(self.time) :]

    def write(self, path):
        """Write times, positions with noise, and torques."""
        import pyarrow
        import pyarrow.parquet

        tau = self.torques()
        q = self.states[0] + self.jitter * self.rng.standard_normal(self.states[0].shape)
        parts = [
            (f"{kind}_{name}", x[:, j])
            for kind, x in (("q", q), ("tau", tau))
            for j, name in enumerate(self.model.rates)
        ]
        pyarrow.parquet.write_table(pyarrow.table({"time": self.time, **dict(parts)}), path)

    def judged(self, path) -> Judged:
        """Return what is told of the log, written to a path."""
        self.write(path)
        evidence, _, joints, *_ = evidence_of(read_log(str(path), self.model))
        found = explain(evidence)
        n, errors = len(joints), np.sqrt(np.diag(found.covariance))
        places = {(kind, j): [len(OWN) * k + OWN.index(kind)] for k, j in enumerate(joints) for kind in OWN}
        places["payload", None] = [*range(len(OWN) * n, len(OWN) * n + 10)]
        truth, injected = np.zeros(len(errors)), set()
        for key, size in self.faults.items():
            truth[places[key]] = size
            injected |= {*places[key]} & found.told
        z = {place: (found.theta[place] - truth[place]) / errors[place] for place in sorted(found.told)}
        told = {(f.effect.kind, None if f.effect.joint is None else joints[f.effect.joint]): f for f in found.faults}
        return Judged(
            [z[place] for place in z if place in injected],
            [z[place] for place in z if place not in injected],
            [key for key, fault in told.items() if fault.certain and key not in self.faults],
            [key for key in self.faults if key not in told and self._clear({*places[key]} & found.told, truth, errors)],
        )

    @staticmethod
    def _clear(places, truth, errors):
        return any(abs(truth[place]) > SEEN * errors[place] for place in places)
