"""The modes of a linear system: how it moves by itself, and whether it comes back."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, inf, pi


@dataclass(frozen=True)
class Mode:
    """x(t) = Re(shape exp((real + i imag) t)).

    Attributes:
        real, imag: of the eigenvalue [1/s, rad/s]; imag >= 0, its conjugate is the same motion.
        error: how far the eigenvalue may be off by rounding [1/s].
        shape: (n,) complex, how the rates' coordinates move, the one with most kinetic energy 1.
        shares: (n,) of the kinetic energy that each coordinate alone would have, the largest 1.
        alike: whether another mode has the same eigenvalue, so that any mixture of their shapes is one.
    """

    real: float
    imag: float
    error: float
    shape: tuple[complex, ...]
    shares: tuple[float, ...]
    alike: bool = False

    @property
    def free(self) -> bool:
        """Whether nothing holds it: moved or set going it stays so."""
        return self.real == 0.0 and self.imag == 0.0

    @property
    def oscillates(self) -> bool:
        return self.imag > self.error

    @property
    def frequency(self) -> float:
        """Of the undamped motion, |eigenvalue| / (2 pi) [Hz]; 0 where it does not oscillate."""
        return hypot(self.real, self.imag) / (2.0 * pi) if self.oscillates else 0.0

    @property
    def damping_ratio(self) -> float:
        """-real / |eigenvalue|: 0 undamped, 1 without oscillation, negative where it grows."""
        return 0.0 if self.undecided else -self.real / hypot(self.real, self.imag)

    @property
    def time_constant(self) -> float:
        """In which it shrinks, or grows, to 1/e or e times its size [s]; infinite where it does neither."""
        return inf if self.undecided else 1.0 / abs(self.real)

    @property
    def undecided(self) -> bool:
        """Whether it neither grows nor decays within rounding."""
        return abs(self.real) <= self.error


@dataclass(frozen=True)
class Modes:
    """All modes, the slowest first.

    Attributes:
        modes: one of each pair.
        at_rest: whether the state is one: of one that moves, eigenvalues say nothing about stability.
    """

    modes: tuple[Mode, ...]
    at_rest: bool = True

    @property
    def verdict(self) -> str:
        """Return "stable" if all modes decay, "unstable" if one grows, "marginal" if none grows and some do neither or
        rounding hides what they do, and "moving" where nothing is said."""
        if not self.at_rest:
            return "moving"
        if any(mode.real > mode.error for mode in self.modes):
            return "unstable"
        return "marginal" if any(mode.undecided for mode in self.modes) else "stable"

    @property
    def stable(self) -> bool | None:
        """Return whether every small disturbance dies away; None where that is not decided."""
        return {"stable": True, "unstable": False}.get(self.verdict)

    @property
    def margin(self) -> float | None:
        """-real of the mode that decays slowest, negative if one grows [1/s]; None where nothing is held."""
        return min((0.0 - mode.real for mode in self.modes if not mode.free), default=None)
