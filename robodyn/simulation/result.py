"""What a simulation yields: the motion, the torques that drove it, what should have stayed as it was, and what it asks
of joints and drives: held by friction, pushed by springs, beyond their limits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Verdict
from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.errors import Caveat
from robodyn.robot.base_guess import untouched
from robodyn.robot.limits import Coverage, Excess, binding, coverage, reached_beyond, within
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Scene
from robodyn.simulation.equations import is_free
from robodyn.simulation.events import Limits, Stop
from robodyn.simulation.loop_figures import LoopFigures
from robodyn.simulation.methods import Method
from robodyn.support.floats import BEYOND, Floats, first_largest, ranked
from robodyn.trajectory.columns.signals import COMPONENTS

SLOW = 3.0  # slip speeds below which a joint is held: friction then balances up to 95 % of what it is at speed
SHORT = 0.05  # of the motion: a joint that is held for less merely turns back


@dataclass(frozen=True)
class Figures:
    """At the N recorded times: accelerations and drives' torques (N, n), stored and kinetic energy (N,) [J], momentum
    (N, 3), and angular momentum about the centre of mass, in the ground's axes."""

    qdd: Floats
    tau: Floats
    energy: Floats
    kinetic: Floats
    linear: Floats
    angular: Floats

    def drift(self, work: Floats) -> float:
        """max |E - E_0 - work| [J]."""
        return float(np.abs(self.energy - self.energy[0] - (work - work[0])).max())


@dataclass(frozen=True)
class JointUse:
    """What one joint reaches.

    Attributes:
        driven: whether the scene has a drive for it; else there is no effort to limit.
        unit: of the drive's load, N m or N.
        peak: that of largest magnitude, with its sign, when [s], its limit, and how long it is exceeded [s].
        max_speed: of largest magnitude, likewise [rad/s or m/s].
    """

    name: str
    driven: bool
    unit: str
    peak: float
    peak_time: float
    effort_limit: float | None
    seconds_over_effort: float
    max_speed: float
    max_speed_time: float
    velocity_limit: float | None
    seconds_over_velocity: float


