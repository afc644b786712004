"""Limits of joints: which of them a motion can be held against, and what is beyond them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from robodyn.errors import Caveat
from robodyn.support.floats import BEYOND, Floats

if TYPE_CHECKING:
    from robodyn.robot.model import Joint, Model

Quantity = Literal["effort", "velocity", "position"]

MOST_EFFORT, MOST_VELOCITY = 1e5, 1e4
"""Limits of effort [N m, N] and velocity [rad/s, m/s] from which on a number stands for "none"."""
Reached = tuple[float, float | None, float, float]
"""What a joint reaches along a motion, its limit, when it is worst and how long it is exceeded [s]."""


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


def binding(limit: float | None, most: float = np.inf) -> float | None:
    """Return a limit of effort or velocity, None where there is none: by the practice of URDF 0 means none, and so does
    what is not below `most`."""
    return limit if limit is not None and 0.0 < limit < most else None


def coverage(joints: Sequence[Joint]) -> tuple[Coverage, ...]:
    """Return which joints have limits of effort, velocity and position: those from MOST_EFFORT and MOST_VELOCITY on
    limit nothing, and a continuous joint needs none of position."""
    moving = [joint for joint in joints if joint.kind in ("revolute", "prismatic")]
    ranged = {each.name: None if None in (each.lower, each.upper) else 1.0 for each in moving if not each.continuous}
    rows: tuple[tuple[Quantity, Mapping[str, float | None], float], ...] = (
        ("effort", {joint.name: joint.effort for joint in moving}, MOST_EFFORT),
        ("velocity", {joint.name: joint.velocity for joint in moving}, MOST_VELOCITY),
        ("position", ranged, np.inf),
    )
    found = []
    for quantity, limits, most in rows:
        checked = {name: limit for name, limit in limits.items() if limit is not None and 0.0 < limit < most}
        unchecked = tuple(Unchecked(*each) for each in limits.items() if each[0] not in checked)
        found.append(Coverage(quantity, tuple(checked), unchecked))
    return tuple(found)


def reached_beyond(joint: str, unit: str, effort: Reached, velocity: Reached) -> list[Excess]:
    """Return the limits of effort (in this unit) and velocity that a joint exceeds."""
    speed = "rad/s" if unit == "N m" else "m/s"
    rows: tuple[tuple[Quantity, str, Reached], ...] = ("effort", unit, effort), ("velocity", speed, velocity)
    return [
        Excess(joint, quantity, abs(value), limit, its, time, seconds)
        for quantity, its, (value, limit, time, seconds) in rows
        if limit is not None and abs(value) > BEYOND * limit
    ]


def held_beyond(model: Model, q: Floats, tau: Floats) -> tuple[Excess, ...]:
    """Return the limits that a robot at rest exceeds: positions q (nq,), those of joints that mimic others too, and
    effort by tau (n,), which holds it there [N m or N]."""
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
    """Return between which values (nq,) of each coordinate all joints that it moves are within their limits [rad or m]:
    -inf and inf where there is none; least > largest where limits exclude each other, or are the wrong way round."""
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
