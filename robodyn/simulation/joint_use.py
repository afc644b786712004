"""What a simulated motion asks of joints and drives: held by friction, pushed by springs, beyond their limits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.robot.base_guess import untouched
from robodyn.robot.limits import Coverage, Excess, binding, coverage, reached_beyond
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Scene
from robodyn.simulation.conserving import is_free
from robodyn.simulation.events import Limits, Stop
from robodyn.support.caveats import Caveat
from robodyn.support.floats import BEYOND, Floats, first_largest, ranked

SLOW = 3.0
"""Slip speeds below which a joint is held: friction then balances up to 95 % of what it is at speed."""
SHORT = 0.05
"""Of the motion: a joint that is held for less merely turns back."""


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
    """The limit that a motion passes by most, by how much, when, and how many are passed."""

    stop: Stop
    depth: float
    time: float
    limits: int

    def __str__(self) -> str:
        others = f", the most of {self.limits} limits that are passed" if self.limits > 1 else ""
        return f"{self.stop.met('passes')} by at most {self.depth:.4g} {self.stop.unit}, at {self.time:.4g} s{others}"


def deepest(model: Model, time: Floats, q: Floats, qd: Floats) -> Deepest | None:
    """Return how far joints went beyond their limits, at most; None if they did not."""
    limits = Limits(model, True)
    room = limits.room(q)
    if not limits.stops or room.min() >= 0.0:
        return None
    row, place = (int(k) for k in np.unravel_index(first_largest(-room), room.shape))
    stop = limits.stops[place]
    approach = stop.side * stop.joint.multiplier * qd[:, stop.joint.rate]
    when, depth = _peak(time, -room[:, place], approach, row)
    return Deepest(stop, depth, when, int((room < 0.0).any(axis=0).sum()))


def _peak(time: Floats, x: Floats, xd: Floats, row: int) -> tuple[float, float]:
    """Return when x is largest, and how large, on cubics through the rows with their slopes, near the largest row."""
    best = float(time[row]), float(x[row])
    for k in range(max(row - 1, 0), min(row + 1, len(time) - 1)):
        h, s = time[k + 1] - time[k], np.linspace(0.0, 1.0, 65)
        start, end = (1 + 2 * s) * (1 - s) ** 2 * x[k], s * s * (3 - 2 * s) * x[k + 1]
        curve = start + end + h * (s * (1 - s) ** 2 * xd[k] - s * s * (1 - s) * xd[k + 1])
        top = first_largest(curve)
        best = ranked([best, (float(time[k] + s[top] * h), float(curve[top]))], key=lambda pair: pair[1])[0]
    return best


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

    @property
    def exceeded(self) -> tuple[Excess, ...]:
        """The limits that it exceeds."""
        return tuple(reached_beyond(self))


def joint_use(joint: Joint, driven: bool, time: Floats, qd: Floats, tau: Floats) -> JointUse:
    """Return what a joint reaches.

    Args:
        time, qd, tau: (N,) s, its speed, and the load of its drive.
    """
    effort, velocity = binding(joint.effort) if driven else None, binding(joint.velocity)
    peak, fastest = first_largest(np.abs(tau)), first_largest(np.abs(qd))
    return JointUse(
        name=joint.name,
        driven=driven,
        unit="N" if joint.kind == "prismatic" else "N m",
        peak=float(tau[peak]),
        peak_time=float(time[peak]),
        effort_limit=effort,
        seconds_over_effort=_seconds_over(time, tau, effort),
        max_speed=float(qd[fastest]),
        max_speed_time=float(time[fastest]),
        velocity_limit=velocity,
        seconds_over_velocity=_seconds_over(time, qd, velocity),
    )


def _seconds_over(time: Floats, values: Floats, limit: float | None) -> float:
    if limit is None:
        return 0.0
    over = (np.abs(values) > BEYOND * limit).astype(float)
    return float((0.5 * (over[1:] + over[:-1]) * np.diff(time)).sum())


def limits_checked(model: Model, scene: Scene) -> tuple[Coverage, ...]:
    """Return against which limits a motion is held: those of drives, of speeds, and of positions if they are heeded."""
    efforts, _, _ = coverage([joint for joint in model.independent if joint.name in scene.drive])
    _, speeds, positions = coverage(model.independent)
    return (efforts, speeds) if scene.joint_limits == "ignore" else (efforts, speeds, positions)


def caveats(model: Model, scene: Scene, time: Floats, q: Floats, qd: Floats) -> Iterator[Caveat]:
    """Yield what else keeps "No limit is exceeded" from being the whole truth.

    Args:
        time, q, qd: (N,) s, (N, nq), (N, n) of the motion.
    """
    beyond = deepest(model, time, q, qd) if scene.joint_limits == "ignore" else None
    if beyond:
        yield Caveat(
            "but for positions, whose limits the scene ignores",
            f"limits of position are ignored, as the scene says: {beyond}",
        )
    if scene.motor:
        yield Caveat(
            "but for motors, which are not looked at",
            "a simulation does not look at what motors can do; robodyn torques --sizing of the table of --out does",
        )
    if why := "" if scene.held or scene.wrenches else untouched(model):
        if is_free(model, scene) and any(scene.gravity):
            how = "give the forces that carry the robot as [[wrench]]"
            yield Caveat("as the robot falls freely (assumed)", f"nothing carries the free base: {why}; {how}")
        elif not model.floating:
            held = "if something carries the base, say so (--base-held, or [base] held = true)"
            free = 'otherwise free it ([base] motion = "moving") and give the forces that carry it as [[wrench]]'
            yield Caveat(
                "as long as the base is held (assumed)", f"the base stays where it is, though {why}; {held}, {free}"
            )


def assumed(model: Model, scene: Scene) -> list[str]:
    """Return a line on a robot that falls freely and is not doubted for it."""
    falls = is_free(model, scene) and any(scene.gravity) and (scene.held or not untouched(model))
    return ["the base is free, and nothing but gravity acts on it from outside: it falls freely"] if falls else []
