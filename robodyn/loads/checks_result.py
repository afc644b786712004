"""What self-checks of a motion found: frozen data."""

from __future__ import annotations

from dataclasses import dataclass


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
