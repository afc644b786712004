"""What limits a robot along a path: exactly at a state, and as lines in the path's acceleration u and squared speed x.

With q(s), `qd = q' sd`, `qdd = q' u + q'' x`; so that `tau = a u + b x + c + friction(qd)`: a, b, c are three states of
one batch of the recursion in a scene without friction, and friction does not depend on the acceleration.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.effects.motors import coupled_motors
from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.errors import InputError, SceneError
from robodyn.loads.sizing import LEAST, Train, allowed, load_torque, motor_torque, points, train_of
from robodyn.robot.limits import MOST_EFFORT, MOST_VELOCITY, binding
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_load
from robodyn.scene.scene import Friction, Scene
from robodyn.sizing.path import Path
from robodyn.sizing.reachability import Rows
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives, shown

LIMITS = ("velocity", "acceleration", "effort", "motor torque", "motor speed", "gear torque", "jerk")
VELOCITY, ACCELERATION, EFFORT, MOTOR_TORQUE, MOTOR_SPEED, GEAR, JERK = range(len(LIMITS))
SLOWEST = 1e-9  # rad/s, m/s: what counts as moving, for the friction at the beginning of a motion
_STEP = 1e-4  # of the speed, over which the slope of friction is taken
PerJoint = float | Sequence[float] | Mapping[str, float]


def per_joint(given: PerJoint | None, model: Model, what: str) -> Floats:
    """Return a limit of each joint (n,), inf where none is given: one number for all, one for each, or by name."""
    names, found = model.joint_names, np.full(model.n, np.inf)
    if given is None:
        return found
    if isinstance(given, Mapping):
        for name, value in given.items():
            if name not in names:
                remedy = alternatives(name, names, "joints")
                raise InputError(f"{what}: there is no joint {shown(name)}", remedy=remedy)
            found[names.index(name)] = value
    else:
        values = np.atleast_1d(np.asarray(given, dtype=float))
        if len(values) not in (1, model.n):
            remedy = "one for all, one for each, or JOINT=VALUE,..."
            raise InputError(f"{what}: {len(values)} numbers for {model.n} joints", remedy=remedy)
        found[:] = values
    if not (found > 0.0).all():
        raise InputError(f"{what} is {found[~(found > 0.0)][0]:g}", remedy="it is positive")
    return found


def check_supported(model: Model, scene: Scene) -> None:
    """Raise where the torques along a path are not those of an open tree on the ground, as above."""
    remedy = "robodyn torques computes what a given motion takes"
    if model.floating:
        what = "the base moves, and a path is of a robot that stands"
        raise InputError(what, remedy=remedy, file=model.file)
    if model.n == 0:
        raise InputError("no joint moves", remedy="give a robot with joints", file=model.file)
    if scene.constrained:
        what = "loops, contacts or joints that do not drive: how torques are shared along a path is not known here"
        raise SceneError(what, remedy=remedy)
    if scene.columns:
        what = f"a wrench names the column {shown(scene.columns[0])}, whose course along the path is not known"
        raise SceneError(what, remedy="give forces and moments as numbers")
    if any(scene.fluid_velocity) and any(each.volume or any(each.drag_area) for each in scene.immersed):
        raise SceneError("the fluid streams, and drag is known here in still fluid only", remedy="leave velocity out")
    refuse_load(scene)


@dataclass(frozen=True, eq=False)
class Bounds:
    """The limits of each coordinate (n,), inf where there is none, and the motors that a scene tells of."""

    model: Model
    scene: Scene
    velocity: Floats
    acceleration: Floats
    effort: Floats
    jerk: Floats
    trains: tuple[tuple[int, Train], ...]

    @property
    def limits(self) -> Floats:
        """(6, n) of what has one number: inf for motor torques."""
        found = np.full((JERK, self.model.n), np.inf)
        found[: EFFORT + 1] = self.velocity, self.acceleration, self.effort
        for i, train in self.trains:
            found[MOTOR_SPEED, i] = _speed_limit(train)
            found[GEAR, i] = train.motor.gear_peak or np.inf
        return found

    @property
    def driven(self) -> NDArray[np.bool_]:
        """(n,) whether a scene tells of the motor."""
        return np.isin(np.arange(self.model.n), [i for i, _ in self.trains])

    @property
    def speed(self) -> Floats:
        """(n,) the largest speeds of joints that they and their motors allow."""
        found = self.velocity.copy()
        for i, train in self.trains:
            found[i] = min(found[i], _speed_limit(train) / abs(train.gear))
        return found

    def torques(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        return inverse_dynamics(self.model, q, qd, qdd, scene=self.scene)

    def uses(self, q: Floats, qd: Floats, qdd: Floats) -> tuple[Floats, Floats]:
        """Return (6, ..., n) what is used of each limit, 1 at the limit, exactly; and the torques (..., n)."""
        tau = self.torques(q, qd, qdd)
        values = np.zeros((JERK, *tau.shape))
        values[: EFFORT + 1] = np.abs(qd), np.abs(qdd), np.abs(tau)
        for i, train in self.trains:
            load = load_torque(train, tau[..., i], qdd[..., i])
            speed = np.abs(train.gear * qd[..., i])
            values[MOTOR_SPEED, ..., i], values[GEAR, ..., i] = speed, np.abs(load)
            if train.motor.peak is not None:
                least = LEAST * max(y for _, y in points(train.motor.peak))
                most = np.maximum(allowed(train.motor.peak, np.minimum(speed, _speed_limit(train))), least)
                torque = motor_torque(train, load, qd[..., i], qdd[..., i])
                values[MOTOR_TORQUE, ..., i] = np.abs(torque) / most
        limits = self.limits
        limits[MOTOR_TORQUE] = 1.0
        return values / limits.reshape(JERK, *(1,) * (tau.ndim - 1), -1), tau


def _speed_limit(train: Train) -> float:
    """The largest speed of a motor [rad/s], just before the end of its peak curve, behind which there is no torque."""
    most = train.speed_limit or np.inf
    return min(most, train.motor.peak[-1][0] * (1.0 - 1e-8)) if isinstance(train.motor.peak, tuple) else most


def bounds_of(model: Model, scene: Scene, acceleration: PerJoint | None, jerk: PerJoint | None, speed: float) -> Bounds:
    """Return the limits of a robot in a scene; speed: the share of the velocity limits that is used."""
    velocity, effort = np.full(model.n, np.inf), np.full(model.n, np.inf)
    for body in model.bodies:
        joint = body.joint
        if joint.kind in ("revolute", "prismatic") and joint.multiplier:
            if (limit := binding(joint.velocity, MOST_VELOCITY)) is not None:
                velocity[joint.rate] = min(velocity[joint.rate], speed * limit / abs(joint.multiplier))
            if (limit := binding(joint.effort, MOST_EFFORT)) is not None and joint.mimics is None:
                effort[joint.rate] = limit
    found = ((joint.rate, train_of(joint, scene)) for joint in model.independent)
    trains = tuple((i, train) for i, train in found if train is not None)
    both = per_joint(acceleration, model, "acceleration"), per_joint(jerk, model, "jerk")
    return Bounds(model, scene, velocity, both[0], effort, both[1], trains)


class Ends(NamedTuple):
    """A path at the beginning and at the end of N intervals: q, q', q'' (2, N, n), and `tau = a u + b x + c`."""

    s: Floats
    q: Floats
    first: Floats
    second: Floats
    a: Floats
    b: Floats
    c: Floats
    way: Floats


