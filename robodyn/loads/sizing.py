"""How joints, motors, bearings and the foundation are used along a motion, gathered block by block."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.effects.motors import rotor_of
from robodyn.dynamics.plan import torque_runner
from robodyn.errors import SceneError
from robodyn.loads.result import (
    DEGREES,
    BearingLoad,
    Component,
    Exceeded,
    FoundationLoad,
    JointLoad,
    JointSizing,
    Level,
    MotorLoad,
    Nearest,
    Sizing,
)
from robodyn.loads.statistics import Extremes, Greatest, Integrals, ShaftFigures
from robodyn.loads.temperature import Heat, HeatPass
from robodyn.programs.run.runner import Runner
from robodyn.programs.vectors import frame, product
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Curve, GearLife, Motor, Scene
from robodyn.support.floats import BEYOND, LARGEST, Floats, steady
from robodyn.trajectory.motion import Trajectory

LEAST = 1e-9
"""Of a peak curve's largest torque: what its use is measured by where it allows less, beyond its last speed."""
NAMES = {"revolute": ("fu", "fv", "fa", "mu", "mv"), "prismatic": ("fu", "fv", "mu", "mv", "ma")}
_RESULTANTS = ("radial", "tilting")
_WIDTH = 7
PIECE = 8192  # samples worked on at a time, so that what belongs to them stays in the cache
FOUNDATION = ("fxy", "fz", "mxy", "mz")


class Train(NamedTuple):
    """The way from a motor to its joint; gear: turns of the motor per turn of the joint (rad/m for a slide); inertia:
    of the rotor [kg m^2]; rotary: whether the motor turns, or pushes a slide without a gear."""

    motor: Motor
    gear: float
    inertia: float
    rotary: bool
    life: GearLife | None = None

    @property
    def speed_limit(self) -> float | None:
        """The largest speed allowed [rad/s]."""
        most = self.motor.max_speed
        return self.motor.peak[-1][0] if most is None and isinstance(self.motor.peak, tuple) else most


def train_of(joint: Joint, scene: Scene) -> Train | None:
    """Return the motor and gear that drive a joint; None if the scene says nothing of them; raise SceneError if the
    gear ratio of the description is 0, or the rotor's gyroscopic moments count."""
    life = scene.gear_life.get(joint.name)
    motor = scene.motor.get(joint.name, Motor() if life else None)
    if motor is None:
        return None
    inertia, gear = rotor_of(joint, scene)
    if not gear:
        what = f"[motor] {joint.name}: the gear ratio is 0"
        raise SceneError(what, remedy="turns of the motor per turn of the joint")
    rotor = scene.rotor.get(joint.name)
    if rotor is not None and rotor.spins:
        what = f"[motor] {joint.name}: its rotor has an axis, and motors are judged by rotors that turn in place"
        raise SceneError(what, remedy="leave axis and on of [rotor] out, or [motor]")
    geared = joint.reduction != 1.0 or (rotor is not None and rotor.ratio is not None)
    if life and not geared:
        what = f"[gear] {joint.name}: its ratio is not said, and its life depends on the speed of its input"
        raise SceneError(what, remedy=f"write [motor.{joint.name}] gear = turns of the motor per turn of the joint")
    return Train(motor, gear, inertia, joint.kind != "prismatic" or geared, life)


def load_torque(train: Train, tau: Floats, qdd: Floats) -> Floats:
    """What the gear gives to the joint, `tau - G^2 J qdd` [N m]: the torque without what turns the rotor itself."""
    return tau - (train.gear * train.gear * train.inertia) * qdd


def motor_torque(train: Train, load: Floats, qd: Floats, qdd: Floats) -> Floats:
    """`T = G J qdd + load / (G e^s)`, `s = sign(load qd)`: the torque at the motor's shaft [N m], of loads of
    `load_torque` (N,). The loss is e of the power that enters the gear, from motor or load; none at rest."""
    driving = np.sign(load) * np.sign(qd)
    share = np.where(driving > 0, 1.0 / train.motor.efficiency, np.where(driving < 0, train.motor.efficiency, 1.0))
    return (train.gear * train.inertia) * qdd + load * share / train.gear


def points(torque: float | Curve) -> Curve:
    """Return a curve's points; a torque for all speeds is one point of speed 0."""
    return torque if isinstance(torque, tuple) else ((0.0, torque),)


def allowed(torque: float | Curve | None, speed: Floats | float) -> Floats:
    """The largest torque at these speeds: straight between a curve's points, 0 beyond the last; inf without one."""
    if torque is None:
        return np.full(np.shape(speed), np.inf)
    if not isinstance(torque, tuple):
        return np.full(np.shape(speed), torque)
    speeds, torques = (np.array(column) for column in zip(*torque, strict=True))
    return np.asarray(np.interp(speed, speeds, torques, right=0.0))


