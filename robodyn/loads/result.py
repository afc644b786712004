"""What `torques` answers: frozen data that reports turn into text and JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, ClassVar, Literal

from robodyn.dynamics.effects.effect import Verdict
from robodyn.errors import TOO_FEW, Caveat
from robodyn.robot.limits import Coverage, Excess, reached_beyond, within
from robodyn.scene.scene import Curve, Vector
from robodyn.support.floats import BEYOND, Floats
from robodyn.support.wording import Cell, Shown, count, figure, shown
from robodyn.trajectory.motion import Derivation

if TYPE_CHECKING:
    from polars import DataFrame

    from robodyn.loads.constraint_result import Constraints
    from robodyn.loads.temperature import Electric, Heat, MotorHeat
    from robodyn.loads.uncertainty_result import Uncertain
    from robodyn.support.courses import Courses

_SHOWN = 6
"""Joints that a result names in its repr."""
DEGREES = "degC"
Level = Literal["OK", "over continuous", "over temperature", "over peak", "no limits"]
_Temperature = Literal["winding temperature", "housing temperature", "thermal runaway"]
_Load = Literal[
    "motor torque", "motor speed", "RMS motor torque", "gear torque", "mean gear torque", "effort", "velocity"
]
Quantity = Literal[_Load, _Temperature]


@dataclass(frozen=True)
class ShaftLoad:
    """Torque [N m], speed [rad/s], power [W] and work [J], done by the actuator and returned to it, of a joint or a
    motor; N and m/s of a slide. Peaks are of largest magnitude with their sign, when [s], in which row, and the speed
    or torque then; the RMS is over the whole time, dwell included."""

    unit: str
    peak: float
    peak_time: float
    peak_row: int
    peak_speed: float
    rms: float
    max_speed: float
    max_speed_time: float
    max_speed_row: int
    torque_at_max_speed: float
    peak_power: float
    least_power: float
    work_positive: float
    work_negative: float


@dataclass(frozen=True)
class ComponentLoad:
    """A component of a wrench [N or N m]: its value of largest magnitude, when [s], and RMS."""

    name: str
    peak: float
    peak_time: float
    rms: float


@dataclass(frozen=True)
class Range:
    """The least and the greatest of a quantity along the motion, and when [s]."""

    name: str
    least: float
    least_time: float
    greatest: float
    greatest_time: float


@dataclass(frozen=True)
class EnergyBalance:
    """Work of actuators (and of what moves the base) less losses, against the change of stored energy [J].

    Attributes:
        quadrature: estimated error of integrating power over the given samples; quadrature_most: the largest along the
            motion; scatter: root of the sum of the squares of its parts, which corners may leave of either sign.
        turnover: integral of the magnitude of the power; stored_most: largest magnitude of the stored energy.
        worst: work less energy change where they differ most along the motion.
    """

    work: float
    energy_change: float
    quadrature: float
    turnover: float
    worst: float
    quadrature_most: float
    scatter: float
    stored_most: float

    @property
    def residual(self) -> float:
        return self.work - self.energy_change

    @property
    def consistent(self) -> bool:
        """Return whether sampling or rounding explains the worst residual, or it is below a thousandth of the turnover.
        A residual above a twentieth of the turnover is never explained: samples that coarse show nothing."""
        explained = min(1.5 * self.explained, 0.05 * self.turnover)
        return abs(self.worst) <= max(explained, 1e-3 * self.turnover, 1e-12 * self.stored_most)

    @property
    def explained(self) -> float:
        """What sampling explains of the residual: exact motions of many kinds stay below 1.4 times this."""
        return self.quadrature_most + self.scatter


@dataclass(frozen=True)
class Checks:
    """Self-checks. The laws compare the base wrench of the force recursion with the rate of momentum, relative.

    Attributes:
        first_law: |f - (dP/dt - sum of applied forces)| of the largest force; second_law: likewise of moments about the
            base's origin; power: |tau . qd - losses - dE/dt| of the largest power, at the same samples.
        largest_force, largest_moment: that balance there [N, N m]; the moment is at least that of the force at the
            robot's reach.
    """

    energy_balance: EnergyBalance
    first_law: float
    second_law: float
    power: float
    samples: int
    largest_force: float
    largest_moment: float


@dataclass(frozen=True)
class JointLoad(ShaftLoad):
    """What one joint carries along the motion.

    Attributes:
        mean: over the whole time; cubic_mean: cbrt(integral |qd tau^3| dt / integral |qd| dt), what wears a gear.
        hold: Coulomb friction that holds the joint at rest: any torque of gravity +- hold does; what grows with
            load is that at the peak.
        effort_limit, velocity_limit: None where the description has none or says 0; a margin is limit - |value|,
            negative if exceeded, for `seconds_over_effort` and `seconds_over_velocity`.
        lower, upper, q_min, q_max: position limits and the range of the motion.
        uncertainty: standard deviation of the peak torque that comes of noise of accelerations; 0 if none was found.
        error_bar: by how much the largest torque of the motion may differ from the peak, in 19 of 20 cases, for noise
            of accelerations and what they leave in doubt; None where accelerations are given and nothing tells.
        shares: by effect, what it adds to the peak [N m]; they sum to `peak`.
    """

    name: str
    mean: float
    cubic_mean: float
    hold: float
    effort_limit: float | None
    velocity_limit: float | None
    seconds_over_effort: float
    seconds_over_velocity: float
    lower: float | None
    upper: float | None
    q_min: float
    q_max: float
    uncertainty: float
    error_bar: float | None
    shares: dict[str, float]
    JSON_ALSO: ClassVar = ("effort_margin", "velocity_margin")

    @property
    def effort_margin(self) -> float | None:
        return None if self.effort_limit is None else self.effort_limit - abs(self.peak)

    @property
    def velocity_margin(self) -> float | None:
        return None if self.velocity_limit is None else self.velocity_limit - abs(self.max_speed)

    @property
    def exceeded(self) -> tuple[Excess, ...]:
        effort = (self.peak, self.effort_limit, self.peak_time, self.seconds_over_effort)
        velocity = (self.max_speed, self.velocity_limit, self.max_speed_time, self.seconds_over_velocity)
        place, out = "rad" if self.unit == "N m" else "m", reached_beyond(self.name, self.unit, effort, velocity)
        if self.lower is not None and self.lower - self.q_min > (BEYOND - 1.0) * abs(self.lower):
            out.append(Excess(self.name, "position", self.q_min, self.lower, place))
        if self.upper is not None and self.q_max - self.upper > (BEYOND - 1.0) * abs(self.upper):
            out.append(Excess(self.name, "position", self.q_max, self.upper, place))
        return tuple(out)


@dataclass(frozen=True)
class EffectReport:
    """An effect, whether it is on and why, and its operations per sample, in the recursion with it alone; saved: by its
    absence, None if not asked for."""

    name: str
    verdict: Verdict
    operations: int
    saved: int | None


@dataclass(frozen=True)
class MomentumReport:
    """Mass centre (com, m), momenta (p, kg m/s; L, kg m^2/s), energies (T, V, J) and power (tau . qd, W); in the axes
    of a frame, "ground" or a link, L about its "origin", "com", or a point in it."""

    about: str | tuple[float, float, float]
    frame: str
    ranges: tuple[Range, ...]


@dataclass(frozen=True)
class Promise:
    """Whether an accuracy that was asked for is met, and how or why not; errors are relative to the largest torque."""

    target: float
    expected: float
    met: bool
    said: str


@dataclass(frozen=True)
class Exceeded:
    """One limit of a joint that the motion exceeds; all values are magnitudes.

    Attributes:
        quantity: RMS motor torque and mean gear torque wear out and heat, temperatures [degC] age the insulation, the
            others break or stall.
        value, limit: at the moment when value / limit is largest; time, row: of that [s; from 1]; seconds: in all. None
            for quantities of the whole motion.
        speed: of the motor then, or its mean over the motion where the limit depends on it; else None.
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
        if self.unit == DEGREES:
            return "over temperature"
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
        gear_loss: what the gear takes [J]; gear_mean: cubic mean of the torque at its output over its way; gear_life:
            [h], None without its data, or if nothing wears it. heat: None without thermal data.
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
    gear_loss: float
    gear_mean: float
    gear_life: float | None
    heat: MotorHeat | None = None
    JSON_ALSO: ClassVar = ("continuous_margin", "peak_margin")

    @property
    def continuous_margin(self) -> float | None:
        return None if self.continuous_limit is None else self.continuous_limit - self.rms

    @property
    def peak_margin(self) -> float | None:
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
    fxy and mxy are resultants in the plane, whatever their direction. The loads do not peak together."""

    mean: float
    unit: str


@dataclass(frozen=True)
class Sizing:
    """What motors, gears, bearings and the foundation have to bear along a motion; bus: None without thermal data."""

    joints: tuple[JointSizing, ...]
    bearings: tuple[BearingLoad, ...]
    foundation: tuple[FoundationLoad, ...]
    bus: Electric | None = None

    @property
    def exceeded(self) -> bool:
        return any(joint.exceeded for joint in self.joints)


@dataclass(frozen=True, eq=False)
class History:
    """The course of a motion. motion: time, q, qd, qdd, loads, columns of the tree's scene, and whether each contact is
    on; curves are tau, speeds, powers and the base wrench. energy: "work done" and "energy stored" since the start [J].
    states: for each joint q, qd, qdd and columns at its peak torque. heat: of motors with thermal data."""

    motion: Courses
    energy: Courses
    states: tuple[Mapping[str, Floats], ...]
    heat: Heat | None = None


@dataclass(frozen=True, repr=False)
class Result(Shown):
    """What a robot carries along a motion.

    Attributes:
        warnings: all of them, those of `caveats` too.
        limits: which limits the motion could be held against; caveats: what else keeps "No limit is exceeded" from
            being the whole truth.
        origin: the stamp in the table [s] that all times here count from; 0 where these are the stamps.
        held: position [rad or m] of every joint (or coordinate of a floating joint) that was held for want of a column.
        constraints: of loops and contacts; uncertainty: of the figures, where the scene says it of parameters.
    """

    robot: str
    samples: int
    duration: float
    gravity: tuple[float, float, float]
    joints: tuple[JointLoad, ...]
    base_wrench: tuple[ComponentLoad, ...]
    effects: tuple[EffectReport, ...]
    checks: Checks
    operations: int
    executor: str
    reason: str
    derivation: Derivation | None
    warnings: tuple[str, ...]
    momentum: MomentumReport | None = None
    history: History | None = None
    sizing: Sizing | None = None
    accuracy: Promise | None = None
    limits: tuple[Coverage, ...] = ()
    caveats: tuple[Caveat, ...] = ()
    origin: float = 0.0
    held: Mapping[str, float] = field(default_factory=dict)
    constraints: Constraints | None = None
    uncertainty: Uncertain | None = None

    def to_frame(self) -> DataFrame:
        """Return a polars.DataFrame of a row for each joint: its name, every number of `JointLoad`, and the margins to
        limits, null where there is no limit; `.to_pandas()` makes one of pandas of it."""
        import polars as pl

        kinds = {each.name: str(each.type) for each in fields(JointLoad) if each.name not in ("name", "shares")}
        names = ("name", *kinds, *JointLoad.JSON_ALSO)
        schema = {name: {"str": pl.String, "int": pl.Int64}.get(kinds.get(name, ""), pl.Float64) for name in names}
        rows = [[getattr(joint, name) for name in names] for joint in self.joints]
        return pl.DataFrame(rows, schema=schema | {"name": pl.String}, orient="row")

    def _lines(self) -> Sequence[str]:
        size = f"{count(len(self.joints), 'joint')}, {count(self.samples, 'sample')}, {figure(self.duration, 6)} s"
        peaks = [f"{shown(joint.name)} {figure(joint.peak, 4)} {joint.unit}" for joint in self.joints]
        more = f", ... ({len(peaks)} in all)" if len(peaks) > _SHOWN else ""
        said = {True: "within all limits", False: "beyond limits", None: "limits are not known, or in doubt"}
        return (
            f"Result of {shown(self.robot)}: {size}",
            f"peaks: {', '.join(peaks[:_SHOWN]) or 'none'}{more}",
            f"{said[self.within_limits]}; {count(len(self.warnings), 'warning')}",
        )

    def _table(self) -> tuple[Sequence[str], Sequence[Sequence[Cell]]]:
        head = ("joint", "in", "peak", "at [s]", "RMS", "limit", "largest speed", "limit of speed")
        names = ("name", "unit", "peak", "peak_time", "rms", "effort_limit", "max_speed", "velocity_limit")
        return head, [[getattr(joint, name) for name in names] for joint in self.joints]

    @property
    def exceeded(self) -> tuple[Excess, ...]:
        return tuple(excess for joint in self.joints for excess in joint.exceeded)

    @property
    def samples_suffice(self) -> bool:
        return not any(caveat.kind == TOO_FEW for caveat in self.caveats)

    @property
    def within_limits(self) -> bool | None:
        """Return False if the motion exceeds a limit of the description, or with sizing one of motors and gears. True
        if all joints have limits and none is exceeded; None if joints have no limits or something is in doubt."""
        return within(bool(self.exceeded or (self.sizing and self.sizing.exceeded)), self.limits, self.caveats)
