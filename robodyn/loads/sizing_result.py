"""What motors, gears, bearings and the foundation have to bear: frozen data that reports turn into text and JSON."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from robodyn.loads.figures import ComponentLoad, Range, ShaftLoad
from robodyn.scene.parts import Curve

Vector = tuple[float, float, float]
Level = Literal["OK", "over continuous", "over peak", "no limits"]
Quantity = Literal[
    "motor torque", "motor speed", "RMS motor torque", "gear torque", "mean gear torque", "effort", "velocity"
]


@dataclass(frozen=True)
class Exceeded:
    """One limit of a joint that the motion exceeds; all values are magnitudes.

    Attributes:
        quantity: what is too large. RMS motor torque and mean gear torque wear out and heat, the others break or stall.
        value, limit, unit: at the moment when value / limit is largest.
        time, row: of that moment [s; from 1]; None for quantities of the whole motion.
        speed: of the motor then, or its mean over the motion where the limit depends on it; else None.
        seconds: how long the limit is exceeded in all; None for quantities of the whole motion.
    """

    quantity: Quantity
    value: float
    limit: float
    unit: str
    time: float | None = None
    row: int | None = None
    speed: float | None = None
    seconds: float | None = None
    JSON_ALSO: ClassVar = ("excess", "level")

    @property
    def level(self) -> Level:
        return "over continuous" if self.quantity in ("RMS motor torque", "mean gear torque") else "over peak"

    @property
    def excess(self) -> float:
        return self.value - self.limit


@dataclass(frozen=True)
class Nearest:
    """The sample at which |torque| / limit is largest: closest to a motor's peak curve, or beyond it; magnitudes."""

    torque: float
    limit: float
    speed: float
    time: float
    row: int


@dataclass(frozen=True)
class MotorLoad(ShaftLoad):
    """What a motor does at its shaft.

    `T = G J qdd + (tau - G^2 J qdd) / (G e^s)`, `s = sign((tau - G^2 J qdd) qd)`, `w = G qd`: the gear of ratio G and
    efficiency e takes from the motor's power when the motor drives the load, and from the load's when the load drives
    the motor; at rest (s = 0) it takes nothing. The rotor, of inertia J, is on the motor's side of it.

    Attributes:
        gear, efficiency, inertia: G, e and J; inertia_ratio: of the load's inertia, reflected to the motor, over J, in
            the pose of the joint's peak torque; None without a rotor.
        mean_speed: of |w|, over the whole time.
        continuous, peak_curve: points of the curves as given, a torque that holds for all speeds as one of speed 0.
        continuous_limit: continuous torque at `mean_speed`; rms must not exceed it. None where it is not known.
        seconds_above_continuous: how long |T| is above the continuous curve, which a motor bears for moments.
        nearest: where the motor comes closest to its peak curve; seconds_over_peak: how long it is beyond.
        speed_limit, seconds_over_speed: the largest speed allowed, and how long it is exceeded.
    """

    speed_unit: str
    gear: float
    efficiency: float
    inertia: float
    inertia_ratio: float | None
    mean_speed: float
    continuous: Curve | None
    peak_curve: Curve | None
    continuous_limit: float | None
    seconds_above_continuous: float
    nearest: Nearest | None
    seconds_over_peak: float
    speed_limit: float | None
    seconds_over_speed: float
    JSON_ALSO: ClassVar = ("continuous_margin", "peak_margin")

    @property
    def continuous_margin(self) -> float | None:
        """What is left of the continuous torque, negative if exceeded."""
        return None if self.continuous_limit is None else self.continuous_limit - self.rms

    @property
    def peak_margin(self) -> float | None:
        """What is left below the peak curve at `nearest`, negative if exceeded."""
        return None if self.nearest is None else self.nearest.limit - self.nearest.torque


@dataclass(frozen=True)
class JointSizing:
    """How one joint is used, whether it may be, and what that asks of its motor.

    Attributes:
        duty_cycle: the share of the time in which the joint moves; slower than `standstill` [rad/s or m/s] it cannot be
            told from one that stands still, by the resolution of the table's positions.
        static_peak, static_peak_time, static_rms: of the torque that stands still in each pose of the motion: gravity,
            springs, buoyancy, wrenches of the scene. static_share: static_rms / rms, the static hold share.
        motor: None where the scene has none for this joint.
        level: "no limits" where nothing is known that could be exceeded.
        exceeded: worst first.
    """

    name: str
    unit: str
    duty_cycle: float
    standstill: float
    mean_speed: float
    static_peak: float
    static_peak_time: float
    static_rms: float
    static_share: float
    motor: MotorLoad | None
    level: Level
    exceeded: tuple[Exceeded, ...]


@dataclass(frozen=True)
class Component(ComponentLoad):
    """A component of a bearing's load [N or N m]."""

    unit: str
    peak_row: int


@dataclass(frozen=True)
class BearingLoad:
    """What the bearing or the guide of a joint transmits from parent to child, at the joint's origin.

    Attributes:
        kind: "revolute" or "prismatic".
        directions: u, v and the joint's axis, orthonormal, in the child link's frame.
        components: the five that the joint cannot give way to: of a hinge fu, fv, fa (along the axis), mu and mv; of a
            slide fu, fv, mu, mv and ma.
        radial, tilting: sqrt(fu^2 + fv^2) and sqrt(mu^2 + mv^2) of each sample.
    """

    joint: str
    kind: str
    directions: tuple[Vector, Vector, Vector]
    components: tuple[Component, ...]
    radial: Component
    tilting: Component


@dataclass(frozen=True)
class FoundationLoad(Range):
    """A load by which foundations are dimensioned: fxy, fz, mxy or mz, of the ground on the robot, in the base's axes.

    fxy and mxy are resultants in the plane, whatever their direction. The loads do not peak together.
    """

    mean: float
    unit: str


@dataclass(frozen=True)
class Sizing:
    """What motors, gears, bearings and the foundation have to bear along a motion."""

    joints: tuple[JointSizing, ...]
    bearings: tuple[BearingLoad, ...]
    foundation: tuple[FoundationLoad, ...]

    @property
    def exceeded(self) -> bool:
        """Whether any joint is over what it may bear."""
        return any(joint.exceeded for joint in self.joints)
