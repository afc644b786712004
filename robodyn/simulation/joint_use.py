"""What a simulated motion asks of the joints and of their drives, beside their limits of speed and effort."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robodyn.robot.limits import Coverage, Excess, binding, coverage, reached_beyond
from robodyn.robot.model import Joint, Model
from robodyn.robot.standing import untouched
from robodyn.scene.scene import Scene
from robodyn.simulation.free import is_free
from robodyn.simulation.remarks import deepest
from robodyn.support.doubts import Doubt
from robodyn.support.ties import BEYOND, first_largest

Floats = NDArray[np.float64]


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


def doubts(model: Model, scene: Scene, time: Floats, q: Floats, qd: Floats) -> Iterator[Doubt]:
    """Yield what else keeps "No limit is exceeded" from being the whole truth.

    Args:
        time, q, qd: (N,) s, (N, nq), (N, n) of the motion.
    """
    beyond = deepest(model, time, q, qd) if scene.joint_limits == "ignore" else None
    if beyond:
        yield Doubt(
            "but for positions, whose limits the scene ignores",
            f"limits of position are ignored, as the scene says: {beyond}",
        )
    if scene.motor:
        yield Doubt(
            "but for motors, which are not looked at",
            "a simulation does not look at what motors can do; robodyn torques --sizing of the table of --out does",
        )
    if why := "" if scene.held or scene.wrenches else untouched(model):
        if is_free(model, scene) and any(scene.gravity):
            how = "give the forces that carry the robot as [[wrench]]"
            yield Doubt("as the robot falls freely (assumed)", f"nothing carries the free base: {why}; {how}")
        elif not model.floating:
            held = "if something carries the base, say so (--base-held, or [base] held = true)"
            free = 'otherwise free it ([base] motion = "moving") and give the forces that carry it as [[wrench]]'
            yield Doubt(
                "as long as the base is held (assumed)", f"the base stays where it is, though {why}; {held}, {free}"
            )


def assumed(model: Model, scene: Scene) -> list[str]:
    """Return a line on a robot that falls freely and is not doubted for it."""
    falls = is_free(model, scene) and any(scene.gravity) and (scene.held or not untouched(model))
    return ["the base is free, and nothing but gravity acts on it from outside: it falls freely"] if falls else []
