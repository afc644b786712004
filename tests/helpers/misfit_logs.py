"""Logs of a PUMA whose truth is known, each with something that the identified model does not have, and new motions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

import robodyn
from helpers.identified_logs import between, waves, write_log
from helpers.oracles import ROBOTS
from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.identification.identify import identify
from robodyn.identification.log.log import read_log
from robodyn.identification.result import covariance
from robodyn.robot.model import Body, Model
from robodyn.scene.scene import Friction, Rotor, Scene
from robodyn.scene.uncertainty import Covariance
from robodyn.solids.inertia.laws import Inertia, symmetric

Array = NDArray[np.float64]
States = tuple[Array, Array, Array]
STEP, SAMPLES, NOISE, LEVEL = 0.004, 7500, 0.01, 1.96
MISSING = "wrist_pitch"


@dataclass(frozen=True)
class Misfit:
    """What a log has that the identified model has not.

    Attributes:
        late: s, by which torques are logged late; `each` channel by its own part of it, else all alike.
        clipped: largest torque that is measured, in parts of the joint's largest; gain: measured over real torque.
        tilt: of the base, degrees; drift: friction begins so much larger than it ends, as a factor.
        step: of torques, in parts of the joint's largest; bend: of joints under their largest torque [rad].
        presliding: displacement over which dry friction turns its sign [rad] (Dahl 1968).
        missing: whether the log has no columns of `MISSING`, which moves.
    """

    late: float = 0.0
    each: bool = False
    clipped: float | None = None
    gain: float = 1.0
    tilt: float = 0.0
    drift: float = 1.0
    step: float = 0.0
    bend: float = 0.0
    presliding: float = 0.0
    missing: bool = False


CLASSES = {
    "clean": Misfit(),
    "torques 10 ms late": Misfit(late=0.01),
    "torques 30 ms late": Misfit(late=0.03),
    "torques 50 ms late": Misfit(late=0.05),
    "each torque late by its own, to 50 ms": Misfit(late=0.05, each=True),
    "clipped at half of the largest torque": Misfit(clipped=0.5),
    "torque constants off by 15 %": Misfit(gain=1.15),
    "base tilted by 3 degrees": Misfit(tilt=3.0),
    "friction that falls by a third": Misfit(drift=1.5),
    "torques in steps of 5 % of the largest": Misfit(step=0.05),
    "elastic joints": Misfit(bend=0.01),
    "stiction": Misfit(presliding=0.003),
    "a joint that is not in the log": Misfit(missing=True),
}
TUNED, JUDGED = range(100, 104), range(200, 206)
"""Seeds: what is tuned on the first is published of the others."""


class Judged(NamedTuple):
    """How a log is judged by a new motion.

    Attributes:
        held: share of intervals of torques that hold the truth, over instants and joints; joints: by joint.
        error, described: relative errors of the calibrated and the given model on the new motion.
        held_out: as `identify` tells it; said: warnings.
    """

    held: float
    joints: list[float]
    error: float
    described: float
    held_out: float
    said: tuple[str, ...]


def moves(rng: np.random.Generator, time: Array, joints: int) -> States:
    """Two moves of each joint at a time, from point to point, so that they hardly rest, where friction is anything."""
    found = np.zeros((3, len(time), joints))
    for j in [*range(joints)] * 2:
        lasts = rng.uniform(0.8, 2.0, int(2.0 * (time[-1] - time[0])) + 6)
        knots = np.cumsum([time[0] - rng.uniform(0.0, 2.0), *lasts])
        curve = between(knots, rng.uniform(-0.5, 0.5, len(knots)), still=4)
        found[:, :, j] += [curve(time, k) for k in range(3)]
    return found[0], found[1], found[2]


class MisfitLog:
    """A PUMA with bodies each denser than described by a part of its own, its centre of mass off by centimetres."""

    def __init__(self, misfit: Misfit, seed: int, samples: int = SAMPLES) -> None:
        self.misfit, self.rng = misfit, np.random.default_rng(seed)
        self.model = robodyn.load(ROBOTS / "puma560.urdf")
        self.true = replace(self.model, bodies=(self.model.bodies[0], *map(self._other, self.model.bodies[1:])))
        self.scene = robodyn.load_scene(ROBOTS / "puma560_motors.toml")
        self.scale = {name: self.rng.uniform(0.7, 1.3) for name in self.model.rates}
        rotors = self.scene.rotor.items()
        self.rotor = {name: Rotor(rotor.inertia * self.scale[name], rotor.gear) for name, rotor in rotors}
        lean = np.radians(misfit.tilt)
        way = self.rng.uniform(0.0, 2.0 * np.pi)
        self.gravity = 9.81 * np.array([np.sin(lean) * np.cos(way), np.sin(lean) * np.sin(way), -np.cos(lean)])
        self.time = STEP * np.arange(samples)
        self.states = waves(self.rng, self.time, self.model.n, 1.3)
        own = self.rng.uniform(0.2, 1.0, self.model.n) if misfit.each else np.ones(self.model.n)
        self.late = misfit.late * own
        self.tau = self._measured()

    def _other(self, body: Body) -> Body:
        part, off = self.rng.uniform(0.7, 1.3), self.rng.uniform(-0.02, 0.02, 3)
        m, mc, I = body.inertia
        c = mc / (m or 1.0)
        d = c + off
        shift = (d @ d - c @ c) * np.eye(3) - np.outer(d, d) + np.outer(c, c)
        return replace(body, inertia=Inertia(part * m, part * m * d, part * (I + m * shift)))

    def _rigid(self, states: States, part: float) -> Array:
        """Torques with this part of the friction."""
        kept = 0.0 if self.misfit.presliding else 1.0
        friction = {}
        for name, f in self.scene.friction.items():
            own = part * self.scale[name]
            friction[name] = Friction(f.viscous * own, kept * f.forward * own, kept * f.backward * own)
        scene = Scene(gravity=tuple(self.gravity), friction=friction, rotor=self.rotor)
        return robodyn.inverse_dynamics(self.true, *states, scene=scene)

    def torques(self, time: Array, states: States, begun: float = 1e9) -> Array:
        """Torques of the robot as it is; `begun`: s since it began to warm up."""
        warm = 1.0 + (self.misfit.drift - 1.0) * np.exp(-(begun + time) / 10.0)
        rubbing, bare = self._rigid(states, 1.0), self._rigid(states, 0.0)
        rubbing -= bare
        if self.misfit.bend:
            states = self._bent(time, states, bare)
            bare = self._rigid(states, 0.0)
        tau = bare + warm[:, None] * rubbing
        return tau + self._presliding(states) if self.misfit.presliding else tau

    def _bent(self, time: Array, states: States, tau: Array) -> States:
        """Angles of links where motors have those of the log: behind springs that bend under what the links need."""
        q = states[0] - self.misfit.bend * tau / np.abs(tau).max(axis=0)
        spline = make_interp_spline(time, q, k=5)
        return q, spline.derivative()(time), spline.derivative(2)(time)

    def _presliding(self, states: States) -> Array:
        """Dry friction that follows the displacement before it slides: dz/dq = 1 - z sign(qd)."""
        z, found = np.zeros(self.model.n), np.empty_like(states[0])
        forward, backward = (
            np.array([getattr(self.scene.friction[name], way) * self.scale[name] for name in self.model.rates])
            for way in ("forward", "backward")
        )
        moved = np.diff(states[0], axis=0, prepend=states[0][:1])
        for k, dq in enumerate(moved):
            sign = np.sign(dq)
            z = sign + (z - sign) * np.exp(-np.abs(dq) / self.misfit.presliding)
            found[k] = np.where(z > 0.0, forward, -backward) * z
        return found

    def _measured(self) -> Array:
        tau = self.torques(self.time, self.states, 0.0)
        late = [np.interp(self.time - d, self.time, column) for d, column in zip(self.late, tau.T, strict=True)]
        tau = np.stack(late, axis=1) * self.misfit.gain
        tau += NOISE * np.sqrt((tau**2).mean(axis=0)) * self.rng.standard_normal(tau.shape)
        largest = np.abs(tau).max(axis=0)
        if self.misfit.clipped:
            tau = np.clip(tau, -self.misfit.clipped * largest, self.misfit.clipped * largest)
        if self.misfit.step:
            tau = np.round(tau / (self.misfit.step * largest)) * self.misfit.step * largest
        return tau

    def judged(self, path) -> Judged:
        """Identify the log, written to a path; judge intervals of torques on a new motion."""
        left_out = (MISSING,) if self.misfit.missing else ()
        write_log(path, self.model, self.time, self.states[0], self.tau, left_out=left_out)
        self.found = found = identify([read_log(str(path), self.model, self.scene)], self.scene)
        time = 0.02 * np.arange(1000)
        states = moves(self.rng, time, self.model.n)
        true = self.torques(time, states)
        calibrated = with_bodies(self.model, found.names, found.theta)
        scene, described = (each.changed(tuple(self.gravity)) for each in (found.scene, self.scene))
        off = robodyn.inverse_dynamics(calibrated, *states, scene=scene) - true
        plain = robodyn.inverse_dynamics(self.model, *states, scene=described) - true
        inside = np.abs(off) <= LEVEL * deviation(calibrated, scene, states, covariance(found))
        size = np.linalg.norm(true)
        return Judged(
            float(inside.mean()),
            inside.mean(axis=0).tolist(),
            float(np.linalg.norm(off) / size),
            float(np.linalg.norm(plain) / size),
            (found.held_out or found.train).relative_error,
            found.warnings,
        )


def with_bodies(model, names, theta):
    """Return a model with the bodies of parameters, as `robodyn.regressor` names them."""
    of, bodies = dict(zip(names, theta.tolist(), strict=True)), []
    for body in model.bodies:
        m, x, y, z, *moments = (of[f"{body.name}.{kind}"] for kind in INERTIAL)
        bodies.append(replace(body, inertia=Inertia(m, np.array([x, y, z]), symmetric(moments))))
    return replace(model, bodies=tuple(bodies))


def deviation(model: Model, scene: Scene, states: States, known: Covariance) -> Array:
    """Standard errors of torques, of which those by friction under load are by differences."""
    at = regressor(model, *states, scene=scene)
    columns = []
    for name in known.parameters:
        joint, _, kind = name.rpartition(".")
        if kind == "load":
            own = scene.friction[joint]
            ends = (replace(own, load=own.load + h) for h in (1e-4, -1e-4))
            scenes = (replace(scene, friction={**scene.friction, joint: each}) for each in ends)
            more, less = (robodyn.inverse_dynamics(model, *states, scene=each) for each in scenes)
            columns.append((more - less) / 2e-4)
        else:
            columns.append(at.Y[:, :, at.names.index(name)])
    Y = np.stack(columns, axis=2)
    return np.sqrt(np.einsum("kia,ab,kib->ki", Y, known.covariance, Y, optimize=True))


def judged(name: str, seed: int, path, samples: int = SAMPLES) -> Judged:
    """Judge a log of a class."""
    return MisfitLog(CLASSES[name], seed, samples).judged(path)
