"""Whether there are samples enough: what derived accelerations leave open of torques, and what the energy shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from robodyn.loads.result import EnergyBalance, JointLoad
from robodyn.programs.vectors import length
from robodyn.support.doubts import TOO_FEW, Doubt
from robodyn.support.wording import count, figure, shown
from robodyn.trajectory.motion import FEW, Trajectory

Floats = NDArray[np.float64]

OPEN = 0.5
"""Of the rms of derived accelerations: what is open above it is not an error of some rows but of the motion."""
COUNTS = 0.1
"""Of a joint's peak: what is open of accelerations and makes less of a torque does not count."""
COARSE = 1e-2
"""Of the energy that goes in and out: where sampling explains more, it may explain all."""
NEGLIGIBLE = 1e-3
"""Of the largest torque: a joint whose peak is smaller is judged as if it had this one."""
TINY = 1e-300
RATE = 100.0
"""Hz that is asked for, and more where there are more samples than that already."""


class Openness:
    """What is open of derived accelerations, gathered block by block."""

    def __init__(self, rates: int) -> None:
        self.off_squares, self.squares = np.zeros(rates), np.zeros(rates)
        self.guessed = False

    def update(self, block: Trajectory) -> tuple[Floats, Floats]:
        """Return (N, n) the noise of accelerations of a block, and by how much they may be off."""
        found = block.sampling
        if found is None:
            return np.zeros_like(block.qdd), np.zeros_like(block.qdd)
        self.guessed = found.guessed
        self.off_squares, self.squares = self.off_squares + found.off_squares, self.squares + found.squares
        return found.noise, found.off

    def bar(self, inertia: Floats, off: Floats, shares: Mapping[str, float]) -> float:
        """Return what is open of a torque: sqrt(sum (M_kj off_j)^2), of guesses the sum, which nothing exceeds.

        Way-points may be places of rest, so that all that their derived speeds make of the torque is open too.

        Args:
            inertia: (n,) the torque's row of the mass matrix; off: (n,) of its sample.
            shares: of the torque, by effect.
        """
        if not self.guessed:
            return length(inertia * off)
        of_speed = sum(abs(shares.get(name, 0.0)) for name in ("coriolis", "viscous friction"))
        return float((np.abs(inertia) * off).sum()) + of_speed

    def doubts(
        self,
        joints: Sequence[JointLoad],
        bars: Sequence[float],
        balance: EnergyBalance,
        samples: int,
        duration: float,
    ) -> tuple[Doubt, ...]:
        """Return what is in doubt for want of samples, or because the energy does not balance.

        Args:
            bars: what is open of the joints' peaks.
        """
        at_large = bool((self.off_squares > OPEN**2 * self.squares).any())
        too_few = sampling_doubt(joints, bars, samples, duration) if at_large else None
        energy = energy_doubt(balance, samples, duration)
        if too_few is not None:
            return (too_few,) if energy is None or _coarse(balance, samples) else (too_few, energy)
        found = (energy, bar_doubt(joints))
        return tuple(doubt for doubt in found if doubt is not None)


def sampling_doubt(joints: Sequence[JointLoad], bars: Sequence[float], samples: int, duration: float) -> Doubt | None:
    """Return the doubt about torques whose accelerations are open at large, None where that does not count.

    Args:
        bars: what is open of the joints' peaks.
    """
    if not joints:
        return None
    least = NEGLIGIBLE * max(abs(joint.peak) for joint in joints)
    open_most = max(zip(bars, joints, strict=True), key=lambda pair: pair[0] / max(abs(pair[1].peak), least, TINY))
    bar, joint = open_most
    if bar <= COUNTS * max(abs(joint.peak), least):
        return None
    said = (
        f"{_how_many(samples, duration)} too few to derive accelerations: the peak of {shown(joint.name)}, "
        f"{figure(joint.peak)} {joint.unit}, may be off by {figure(bar, 2)} {joint.unit}; "
        f"{_remedy(samples, duration)}, or give velocities and accelerations"
    )
    return Doubt(TOO_FEW, said)


def energy_doubt(balance: EnergyBalance, samples: int, duration: float) -> Doubt | None:
    """Return the doubt about a motion whose energy does not balance, None if it does."""
    if balance.consistent:
        return None
    off = f"energy balance is off by {balance.worst:.3g} J of {balance.turnover:.3g} J"
    if not _coarse(balance, samples):
        said = f"{off}: velocities or accelerations are not the rates of the positions"
        return Doubt("by torques that are not trusted (energy does not balance)", said)
    said = (
        f"{off}: {_how_many(samples, duration)} too few to tell whether velocities and accelerations are the rates of "
        f"the positions, or what happens between the samples; {_remedy(samples, duration)}"
    )
    return Doubt("at the samples given (too few for the energy check)", said)


def _coarse(balance: EnergyBalance, samples: int) -> bool:
    """Return whether the trapezoidal rule cannot tell a wrong rate from too few samples."""
    return balance.explained > COARSE * balance.turnover or samples < FEW


def bar_doubt(joints: Sequence[JointLoad]) -> Doubt | None:
    """Return the doubt about peaks that may be beyond their limits within their error bars."""
    near = [joint for joint in joints if (left := joint.effort_margin) is not None and 0.0 <= left < joint.error_bar]
    if not near:
        return None
    worst = min(near, key=lambda joint: (joint.effort_margin or 0.0) / joint.error_bar)
    others = f", and {len(near) - 1} more" if len(near) > 1 else ""
    said = (
        f"the peak of {shown(worst.name)}{others} may be beyond its limit: {figure(worst.peak)} +- "
        f"{figure(worst.error_bar, 2)} {worst.unit}, limit {worst.effort_limit:g} {worst.unit}"
    )
    return Doubt(f"unless within the error bar of {shown(worst.name)}{others}", said)


def _how_many(samples: int, duration: float) -> str:
    return f"{count(samples, 'sample')} over {figure(duration)} s are"


def _remedy(samples: int, duration: float) -> str:
    """Four times as many samples, and not fewer than RATE."""
    rate = 4.0 * (samples - 1) / duration if duration > 0.0 else 0.0
    return f"give samples at {figure(max(RATE, rate), 1)} Hz or more"