class Along:
    """The limits along a path, on a grid s (N + 1,)."""

    def __init__(self, bounds: Bounds, path: Path, s: Floats) -> None:
        self.bounds, self.path, self.s = bounds, path, s
        self.steps = np.diff(s)
        self.piece = path.pieces(0.5 * (s[1:] + s[:-1]))
        self.still = np.isin(np.arange(len(s)), np.abs(s[:, None] - path.stops).argmin(axis=0))
        model, scene = bounds.model, bounds.scene
        smooth = {body.joint.name: Friction() for body in model.bodies if body.joint.kind in ("revolute", "prismatic")}
        motors = tuple(replace(motor, friction=Friction()) for motor, _ in coupled_motors(model, scene))
        self.smooth = replace(scene, friction=smooth, coupled=motors)
        rubs = [*scene.friction.values(), *(motor.friction for motor in scene.coupled)]
        rubs += [Friction(joint.damping, joint.friction) for joint in (body.joint for body in model.bodies)]
        self.rubs = any(rub.viscous or rub.dry for rub in rubs)
        curved = any(isinstance(t.motor.peak, tuple) or t.motor.efficiency < 1.0 for _, t in bounds.trains)
        self.bent = self.rubs or curved
        self.ends = self._ends()
        self.softest = np.full(model.n, np.inf)  # accelerations at most, besides those of limits

    def _ends(self) -> Ends:
        s = np.stack((self.s[:-1], self.s[1:]))
        q, first, second, _ = self.path.at(s, self.piece)
        zero = np.zeros_like(q)
        states = np.stack((q, q, q)), np.stack((zero, zero, first)), np.stack((zero, first, second))
        c, with_u, with_x = inverse_dynamics(self.bounds.model, *states, scene=self.smooth)
        way = np.sign(self.path.at(s.mean(axis=0), self.piece)[1])
        return Ends(s, q, first, second, with_u - c, with_x - c, c, way)

    def friction(self, speed: Floats) -> tuple[Floats, Floats]:
        """Return the torque of friction (2, N, n) at speeds sd (2, N), in the direction of each interval, and its slope
        over x."""
        ends = self.ends
        if not self.rubs:
            return np.zeros_like(ends.c), np.zeros_like(ends.c)
        sd = np.maximum(speed, SLOWEST)[..., None]
        found = []
        for factor in (1.0, 1.0 + _STEP):
            qd = ends.first * (factor * sd)
            qd = np.where(np.abs(qd) < SLOWEST, SLOWEST * ends.way, qd)
            with_it, without = (
                inverse_dynamics(self.bounds.model, ends.q, qd, 0.0, scene=scene)
                for scene in (self.bounds.scene, self.smooth)
            )
            found.append(with_it - without)
        slope = (found[1] - found[0]) / (sd * sd * ((1.0 + _STEP) ** 2 - 1.0))
        return found[0], np.where(speed[..., None] > 1e-6, slope, 0.0)

    def most(self, kept: Floats) -> Floats:
        """(N + 1,) the largest x that limits of speed leave; 0 where the path stops."""
        limits = self.bounds.limits * kept.transpose(1, 0, 2)
        speed = limits[:, VELOCITY]
        for i, train in self.bounds.trains:
            speed[:, i] = np.minimum(speed[:, i], limits[:, MOTOR_SPEED, i] / abs(train.gear))
        with np.errstate(divide="ignore"):
            both = np.square(speed / np.abs(self.ends.first)).min(axis=2)
        most = np.full(len(self.s), np.inf)
        most[:-1] = both[0]
        most[1:] = np.minimum(most[1:], both[1])
        return np.asarray(np.where(self.still, 0.0, most))

    def rows(self, x: Floats, kept: Floats) -> Rows:
        """Return the limits as lines near a profile x (N + 1,); kept (6, N, n): the share of each that may be used.

        Friction and torque-speed curves are taken by their tangents at x, and of the two ways to reckon a gear's loss
        that which holds there, where only one of them may.
        """
        ends, n = self.ends, len(self.steps)
        near = np.stack((x[:-1], x[1:]))
        speed = np.sqrt(near)
        rub, slope = self.friction(speed)
        b, c = ends.b + slope, ends.c + rub - slope * near[..., None]
        limits = self.bounds.limits[:, None] * kept
        limits[ACCELERATION] = np.minimum(self.bounds.acceleration, self.softest) * kept[ACCELERATION]
        rows: list[tuple[Floats, Floats, Floats]] = []

        def between(a: Floats, b: Floats, c: Floats, limit: Floats) -> None:
            """Add `|a u + b x + c| <= limit` of joints that have one."""
            of = np.isfinite(limit[0])
            size = limit[:, of]
            for sign in (1.0, -1.0):
                parts = sign * a[..., of], sign * b[..., of], size - sign * c[..., of]
                rows.append(tuple(np.asarray(each / size) for each in parts))  # type: ignore[arg-type]

        between(ends.first, ends.second, np.zeros_like(c), limits[ACCELERATION])
        between(ends.a, b, c, limits[EFFORT])
        u = np.diff(x) / (2.0 * self.steps)
        for i, train in self.bounds.trains:
            one = slice(i, i + 1)
            gear, own = train.gear, train.gear * train.inertia
            first, second, way = (each[..., one] for each in (ends.first, ends.second, ends.way))
            parts = ends.a[..., one] - gear * own * first, b[..., one] - gear * own * second, c[..., one]
            between(*parts, limits[GEAR, :, one])
            if train.motor.peak is None:
                continue
            load = parts[0] * u[:, None] + parts[1] * near[..., None] + parts[2]
            loss = train.motor.efficiency
            top, share_kept = max(y for _, y in points(train.motor.peak)), kept[MOTOR_TORQUE, :, one]
            for level, falls in _tangents(train, np.abs(gear * first), near[..., None], speed[..., None]):
                for sign in (1.0, -1.0):
                    forwards = sign * np.sign(gear) * way > 0.0
                    held = np.where(way == 0.0, 1.0, np.where(load * way > 0.0, 1.0 / loss, loss))
                    for share in (loss, 1.0 / loss)[: 1 if loss == 1.0 else 2]:
                        by = np.where(forwards, share, held) / gear
                        a_row, b_row, c_row = own * first + by * parts[0], own * second + by * parts[1], by * parts[2]
                        row = sign * a_row, sign * b_row + share_kept * falls, share_kept * level - sign * c_row
                        rows.append(tuple(np.asarray(each / top) for each in row))  # type: ignore[arg-type]
        empty = np.empty((2, n, 0))
        return Rows(*(np.concatenate([empty, *part], axis=2) for part in zip(*rows, strict=True)))


