"""What motors and gears do along a motion, gathered block by block."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.motors import rotor_of
from robodyn.errors import SceneError
from robodyn.loads.result import MotorLoad, Nearest
from robodyn.loads.statistics import Greatest, ShaftFigures
from robodyn.robot.model import Joint
from robodyn.scene.parts import Curve, Motor
from robodyn.scene.scene import Scene
from robodyn.support.floats import BEYOND, Floats


class Train(NamedTuple):
    """The way from a motor to its joint.

    Attributes:
        gear: turns of the motor per turn of the joint (rad/m for a slide); inertia: of the rotor [kg m^2].
        rotary: whether the motor turns, or pushes a slide without a gear.
    """

    motor: Motor
    gear: float
    inertia: float
    rotary: bool

    @property
    def speed_limit(self) -> float | None:
        """The largest speed allowed [rad/s]."""
        most = self.motor.max_speed
        return self.motor.peak[-1][0] if most is None and isinstance(self.motor.peak, tuple) else most


def train_of(joint: Joint, scene: Scene) -> Train | None:
    """Return the motor and gear that drive a joint; None if the scene says nothing of them.

    Raises:
        SceneError: the gear ratio of the description is 0, or the rotor's gyroscopic moments count.
    """
    motor = scene.motor.get(joint.name)
    if motor is None:
        return None
    inertia, gear = rotor_of(joint, scene)
    if not gear:
        raise SceneError(
            f"[motor] {joint.name}: the gear ratio is 0", remedy="turns of the motor per turn of the joint"
        )
    rotor = scene.rotor.get(joint.name)
    if rotor is not None and rotor.spins:
        what = f"[motor] {joint.name}: its rotor has an axis, and motors are judged by rotors that turn in place"
        raise SceneError(what, remedy="leave axis and on of [rotor] out, or [motor]")
    geared = joint.reduction != 1.0 or (rotor is not None and rotor.gear is not None)
    return Train(motor, gear, inertia, joint.kind != "prismatic" or geared)


def load_torque(train: Train, tau: Floats, qdd: Floats) -> Floats:
    """What the gear gives to the joint, `tau - G^2 J qdd` [N m]: the torque without what turns the rotor itself."""
    return tau - (train.gear * train.gear * train.inertia) * qdd


def motor_torque(train: Train, load: Floats, qd: Floats, qdd: Floats) -> Floats:
    """`T = G J qdd + load / (G e^s)`, `s = sign(load qd)`: the torque at the motor's shaft [N m].

    The gear's loss is e of the power that enters it: the motor's when it drives the load, the load's when that drives
    the motor; none at rest.

    Args:
        load: of `load_torque` (N,); qd, qdd: of the joint (N,).
    """
    driving = np.sign(load) * np.sign(qd)
    share = np.where(driving > 0, 1.0 / train.motor.efficiency, np.where(driving < 0, train.motor.efficiency, 1.0))
    return (train.gear * train.inertia) * qdd + load * share / train.gear


def points(torque: float | Curve) -> Curve:
    """Return a curve's points; a torque for all speeds is one point of speed 0."""
    return torque if isinstance(torque, tuple) else ((0.0, torque),)


def allowed(torque: float | Curve | None, speed: Floats | float) -> Floats:
    """The torque that a curve allows at these speeds, magnitudes: straight between its points, 0 beyond the last.

    Infinite without a curve.
    """
    if torque is None:
        return np.full(np.shape(speed), np.inf)
    if not isinstance(torque, tuple):
        return np.full(np.shape(speed), torque)
    speeds, torques = (np.array(column) for column in zip(*torque, strict=True))
    return np.asarray(np.interp(speed, speeds, torques, right=0.0))


LEAST = 1e-9
"""Of a peak curve's largest torque: what its use is measured by where it allows less, beyond its last speed."""


class MotorPass(ShaftFigures):
    """Peaks and integrals at the shafts of motors.

    Attributes:
        gear: the torque that each gear bears where it is largest, in magnitude.
    """

    def __init__(self, trains: Sequence[Train]) -> None:
        super().__init__(len(trains))
        self.trains, self.gear, self.near = tuple(trains), Greatest(len(trains)), Greatest(len(trains))
        tops = [0.0 if train.motor.peak is None else max(y for _, y in points(train.motor.peak)) for train in trains]
        self.least = LEAST * np.array(tops)[:, None] + np.finfo(float).tiny

    def update(self, time: Floats, first_row: int, tau: Floats, qd: Floats, qdd: Floats) -> None:
        """Take in a block; tau, qd, qdd: (k, N) of the joints."""
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
            "joint travel": np.abs(qd),
            "above continuous": (size > BEYOND * continuous).astype(float),
            "over peak": (size > BEYOND * peak).astype(float),
            "over speed": (pace > BEYOND * fastest).astype(float),
            "over gear": (carried > BEYOND * most).astype(float),
        }
        self.gather(time, first_row, torque, speed, more)

    def mean_gear_torque(self, i: int) -> float:
        """Return the cubic mean of what gear i bears, `cbrt(integral |load^3 qd| dt / integral |qd| dt)` [N m]."""
        travel = self.integrals.totals["joint travel"][i]
        return float(self.integrals.totals["wear"][i] / travel) ** (1 / 3) if travel else 0.0

    def load(self, i: int, duration: float, inertia: float | None) -> MotorLoad:
        """Return the figures of motor i, which accelerates this inertia at the joint, with its rotor [kg m^2]."""
        train, totals = self.trains[i], {name: values[i] for name, values in self.integrals.totals.items()}
        motor = train.motor
        mean_speed = float(self.speed.score[i] if duration <= 0 else totals["travel"] / duration)
        rotor = train.gear * train.gear * train.inertia
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
        )
