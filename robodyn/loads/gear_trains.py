"""From a joint's torque to its motor's, and what the motor may give at a speed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.effects.rotor_inertia import rotor_of
from robodyn.errors import SceneError
from robodyn.robot.model import Joint
from robodyn.scene.motor import Curve, Motor
from robodyn.scene.scene import Scene

Floats = NDArray[np.float64]


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
    """The motor and gear that drive a joint; None if the scene says nothing of them.

    Raises:
        SceneError: the gear ratio of the description is 0.
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
    """A curve's points; a torque for all speeds is one point of speed 0."""
    return torque if isinstance(torque, tuple) else ((0.0, torque),)


def allowed(torque: float | Curve, speed: Floats) -> Floats:
    """The torque that a curve allows at these speeds, magnitudes: straight between its points, 0 beyond the last."""
    if not isinstance(torque, tuple):
        return np.full(np.shape(speed), torque)
    speeds, torques = (np.array(column) for column in zip(*torque, strict=True))
    found: Floats = np.interp(speed, speeds, torques, right=0.0)
    return found