@dataclass(frozen=True, eq=False)
class Simulation:
    """The simulated motion of a robot.

    Attributes:
        scene: as it was integrated, with the slip speed of friction.
        step: of a fixed-step method [s]; rtol: of an adaptive one.
        time, q, qd: (N,), (N, nq), (N, n), the first as the scene says.
        work: (N,) done by drives and wrenches, less what friction took [J].
        evaluations: of the equations of motion, those of every sweep of an implicit step among them.
        ended: why the motion ended before its time; empty if it did not.
        shaky: why the numbers may not be right; notes: what was assumed.
        target, expected_error: the accuracy that was asked for, and what was measured; None where none was.
    """

    model: Model
    scene: Scene
    method: Method
    step: float | None
    rtol: float | None
    time: Floats
    q: Floats
    qd: Floats
    work: Floats
    figures: Figures
    steps: int
    evaluations: int
    executor: str
    effects: tuple[tuple[Effect, Verdict], ...]
    loops: LoopFigures | None = None
    ended: str = ""
    shaky: tuple[Caveat, ...] = ()
    notes: tuple[str, ...] = ()
    target: float | None = None
    expected_error: float | None = None

    @property
    def qdd(self) -> Floats:
        return self.figures.qdd

    @property
    def tau(self) -> Floats:
        return self.figures.tau

    @cached_property
    def joints(self) -> tuple[JointUse, ...]:
        """What each hinge and slide reaches."""
        return tuple(_joint_use(joint, self) for joint in self.model.independent if joint.kind != "floating")

    @property
    def exceeded(self) -> tuple[Excess, ...]:
        """Every limit of speed and effort that the motion exceeds."""
        found: list[Excess] = []
        for each in self.joints:
            effort = (each.peak, each.effort_limit, each.peak_time, each.seconds_over_effort)
            velocity = (each.max_speed, each.velocity_limit, each.max_speed_time, each.seconds_over_velocity)
            found += reached_beyond(each.name, each.unit, effort, velocity)
        return tuple(found)

    @cached_property
    def limits(self) -> tuple[Coverage, ...]:
        """Which limits the motion is held against: those of drives, of speeds, and of positions if they are heeded."""
        efforts, _, _ = coverage([joint for joint in self.model.independent if joint.name in self.scene.drive])
        _, speeds, positions = coverage(self.model.independent)
        return (efforts, speeds) if self.scene.joint_limits == "ignore" else (efforts, speeds, positions)

    @cached_property
    def caveats(self) -> tuple[Caveat, ...]:
        """What else keeps "No limit is exceeded" from being the whole truth."""
        return (*self.shaky, *_caveats(self))

    @property
    def within_limits(self) -> bool | None:
        """False if a limit of speed or effort is exceeded; None if one is not checked or something is in doubt."""
        return within(bool(self.exceeded), self.limits, self.caveats)

    @property
    def energy_drift(self) -> float:
        """max |E - E_0 - work| [J]."""
        return self.figures.drift(self.work)

    @property
    def free(self) -> bool:
        return is_free(self.model, self.scene)

    @property
    def momentum_drift(self) -> tuple[float, float]:
        """Of a free robot, max |P - P_0 - m g t| [N s] and max |H_c - H_c0| [N m s] over the motion."""
        weight = sum(payload.mass for payload in self.scene.payloads) + self.model.total_mass
        impulse = weight * np.outer(self.time - self.time[0], self.scene.gravity)
        linear, angular = self.figures.linear, self.figures.angular
        return float(np.abs(linear - linear[0] - impulse).max()), float(np.abs(angular - angular[0]).max())

    @property
    def names(self) -> tuple[str, ...]:
        """Names of `columns`: `q_`, `qd_`, `qdd_` of coordinates and rates, `tau_` of joints, `fx_` .. of loops."""
        q = [f"q_{name}" for name in self.model.coordinates]
        rates = [f"{kind}_{name}" for kind in ("qd", "qdd") for name in self.model.rates]
        tau = [f"tau_{self.model.rates[i]}" for i in self.driven]
        wrenches = [f"{part}_{name}" for name in (self.loops.names if self.loops else ()) for part in COMPONENTS]
        return (*q, *rates, *tau, *wrenches)

    @property
    def driven(self) -> list[int]:
        """The places in tau of hinges and slides: nothing drives a floating joint."""
        return [joint.rate for joint in self.model.independent if joint.kind != "floating"]

    @property
    def columns(self) -> Floats:
        """(N, k) in the order of `names`, which `robodyn torques` reads."""
        loops = [self.loops.wrenches.reshape(len(self.time), -1)] if self.loops else []
        return np.hstack((self.q, self.qd, self.qdd, self.tau[:, self.driven], *loops))


class Held(NamedTuple):
    """A joint that friction held for some time [s], and how far and how fast it crept meanwhile [rad, rad/s]."""

    joint: Joint
    time: float
    creep: float
    speed: float

    def __str__(self) -> str:
        unit = "m" if self.joint.kind == "prismatic" else "rad"
        return (
            f'friction holds "{self.joint.name}" for {self.time:.4g} s, in which it creeps {self.creep:.2g} {unit}, '
            f"at most {self.speed:.2g} {unit}/s"
        )


def held(model: Model, scene: Scene, time: Floats, qd: Floats) -> Iterator[Held]:
    """Yield the joints with Coulomb friction that were held, of a motion with speeds qd (N, n)."""
    lasting = np.diff(time)
    for _, joint, friction in joints_with_friction(model, scene):
        if not (scene.slip_speed and friction.dry):
            continue
        speed = np.abs(joint.multiplier * qd[:, joint.rate])
        slow = speed <= SLOW * scene.slip_speed
        still = slow[:-1] & slow[1:]
        if lasting[still].sum() > SHORT * (time[-1] - time[0]):
            mean = 0.5 * (speed[:-1] + speed[1:])
            most = float(np.maximum(speed[:-1], speed[1:])[still].max())
            yield Held(joint, float(lasting[still].sum()), float((mean * lasting)[still].sum()), most)


