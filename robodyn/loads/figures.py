"""Figures that several results have: of shafts, of components of wrenches, of ranges."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ShaftLoad:
    """Torque [N m], speed [rad/s], power [W] and work [J] of a joint or a motor; N and m/s of a slide.

    Attributes:
        peak, max_speed: of largest magnitude with its sign, when [s], in which row, and the speed or torque then.
        rms: over the whole time, dwell included.
        work_positive, work_negative: done by the actuator and returned to it.
    """

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
