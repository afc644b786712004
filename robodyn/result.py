"""What `torques` answers: frozen data that reports turn into text and JSON."""

from __future__ import annotations

from dataclasses import dataclass

from robodyn.effects.effect import Verdict


@dataclass(frozen=True)
class JointLoad:
    """What one joint carries along the motion; torque [N m], power [W], work [J], or N for a prismatic joint.

    Attributes:
        peak: the torque of largest magnitude, with its sign, at `peak_time` [s], in row `peak_row`, at `peak_speed`.
        rms: over the whole time, dwell included; `mean` likewise.
        cubic_mean: cbrt(integral |qd tau^3| dt / integral |qd| dt), what wears a gear.
        max_speed: of largest magnitude, with its sign, and the torque at that moment.
        peak_power, least_power: largest and smallest tau qd.
        work_positive, work_negative: done by and returned to the actuator.
        hold: Coulomb friction that holds the joint at rest: any torque of gravity +- hold does.
        effort_limit, velocity_limit: None where the description has none; a margin is limit - |value|, negative if
            exceeded, for `seconds_over_effort` and `seconds_over_velocity`.
        lower, upper, q_min, q_max: position limits and the range of the motion.
        uncertainty: standard deviation of the peak torque implied by differentiating noisy positions; 0 if none was.
        shares: by effect, what it adds to the peak [N m]; they sum to `peak`.
    """

    name: str
    unit: str
    peak: float
    peak_time: float
    peak_row: int
    peak_speed: float
    rms: float
    mean: float
    cubic_mean: float
    max_speed: float
    torque_at_max_speed: float
    peak_power: float
    least_power: float
    work_positive: float
    work_negative: float
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
    shares: dict[str, float]

    @property
    def effort_margin(self) -> float | None:
        return None if self.effort_limit is None else self.effort_limit - abs(self.peak)

    @property
    def velocity_margin(self) -> float | None:
        return None if self.velocity_limit is None else self.velocity_limit - abs(self.max_speed)

    @property
    def exceeded(self) -> tuple[str, ...]:
        """The limits that the motion exceeds, in plain words."""
        out = []
        speed_unit = "rad/s" if self.unit == "N m" else "m/s"
        if self.effort_margin is not None and self.effort_margin < 0:
            out.append(
                f"{self.name}: {abs(self.peak):.4g} {self.unit} exceeds the effort limit {self.effort_limit:.4g}"
            )
        if self.velocity_margin is not None and self.velocity_margin < 0:
            speed = abs(self.max_speed)
            out.append(f"{self.name}: {speed:.4g} {speed_unit} exceeds the velocity limit {self.velocity_limit:.4g}")
        length = speed_unit.partition("/")[0]
        for bound, value, over in (
            (self.lower, self.q_min, self.lower is not None and self.q_min < self.lower),
            (self.upper, self.q_max, self.upper is not None and self.q_max > self.upper),
        ):
            if over:
                out.append(f"{self.name}: position {value:.6g} {length} is beyond the limit {bound:.6g}")
        return tuple(out)


@dataclass(frozen=True)
class ComponentLoad:
    """One component of the base wrench [N or N m]."""

    name: str
    peak: float
    peak_time: float
    rms: float


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
class EnergyBalance:
    """Work of actuators (and of what moves the base) less losses, against the change of stored energy [J].

    Attributes:
        quadrature: estimated error of integrating power over the given samples.
        turnover: integral of the magnitude of the power.
    """

    work: float
    energy_change: float
    quadrature: float
    turnover: float

    @property
    def residual(self) -> float:
        return self.work - self.energy_change

    @property
    def consistent(self) -> bool:
        """Whether the residual is explained by the sampling, or below a thousandth of the energy that went about."""
        return abs(self.residual) <= max(10 * abs(self.quadrature), 1e-3 * self.turnover)


@dataclass(frozen=True)
class Checks:
    """Self-checks. The laws compare the base wrench of the force recursion with the rate of momentum, relative.

    Attributes:
        first_law: |f - (dP/dt - sum of applied forces)| of the largest force; None if no sample was checked.
        second_law: the same for moments about the base's origin.
        power: |tau . qd - losses - dE/dt| of the largest power, at the same samples.
        samples: how many samples the laws were checked at.
    """

    energy_balance: EnergyBalance
    first_law: float
    second_law: float
    power: float
    samples: int


@dataclass(frozen=True)
class Result:
    """What a robot carries along a motion."""

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
    derivation: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def exceeded(self) -> tuple[str, ...]:
        """Every limit that the motion exceeds."""
        return tuple(line for joint in self.joints for line in joint.exceeded)