class MotorPass(ShaftFigures):
    """Peaks and integrals at the shafts of motors; gear: the largest torque that each gear bears, in magnitude."""

    def __init__(self, trains: Sequence[Train]) -> None:
        super().__init__(len(trains))
        self.trains, self.gear, self.near = tuple(trains), Greatest(len(trains)), Greatest(len(trains))
        tops = [0.0 if train.motor.peak is None else max(y for _, y in points(train.motor.peak)) for train in trains]
        self.least = LEAST * np.array(tops)[:, None] + np.finfo(float).tiny
        thermals = {i: train.motor.thermal for i, train in enumerate(trains) if train.motor.thermal is not None}
        self.heat = HeatPass(thermals) if thermals else None

    def update(self, time: Floats, first_row: int, tau: Floats, qd: Floats, qdd: Floats) -> None:
        trains = self.trains
        load = np.array([load_torque(train, *x) for train, *x in zip(trains, tau, qdd, strict=True)])
        torque = np.array([motor_torque(train, *x) for train, *x in zip(trains, load, qd, qdd, strict=True)])
        speed = qd * np.array([[train.gear] for train in trains])
        size, pace, carried = np.abs(torque), np.abs(speed), np.abs(load)
        continuous, peak = (
            np.array([allowed(getattr(train.motor, name), v) for train, v in zip(trains, pace, strict=True)])
            for name in ("continuous", "peak")
        )
        fastest = np.array([[np.inf if train.speed_limit is None else train.speed_limit] for train in trains])
        most = np.array([[train.motor.gear_peak or np.inf] for train in trains])
        self.gear.update(time, first_row, carried)
        use = size / np.maximum(peak, self.least)
        self.near.update(time, first_row, use, torque=size, speed=pace, limit=peak)
        more = {
            "wear": carried * carried * carried * np.abs(qd),
            "gear loss": torque * speed - tau * qd,
            "joint travel": np.abs(qd),
            "above continuous": (size > BEYOND * continuous).astype(float),
            "over peak": (size > BEYOND * peak).astype(float),
            "over speed": (pace > BEYOND * fastest).astype(float),
            "over gear": (carried > BEYOND * most).astype(float),
        }
        self.gather(time, first_row, torque, speed, more)
        if self.heat is not None:
            self.heat.update(time, torque, speed)

    def load(self, i: int, duration: float, inertia: float | None) -> MotorLoad:
        """Return the figures of motor i, which accelerates this inertia at the joint, with its rotor [kg m^2]."""
        train, totals = self.trains[i], {name: values[i] for name, values in self.integrals.totals.items()}
        motor = train.motor
        mean_speed = float(self.speed.score[i] if duration <= 0 else totals["travel"] / duration)
        rotor = train.gear * train.gear * train.inertia
        travel = totals["joint travel"]
        gear_mean = float(totals["wear"] / travel) ** (1 / 3) if travel else 0.0
        life = np.inf
        if train.life is not None and mean_speed * gear_mean > 0.0:
            life = train.life.rated_life * train.life.rated_speed / mean_speed
            life *= float(np.power(train.life.rated_torque / gear_mean, 3))
        nearest = None
        if motor.peak is not None:
            near, at = self.near, {name: float(values[i]) for name, values in self.near.kept.items()}
            nearest = Nearest(at["torque"], at["limit"], at["speed"], float(near.time[i]), int(near.row[i]))
        return MotorLoad(
            unit="N m" if train.rotary else "N",
            speed_unit="rad/s" if train.rotary else "m/s",
            gear=train.gear,
            efficiency=motor.efficiency,
            inertia=train.inertia,
            inertia_ratio=(inertia - rotor) / rotor if rotor and inertia is not None else None,
            **self.figures(i),
            mean_speed=mean_speed,
            continuous=None if motor.continuous is None else points(motor.continuous),
            peak_curve=None if motor.peak is None else points(motor.peak),
            continuous_limit=None if motor.continuous is None else float(allowed(motor.continuous, mean_speed)),
            seconds_above_continuous=float(totals["above continuous"]),
            nearest=nearest,
            seconds_over_peak=float(totals["over peak"]),
            speed_limit=train.speed_limit,
            seconds_over_speed=float(totals["over speed"]),
            gear_loss=float(totals["gear loss"]),
            gear_mean=gear_mean,
            gear_life=life if life < LARGEST else None,
        )


