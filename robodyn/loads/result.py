"""What `torques` answers: frozen data that reports turn into text and JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from robodyn.dynamics.effects.effect import Verdict
from robodyn.loads.figures import ComponentLoad, Range, ShaftLoad
from robodyn.robot.limits import Coverage, Excess, reached_beyond, within
from robodyn.support.caveats import TOO_FEW, Caveat
from robodyn.support.floats import BEYOND
from robodyn.trajectory.motion import Derivation

if TYPE_CHECKING:
    from robodyn.loads.constraint_result import Constraints
    from robodyn.loads.history import History
    from robodyn.loads.sizing_result import Sizing
    from robodyn.loads.uncertainty_result import Uncertain


@dataclass(frozen=True)
class EnergyBalance:
    """Work of actuators (and of what moves the base) less losses, against the change of stored energy [J].

    Attributes:
        quadrature: estimated error of integrating power over the given samples.
        turnover: integral of the magnitude of the power.
        worst: work less energy change where they differ most along the motion.
        quadrature_most: the largest estimated error of integration along the motion.
        scatter: root of the sum of the squares of its parts, which corners of the power may leave of either sign.
        stored_most: the largest magnitude of the stored energy.
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

        A residual above a twentieth of the turnover is never explained: samples that coarse show nothing.
        """
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
        first_law: |f - (dP/dt - sum of applied forces)| of the largest force; None if no sample was checked.
        second_law: the same for moments about the base's origin.
        power: |tau . qd - losses - dE/dt| of the largest power, at the same samples.
        samples: how many samples the laws were checked at.
        largest_force, largest_moment: the largest that balance in the laws there [N, N m]; the moment is at least that
            of the force at the robot's reach.
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
        place, out = "rad" if self.unit == "N m" else "m", reached_beyond(self)
        if self.lower is not None and self.lower - self.q_min > (BEYOND - 1.0) * abs(self.lower):
            out.append(Excess(self.name, "position", self.q_min, self.lower, place))
        if self.upper is not None and self.q_max - self.upper > (BEYOND - 1.0) * abs(self.upper):
            out.append(Excess(self.name, "position", self.q_max, self.upper, place))
        return tuple(out)


@dataclass(frozen=True)
class EffectReport:
    """An effect, whether it is on and why, and what it costs.

    Attributes:
        operations: per sample, of the recursion with this effect alone.
        saved: operations per sample that its absence would save; None where it was not asked for.
    """

    name: str
    verdict: Verdict
    operations: int
    saved: int | None


@dataclass(frozen=True)
class MomentumReport:
    """Mass centre (com, m), momenta (p, kg m/s; L, kg m^2/s), energies (T, V, J) and power (tau . qd, W).

    Attributes:
        about: "origin" of the frame, "com", or a point in the frame, which L is about.
        frame: whose axes and origin count: "ground" or a link.
    """

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
class Result:
    """What a robot carries along a motion.

    Attributes:
        warnings: all of them, those of `caveats` too.
        limits: which limits the motion could be held against.
        caveats: what else keeps "No limit is exceeded" from being the whole truth.
        origin: the stamp in the table [s] that all times here count from; 0 where these are the stamps.
        held: position [rad or m] of every joint (or coordinate of a floating joint) that was held for want of a column.
        constraints: what loops and contacts bear; None for a tree that stands on nothing.
        uncertainty: how sure the figures are where parameters are not; None where the scene does not say so.
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

    @property
    def exceeded(self) -> tuple[Excess, ...]:
        """Every limit of the description that the motion exceeds."""
        return tuple(excess for joint in self.joints for excess in joint.exceeded)

    @property
    def samples_suffice(self) -> bool:
        """Whether there are samples enough to derive accelerations."""
        return not any(caveat.kind == TOO_FEW for caveat in self.caveats)

    @property
    def within_limits(self) -> bool | None:
        """Return False if the motion exceeds a limit of the description, or with sizing one of motors and gears.

        True if all joints have limits and none is exceeded; None if joints have no limits or something is in doubt.
        """
        return within(bool(self.exceeded or (self.sizing and self.sizing.exceeded)), self.limits, self.caveats)
