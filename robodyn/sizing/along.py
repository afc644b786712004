"""What limits a robot along a path: exactly at a state, and as lines in the path's acceleration u and squared speed x,
near a pass: with q(s), `qd = q' sd`, `qdd = q' u + q'' x`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.effects.friction import friction_of
from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.errors import InputError, SceneError
from robodyn.loads.sizing import LEAST, Train, allowed, load_torque, motor_torque, points, train_of
from robodyn.robot.kinematics import named
from robodyn.robot.limits import MOST_EFFORT, MOST_VELOCITY, binding
from robodyn.robot.model import Model
from robodyn.scene.fit import check_moves, refuse_load, refuse_others
from robodyn.scene.scene import Scene
from robodyn.sizing.path import Path
from robodyn.sizing.reachability import Rows
from robodyn.support.floats import Floats
from robodyn.support.wording import shown

LIMITS = ("velocity", "acceleration", "effort", "motor torque", "motor speed", "gear torque", "jerk")
VELOCITY, ACCELERATION, EFFORT, MOTOR_TORQUE, MOTOR_SPEED, GEAR, JERK = range(len(LIMITS))
SLOWEST = 1e-9  # rad/s, m/s: what counts as moving, for the friction at the beginning of a motion
FINE = 10
"""Parts of each interval at whose ends limits are checked."""
_STEP = 1e-4  # of the speed, over which slopes are taken
PerJoint = float | Sequence[float] | Mapping[str, float]


def per_joint(given: PerJoint | None, model: Model, what: str) -> Floats:
    """Return a limit of each joint (n,), inf where none is given: one number for all, one for each, or by name."""
    values: Any = given if isinstance(given, Mapping) else np.atleast_1d([] if given is None else given).tolist()
    if len(values) == 1 and not isinstance(given, Mapping):
        values *= model.n
    by_name = named(model, values, model.joint_names)
    found = np.array([by_name.get(name, np.inf) for name in model.joint_names])
    if not (found > 0.0).all():
        raise InputError(f"{what} is {found[~(found > 0.0)][0]:g}", remedy="it is positive")
    return found


@dataclass(frozen=True, eq=False)
class Bounds:
    """The limits (7, n) of each coordinate that have one number, inf where there is none; the motors of a scene."""

    model: Model
    scene: Scene
    limits: Floats
    trains: tuple[tuple[int, Train], ...]

    @property
    def speed(self) -> Floats:
        """(n,) the largest speeds of joints that they and their motors allow."""
        found: Floats = self.limits[VELOCITY].copy()
        for i, train in self.trains:
            found[i] = min(found[i], self.limits[MOTOR_SPEED, i] / abs(train.gear))
        return found

    @property
    def bent(self) -> bool:
        """Whether limits may be other than lines in u and x: friction, drag, and motors' curves and losses."""
        scene, found = self.scene, (friction_of(body.joint, self.scene) for body in self.model.bodies)
        drags = any(friction.viscous or friction.dry for friction in found)
        return drags or bool(self.trains or scene.coupled or scene.immersed)

    def values(self, q: Floats, qd: Floats, qdd: Floats) -> tuple[Floats, Floats]:
        """Return what is limited at states (..., n), all of `LIMITS` but jerk (6, ..., n), and its limits there."""
        found = np.zeros((JERK, *q.shape))
        limits = np.broadcast_to(self.limits[:JERK].reshape(JERK, *(1,) * (q.ndim - 1), -1), found.shape).copy()
        tau = inverse_dynamics(self.model, q, qd, qdd, scene=self.scene)
        found[VELOCITY], found[ACCELERATION], found[EFFORT] = qd, qdd, tau
        for i, train in self.trains:
            load = load_torque(train, tau[..., i], qdd[..., i])
            found[MOTOR_SPEED, ..., i], found[GEAR, ..., i] = train.gear * qd[..., i], load
            if (peak := train.motor.peak) is not None:
                found[MOTOR_TORQUE, ..., i] = motor_torque(train, load, qd[..., i], qdd[..., i])
                speed = np.minimum(np.abs(found[MOTOR_SPEED, ..., i]), self.limits[MOTOR_SPEED, i])
                least = LEAST * max(y for _, y in points(peak))
                limits[MOTOR_TORQUE, ..., i] = np.maximum(allowed(peak, speed), least)
        return found, limits

    def uses(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Return (6, ..., n) what is used of each limit, 1 at the limit."""
        values, limits = self.values(q, qd, qdd)
        return np.abs(values) / limits


def bounds_of(model: Model, scene: Scene, acceleration: PerJoint | None, jerk: PerJoint | None, speed: float) -> Bounds:
    """Return the limits of a robot in a scene; speed: the share of the velocity limits that is used.

    Raises:
        InputError: the torques along a path are not those of an open tree on the ground, as above.
    """
    refuse_others(model, scene)
    refuse_load(scene)
    check_moves(model)
    remedy = "robodyn torques computes what a given motion takes"
    if model.floating:
        what = "the base moves, and a path is of a robot that stands"
        raise InputError(what, remedy=remedy, file=model.file)
    if scene.constrained:
        what = "loops, contacts or joints that do not drive: how torques are shared along a path is not known here"
        raise SceneError(what, remedy=remedy)
    if scene.columns:
        what = f"a wrench names the column {shown(scene.columns[0])}, whose course along the path is not known"
        raise SceneError(what, remedy="give forces and moments as numbers")
    limits = np.full((len(LIMITS), model.n), np.inf)
    limits[ACCELERATION] = per_joint(acceleration, model, "acceleration")
    limits[JERK] = per_joint(jerk, model, "jerk")
    for body in model.bodies:
        joint = body.joint
        if joint.kind in ("revolute", "prismatic") and joint.multiplier:
            if (limit := binding(joint.velocity, MOST_VELOCITY)) is not None:
                limits[VELOCITY, joint.rate] = min(limits[VELOCITY, joint.rate], speed * limit / abs(joint.multiplier))
            if (limit := binding(joint.effort, MOST_EFFORT)) is not None and joint.mimics is None:
                limits[EFFORT, joint.rate] = limit
    found = ((joint.rate, train_of(joint, scene)) for joint in model.independent)
    trains = tuple((i, train) for i, train in found if train is not None)
    for i, train in trains:
        most = train.speed_limit or np.inf
        if isinstance(train.motor.peak, tuple):  # just before the end of the curve, behind which there is no torque
            most = min(most, train.motor.peak[-1][0] * (1.0 - 1e-8))
        limits[MOTOR_SPEED, i], limits[GEAR, i] = most, train.motor.gear_peak or np.inf
    return Bounds(model, scene, limits, trains)


def inner(rest: NDArray[np.bool_], parts: Floats) -> Floats:
    """Return (len(parts), N) parts of intervals from one end to the other, or nearly: there a joint may turn back, and
    only a robot at rest, as told (N + 1,) of the ends, is at both sides of that."""
    found = np.repeat(parts[:, None], len(rest) - 1, axis=1)
    found[0, ~rest[:-1]] = 1e-9
    found[-1, ~rest[1:]] = 1.0 - 1e-9
    return found


class Along:
    """A path on a grid s (N + 1,), at the beginning and at the end of its intervals: q, q', q'' (2, N, n); way (N, n):
    the sign of q' between; leg (N,): from which stop on."""

    def __init__(self, bounds: Bounds, path: Path, s: Floats) -> None:
        self.bounds, self.path, self.s = bounds, path, s
        self.steps = np.diff(s)
        self.still = np.isin(np.arange(len(s)), np.abs(s[:, None] - path.stops).argmin(axis=0))
        self.leg = np.clip(np.cumsum(self.still[:-1]) - 1, 0, len(path.stops) - 2)
        self.q, self.first, self.second = self.curve(np.array([[0.0], [1.0]]))
        self.way = np.sign(self.curve(np.array([[0.5]]))[1][0])
        self.parts = inner(self.still, 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, FINE + 1)))
        self.between = self.curve(self.parts)

    def curve(self, parts: Floats) -> tuple[Floats, Floats, Floats]:
        """Return q, q', q'' at these parts of intervals."""
        s = self.s[:-1] + parts * self.steps
        return self.path.at(s, self.path.pieces(s, self.leg))[:3]

    def uses(self, x: Floats) -> Floats:
        """Return (6, N, n) what a pass uses of limits at the most, at all parts of intervals."""
        q, first, second = self.between
        near, u = (x[:-1] + self.parts * np.diff(x))[..., None], (np.diff(x) / (2.0 * self.steps))[:, None]
        used: Floats = self.bounds.uses(q, first * np.sqrt(near), first * u + second * near).max(axis=1)
        return used

    def most(self, kept: Floats) -> Floats:
        """(N + 1,) the largest x that limits of speed leave; 0 where the path stops."""
        speed = self.bounds.speed * np.minimum(kept[VELOCITY], kept[MOTOR_SPEED])
        with np.errstate(divide="ignore"):
            both = np.square(speed / np.abs(self.first)).min(axis=2)
        most = np.full(len(self.s), np.inf)
        most[:-1] = both[0]
        most[1:] = np.minimum(most[1:], both[1])
        return np.asarray(np.where(self.still, 0.0, most))

    def values(self, speed: Floats, u: Floats) -> tuple[Floats, Floats]:
        """Return what is limited, and its limits (6, 2, N, n), at speeds (2, N); at rest that of beginning to move."""
        sd = speed[..., None]
        qd = self.first * sd
        qd = np.where(np.abs(qd) < SLOWEST, SLOWEST * self.way, qd)
        return self.bounds.values(self.q, qd, self.first * u[:, None] + self.second * sd * sd)

    def rows(self, x: Floats, kept: Floats) -> Rows:
        """Return the limits as lines near a profile x (N + 1,), by finite differences: of torques exact, of friction,
        torque-speed curves and gears' losses the tangents; kept (6, N, n): the share of each that may be used."""
        near, u = np.stack((x[:-1], x[1:])), np.diff(x) / (2.0 * self.steps)
        speed, step = np.maximum(np.sqrt(near), SLOWEST), 1e-3 * float(np.abs(u).max()) or 1.0
        ahead = np.where(near > 1e-12, 1.0 / (np.square(speed) * ((1.0 + _STEP) ** 2 - 1.0)), 0.0)[..., None]
        at, sharper, faster = (
            self.values(*each) for each in ((speed, u), (speed, u + step), ((1.0 + _STEP) * speed, u))
        )
        rows = []
        for f in (ACCELERATION, EFFORT, MOTOR_TORQUE, GEAR):
            has = np.isfinite(at[1][f, 0, 0])
            value, limit = (each[f][..., has] for each in at)
            a = (sharper[0][f][..., has] - value) / step
            b = (faster[0][f][..., has] - value) * ahead
            share, level, rises = kept[f][:, has], limit, (faster[1][f][..., has] - limit) * ahead
            rest = value - a * u[:, None] - b * near[..., None]
            may = share * (level - rises * near[..., None])
            for sign in (1.0, -1.0):
                rows.append((sign * a / limit, (sign * b - share * rises) / limit, (may - sign * rest) / limit))
        return Rows(*(np.concatenate(part, axis=2) for part in zip(*rows, strict=True)))