def _tangents(train: Train, per_sd: Floats, x: Floats, sd: Floats) -> list[tuple[Floats, Floats]]:
    """Return (level, falls) of `T + falls x <= level`: the pieces of a peak curve at these speeds and beside it where
    the curve bends downwards, as lines in x; speed = per_sd sd."""
    curve = points(train.motor.peak or 0.0)
    if len(curve) == 1:
        return [(np.full_like(per_sd, curve[0][1]), np.zeros_like(per_sd))]
    v, y = (np.array(column) for column in zip(*curve, strict=True))
    v, y = (np.concatenate(([0.0], v)), np.concatenate((y[:1], y))) if v[0] > 0.0 else (v, y)
    with np.errstate(divide="ignore", invalid="ignore"):
        m = np.where(np.diff(v) > 0.0, np.diff(y) / np.diff(v), 0.0)
    speed = per_sd * sd
    here = np.clip(np.searchsorted(v, speed, side="right") - 1, 0, len(m) - 1)
    found = []
    for beside in (0, -1, 1):
        k = np.clip(here + beside, 0, len(m) - 1)
        if beside:
            bends = (m[k] - m[here]) * beside < 0.0
            k = np.where(bends, k, here)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.where(sd > 1e-6, m[k] * per_sd / (2.0 * sd), 0.0)  # of the curve over x
        level = y[k] + m[k] * (speed - v[k]) - slope * x
        found.append((level, -slope))
    return found