class BearingPass:
    """Peaks and mean squares of the five components that each joint cannot give way to."""

    def __init__(self, model: Model) -> None:
        numbered = enumerate(body.joint for body in model.bodies[1:])
        self.joints = [(k, joint) for k, joint in numbered if joint.kind in NAMES]
        self.frames = [frame(joint.axis) for _, joint in self.joints]
        self.peaks = Greatest(_WIDTH * len(self.joints))
        self.integrals = Integrals()

    def update(self, time: Floats, first_row: int, wrenches: Floats) -> None:
        """Take in a block; wrenches: (N, 6 (bodies - 1)) f and m on every body but the base, in its axes."""
        rows = [np.empty((0, len(time)))]
        for (k, joint), turn in zip(self.joints, self.frames, strict=True):
            f, m = (product(turn, wrenches[:, at : at + 3].T) for at in (6 * k, 6 * k + 3))
            kept = (f, m[:2]) if joint.kind == "revolute" else (f[:2], m)
            rows += [*kept, np.hypot(f[0], f[1])[None], np.hypot(m[0], m[1])[None]]
        values = np.concatenate(rows)
        self.peaks.update(time, first_row, np.abs(values), value=values)
        self.integrals.update(time, {"square": values * values})

    def report(self) -> tuple[BearingLoad, ...]:
        """Return the loads so far; those of a motion without duration are their own RMS."""
        peaks = self.peaks
        rms = np.sqrt(self.integrals.mean("square", peaks.score**2))

        def component(at: int, name: str) -> Component:
            unit = "N m" if name.startswith(("m", "t")) else "N"
            value, when = float(peaks.kept["value"][at]), float(peaks.time[at])
            return Component(name, value, when, float(rms[at]), unit, int(peaks.row[at]))

        loads = []
        for i, ((_, joint), turn) in enumerate(zip(self.joints, self.frames, strict=True)):
            parts = [component(_WIDTH * i + k, name) for k, name in enumerate((*NAMES[joint.kind], *_RESULTANTS))]
            u, v, axis = ((float(x) + 0.0, float(y) + 0.0, float(z) + 0.0) for x, y, z in turn)
            loads.append(BearingLoad(joint.name, joint.kind, (u, v, axis), tuple(parts[:5]), parts[5], parts[6]))
        return tuple(loads)


