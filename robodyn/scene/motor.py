"""What a data sheet says of a motor."""

from __future__ import annotations

from dataclasses import dataclass

from robodyn.support.frozen import FrozenValue

Curve = tuple[tuple[float, float], ...]
"""(speed, torque) points with increasing speeds, straight lines between them; nothing beyond the last speed."""


@dataclass(frozen=True)
class Motor(FrozenValue):
    """What drives a joint. Rotor inertia and gear ratio stand in the scene's `Rotor` of the joint.

    Speeds and torques are magnitudes at the motor's shaft [rad/s, N m] (of a linear motor m/s, N); the same curves hold
    for braking.

    Attributes:
        efficiency: of the gear, 0 < efficiency <= 1.
        continuous, peak: the torque that it may give for ever and for moments: one for all speeds, or a curve.
        max_speed: None: where the curve `peak` ends.
        gear_average, gear_peak: what the gear bears at the joint as cubic mean and at the most [N m or N].
    """

    efficiency: float = 1.0
    continuous: float | Curve | None = None
    peak: float | Curve | None = None
    max_speed: float | None = None
    gear_average: float | None = None
    gear_peak: float | None = None
