"""Limits of joints: which of them a motion can be held against, and what is beyond them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np

from robodyn.support.caveats import Caveat
from robodyn.support.floats import BEYOND, Floats

if TYPE_CHECKING:
    from robodyn.robot.model import Joint, Model

Quantity = Literal["effort", "velocity", "position"]

MOST_EFFORT, MOST_VELOCITY = 1e5, 1e4
"""Limits of effort [N m, N] and velocity [rad/s, m/s] from which on a number stands for "none"."""


@dataclass(frozen=True)
class Excess:
    """A limit of the description that the motion exceeds; effort and velocity are magnitudes.

    Attributes:
        time: when it is worst, and seconds: how long it is exceeded in all [s]; None where that is not known.
    """

    joint: str
    quantity: Quantity
    value: float
    limit: float
    unit: str
    time: float | None = None
    seconds: float | None = None


@dataclass(frozen=True)
class Unchecked:
    """A joint without a limit, and what the description gives instead: 0 or a huge number, which mean none; or None."""

    joint: str
    given: float | None


@dataclass(frozen=True)
class Coverage:
    """Of one quantity the joints that have a limit, and those that have none."""

    quantity: Quantity
    checked: tuple[str, ...]
    unchecked: tuple[Unchecked, ...]


class Reached(Protocol):
    """What a joint reaches along a motion, and its limits: the fields of `JointLoad` of these names."""

    @property
    def name(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def peak(self) -> float: ...
    @property
    def peak_time(self) -> float: ...
    @property
    def effort_limit(self) -> float | None: ...
    @property
    def seconds_over_effort(self) -> float: ...
    @property
    def max_speed(self) -> float: ...
    @property
    def max_speed_time(self) -> float: ...
    @property
    def velocity_limit(self) -> float | None: ...
    @property
    def seconds_over_velocity(self) -> float: ...


def binding(limit: float | None) -> float | None:
    """Return a limit of effort or velocity, None where there is none: by the practice of URDF 0 means none."""
    return limit if limit is not None and limit > 0.0 else None


def coverage(joints: Sequence[Joint]) -> tuple[Coverage, ...]:
    """Return which joints have limits of effort, velocity and position.

    Limits from MOST_EFFORT and MOST_VELOCITY on limit nothing. A continuous joint needs no limit of position.
    """
    moving = [joint for joint in joints if joint.kind in ("revolute", "prismatic")]
    ranged = {each.name: None if None in (each.lower, each.upper) else 1.0 for each in moving if not each.continuous}
    return (
        _split("effort", {joint.name: joint.effort for joint in moving}, MOST_EFFORT),
        _split("velocity", {joint.name: joint.velocity for joint in moving}, MOST_VELOCITY),
        _split("position", ranged, np.inf),
    )


def reached_beyond(joint: Reached) -> list[Excess]:
    """Return the limits of effort and velocity that a joint exceeds."""
    speed, out = "rad/s" if joint.unit == "N m" else "m/s", []
    if joint.effort_limit is not None and abs(joint.peak) > BEYOND * joint.effort_limit:
        when = (joint.peak_time, joint.seconds_over_effort)
        out.append(Excess(joint.name, "effort", abs(joint.peak), joint.effort_limit, joint.unit, *when))
    if joint.velocity_limit is not None and abs(joint.max_speed) > BEYOND * joint.velocity_limit:
        when = (joint.max_speed_time, joint.seconds_over_velocity)
        out.append(Excess(joint.name, "velocity", abs(joint.max_speed), joint.velocity_limit, speed, *when))
    return out


def held_beyond(model: Model, q: Floats, tau: Floats) -> tuple[Excess, ...]:
    """Return the limits that a robot at rest exceeds: positions, those of joints that mimic others too, and effort.

    Args:
        q: (nq,); tau: (n,) what holds it there, by rate [N m or N].
    """
    found = []
    for body in model.bodies:
        joint = body.joint
        if joint.kind not in ("revolute", "prismatic"):
            continue
        place, force = ("m", "N") if joint.kind == "prismatic" else ("rad", "N m")
        value = joint.multiplier * float(q[joint.coordinate]) + joint.offset
        for limit, beyond in ((joint.lower, -1.0), (joint.upper, 1.0)):
            if limit is not None and beyond * (value - limit) > (BEYOND - 1.0) * max(1.0, abs(limit)):
                found.append(Excess(joint.name, "position", value, limit, place))
        effort = binding(joint.effort)
        if joint.mimics is None and effort is not None and abs(tau[joint.rate]) > BEYOND * effort:
            found.append(Excess(joint.name, "effort", abs(float(tau[joint.rate])), effort, force))
    return tuple(found)


def coordinate_ranges(model: Model) -> tuple[Floats, Floats]:
    """Return between which values of each coordinate all joints that it moves are within their limits.

    Returns:
        (nq,) least and largest [rad or m], -inf and inf where there is no limit; least > largest where limits of a
        joint and of one that mimics it exclude each other, or are the wrong way round.
    """
    least, largest = np.full(model.nq, -np.inf), np.full(model.nq, np.inf)
    for body in model.bodies:
        joint, k = body.joint, body.joint.coordinate
        if joint.kind in ("revolute", "prismatic") and joint.multiplier:
            ends = [
                np.inf * sign if limit is None else (limit - joint.offset) / joint.multiplier
                for limit, sign in ((joint.lower, -joint.multiplier), (joint.upper, joint.multiplier))
            ]
            lower, upper = ends if joint.multiplier > 0.0 else ends[::-1]
            least[k], largest[k] = max(least[k], lower), min(largest[k], upper)
    return least, largest


def within(exceeded: bool, limits: Sequence[Coverage], caveats: Sequence[Caveat]) -> bool | None:
    """Return False if a limit is exceeded; None if some could not be checked or something is in doubt; else True."""
    if exceeded:
        return False
    return None if caveats or any(each.unchecked for each in limits) else True


def _split(quantity: Quantity, limits: Mapping[str, float | None], most: float) -> Coverage:
    checked = {name: limit for name, limit in limits.items() if limit is not None and 0.0 < limit < most}
    unchecked = tuple(Unchecked(*each) for each in limits.items() if each[0] not in checked)
    return Coverage(quantity, tuple(checked), unchecked)