class SizingPass:
    """Gathers what `Sizing` tells, block by block; trains: joints with motors, by their place among `joints`."""

    def __init__(self, model: Model, scene: Scene, joints: Sequence[Joint], rates: slice, history: bool) -> None:
        """Args: joints: those whose loads are reported; rates: their entries of tau; history: keep courses."""
        self.model, self.scene, self.rates, self.history = model, scene, rates, history
        self.heat: Heat | None = None
        self.trains = [(k, train) for k, joint in enumerate(joints) if (train := train_of(joint, scene)) is not None]
        self.driven = [k for k, _ in self.trains]
        self.motors = MotorPass([train for _, train in self.trains])
        self.bearings = BearingPass(model)
        self.static = Greatest(len(joints))
        self.base = Extremes(FOUNDATION)
        self.integrals = Integrals()
        self.slowest = np.zeros(len(joints))

    def take(self, block: Trajectory, loads: Floats, static: Floats) -> None:
        """Take in a block of loads (N, k): tau, the base wrench, the wrenches of all other bodies; static (N, n)."""
        n, rates, driven = self.model.n, self.rates, self.driven
        if block.slowest is not None:
            self.slowest = block.slowest[rates]
        for start in range(0, len(block), PIECE):
            k, row = slice(start, start + PIECE), block.first_row + start
            time, each = block.time[k], loads[k]
            of_joints = (each[:, :n][:, rates], block.qd[k, rates], block.qdd[k, rates], static[k, rates])
            tau, qd, qdd, still = (np.ascontiguousarray(x.T) for x in of_joints)
            f, m = each[:, n : n + 3], each[:, n + 3 : n + 6]
            base = np.column_stack((np.hypot(f[:, 0], f[:, 1]), f[:, 2], np.hypot(m[:, 0], m[:, 1]), m[:, 2]))
            pace = np.abs(qd)
            self.static.update(time, row, np.abs(still), value=still)
            self.base.update(time, base)
            quantities = {
                "moving": (pace > self.slowest[:, None]).astype(float),
                "travel": pace,
                "static square": still * still,
                "base": base.T,
            }
            self.integrals.update(time, quantities)
            self.bearings.update(time, row, each[:, n + 6 :])
            if driven:
                self.motors.update(time, row, tau[driven], qd[driven], qdd[driven])

    def static_runner(self) -> Runner:
        rates = frozenset((source, k) for source in ("qd", "qdd") for k in range(self.model.n))
        return torque_runner(self.model, self.scene, rates)

    @property
    def figures(self) -> Iterator[Floats]:
        """All integrals, which are finite unless something overflows."""
        for integrals in (self.integrals, self.motors.integrals, self.bearings.integrals):
            yield from integrals.totals.values()

    def report(self, loads: Sequence[JointLoad], inertias: Mapping[int, float | None]) -> Sizing:
        """Return everything gathered; inertias: what motors accelerate at their peaks, None where nothing drives."""
        duration = self.integrals.duration
        motors = {k: self.motors.load(i, duration, inertias[k]) for i, k in enumerate(self.driven)}
        if self.motors.heat is not None:
            self.heat = self.motors.heat.report([loads[k].name for k in self.driven], self.history)
            motors = {k: replace(motors[k], heat=self.heat.motors.get(loads[k].name)) for k in self.driven}
        joints = tuple(self._joint(k, load, motors.get(k), duration) for k, load in enumerate(loads))
        base = self.base.ranges()
        means = self.integrals.mean("base", np.array([each.greatest for each in base])).tolist()
        foundation = [
            FoundationLoad(**vars(each), mean=mean, unit="N" if each.name[0] == "f" else "N m")
            for each, mean in zip(base, means, strict=True)
        ]
        return Sizing(joints, self.bearings.report(), tuple(foundation), self.heat and self.heat.bus)

    def _joint(self, k: int, load: JointLoad, motor: MotorLoad | None, duration: float) -> JointSizing:
        totals = self.integrals.totals
        still = duration <= 0
        peak = float(self.static.kept["value"][k])
        rms = abs(peak) if still else float(np.sqrt(totals["static square"][k] / duration))
        limited = list(self._limited(k, load, motor))
        beyond = [x for x in limited if x.value > BEYOND * x.limit or x.quantity == "thermal runaway"]
        beyond.sort(key=lambda each: -float(steady(each.value / each.limit)) if each.limit else -np.inf)
        exceeded = sorted(beyond, key=lambda each: each.level != "over peak")  # what breaks before what wears
        level: Level = exceeded[0].level if exceeded else "OK" if limited else "no limits"
        moving = abs(load.max_speed) > self.slowest[k]
        return JointSizing(
            name=load.name,
            unit=load.unit,
            duty_cycle=float(moving) if still else min(float(totals["moving"][k]) / duration, 1.0),
            standstill=float(self.slowest[k]),
            mean_speed=abs(load.max_speed) if still else float(totals["travel"][k]) / duration,
            static_peak=peak,
            static_peak_time=float(self.static.time[k]),
            static_rms=rms,
            static_share=rms / load.rms if load.rms else 0.0,
            motor=motor,
            level=level,
            exceeded=tuple(exceeded),
        )

    def _thermal_limits(self, motor: MotorLoad) -> Iterator[tuple[Any, ...]]:
        """Yield what keeps a motor from burning: its temperatures, or the RMS torque where nothing tells them."""
        if (heat := motor.heat) is None:
            yield "RMS motor torque", motor.rms, motor.continuous_limit, motor.unit, None, None, motor.mean_speed
            return
        if heat.winding is None or heat.winding_once is None:
            yield "thermal runaway", heat.winding_once or 0.0, heat.winding_limit, DEGREES
            return
        for name in ("winding", "housing"):
            once, repeated = getattr(heat, f"{name}_once"), getattr(heat, name)
            hottest = repeated if once is None else max(once, repeated)
            yield f"{name} temperature", hottest, getattr(heat, f"{name}_limit"), DEGREES

    def _limited(self, k: int, load: JointLoad, motor: MotorLoad | None) -> Iterator[Exceeded]:
        """Yield what has a limit, whether that is exceeded or not."""
        rows: list[tuple[Any, ...]] = []
        if motor is not None:
            i, unit = self.driven.index(k), motor.unit
            given, gear, totals = self.motors.trains[i].motor, self.motors.gear, self.motors.integrals.totals
            if (near := motor.nearest) is not None:
                at_speed = (near.time, near.row, near.speed, motor.seconds_over_peak)
                rows.append(("motor torque", near.torque, near.limit, unit, *at_speed))
            fast = (motor.max_speed_time, motor.max_speed_row, None, motor.seconds_over_speed)
            when = float(gear.time[i]), int(gear.row[i]), None, float(totals["over gear"][i])
            rows += [
                ("motor speed", abs(motor.max_speed), motor.speed_limit, motor.speed_unit, *fast),
                *self._thermal_limits(motor),
                ("gear torque", float(gear.score[i]), given.gear_peak, load.unit, *when),
                ("mean gear torque", motor.gear_mean, given.gear_average, load.unit),
            ]
        when = load.peak_time, load.peak_row, None, load.seconds_over_effort
        fast = load.max_speed_time, load.max_speed_row, None, load.seconds_over_velocity
        rows += [
            ("effort", abs(load.peak), load.effort_limit, load.unit, *when),
            ("velocity", abs(load.max_speed), load.velocity_limit, "rad/s" if load.unit == "N m" else "m/s", *fast),
        ]
        return (Exceeded(*row) for row in rows if row[2] is not None)