class Deepest(NamedTuple):
    """The limit that a motion passes by most, by how much and when, and how many are passed."""

    stop: Stop
    depth: float
    time: float
    limits: int

    def __str__(self) -> str:
        others = f", the most of {self.limits} limits that are passed" if self.limits > 1 else ""
        return f"{self.stop.met('passes')} by at most {self.depth:.4g} {self.stop.unit}, at {self.time:.4g} s{others}"


def deepest(model: Model, time: Floats, q: Floats, qd: Floats) -> Deepest | None:
    """How far joints went beyond their limits, at most, by cubics through the rows; None if they did not."""
    limits = Limits(model, True)
    room = limits.room(q)
    if not limits.stops or room.min() >= 0.0:
        return None
    row, place = (int(k) for k in np.unravel_index(first_largest(-room), room.shape))
    stop, x, xd = limits.stops[place], -room[:, place], -limits.rate(qd)[:, place]
    best = float(time[row]), float(x[row])
    for k in range(max(row - 1, 0), min(row + 1, len(time) - 1)):
        h, s = time[k + 1] - time[k], np.linspace(0.0, 1.0, 65)
        start, end = (1 + 2 * s) * (1 - s) ** 2 * x[k], s * s * (3 - 2 * s) * x[k + 1]
        curve = start + end + h * (s * (1 - s) ** 2 * xd[k] - s * s * (1 - s) * xd[k + 1])
        top = first_largest(curve)
        best = ranked([best, (float(time[k] + s[top] * h), float(curve[top]))], key=lambda pair: pair[1])[0]
    when, depth = best
    return Deepest(stop, depth, when, int((room < 0.0).any(axis=0).sum()))


def _joint_use(joint: Joint, motion: Simulation) -> JointUse:
    qd, tau, driven = motion.qd[:, joint.rate], motion.tau[:, joint.rate], joint.name in motion.scene.drive
    effort, velocity = binding(joint.effort) if driven else None, binding(joint.velocity)
    peak, fastest = first_largest(np.abs(tau)), first_largest(np.abs(qd))

    def seconds_over(values: Floats, limit: float | None) -> float:
        over = (np.abs(values) > BEYOND * (np.inf if limit is None else limit)).astype(float)
        return float((0.5 * (over[1:] + over[:-1]) * np.diff(motion.time)).sum())

    return JointUse(
        name=joint.name,
        driven=driven,
        unit="N" if joint.kind == "prismatic" else "N m",
        peak=float(tau[peak]),
        peak_time=float(motion.time[peak]),
        effort_limit=effort,
        seconds_over_effort=seconds_over(tau, effort),
        max_speed=float(qd[fastest]),
        max_speed_time=float(motion.time[fastest]),
        velocity_limit=velocity,
        seconds_over_velocity=seconds_over(qd, velocity),
    )


def _caveats(motion: Simulation) -> Iterator[Caveat]:
    model, scene = motion.model, motion.scene
    beyond = deepest(model, motion.time, motion.q, motion.qd) if scene.joint_limits == "ignore" else None
    if beyond:
        said = f"limits of position are ignored, as the scene says: {beyond}"
        yield Caveat("but for positions, whose limits the scene ignores", said)
    if scene.motor:
        said = "a simulation does not look at what motors can do; robodyn torques --sizing of the table of --out does"
        yield Caveat("but for motors, which are not looked at", said)
    if why := "" if scene.held or scene.wrenches else untouched(model):
        if motion.free and any(scene.gravity):
            how = "give the forces that carry the robot as [[wrench]]"
            yield Caveat("as the robot falls freely (assumed)", f"nothing carries the free base: {why}; {how}")
        elif not model.floating:
            held = "if something carries the base, say so (--base-held, or [base] held = true)"
            free = 'otherwise free it ([base] motion = "moving") and give the forces that carry it as [[wrench]]'
            said = f"the base stays where it is, though {why}; {held}, {free}"
            yield Caveat("as long as the base is held (assumed)", said)
