"""Limits of joints that were written in other units: deg/s, N mm, mm and mm/s."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import isclose, log10, pi
from typing import NamedTuple

from robodyn.checks.context import Context
from robodyn.checks.meshes.units import reach
from robodyn.robot.urdf.numbers import Numbers
from robodyn.robot.urdf.view import JointView, LimitView

_DEGREES = 180 / pi
_TURNING = ("revolute", "continuous")
_FASTEST = 20.0
"""Speeds [rad/s, m/s] up to which nothing is in doubt; a wheel or a propeller may turn `_FREELY` fast."""
_FREELY = 60.0
_SPEED_GAP, _SPEED_BAND = 8.0, 2.0
"""How many times all the others' a limit is at least, and how near to theirs it is when it is divided."""
_EFFORT_GAP, _EFFORT_BAND = 100.0, 3.0
_ROUND, _SLOWEST = 5.0, 45.0
"""Speeds in degrees are multiples of 5, and of a whole robot not below 45."""
_LONG, _REACHES = 5.0, 20.0
"""A slide of more metres, which is as many times as long as the robot's longest offset, is in millimetres."""


class LimitSlip(NamedTuple):
    """A number of <limit> that is too large by a factor between units: the unit in which it seems to be, the one that
    URDF takes it in, and what speaks for it."""

    numbers: Numbers
    factor: float
    wrote: str
    meant: str
    why: str


def limit_slips(context: Context) -> tuple[LimitSlip, ...]:
    """Return the limits that one factor between units brings among those of the robot's other joints."""
    return (*_speeds(context), *_efforts(context), *_slides(context))


def of_numbers(context: Context) -> frozenset[int]:
    """Return the identities of the numbers that a slip explains, for the rules that are silent about them."""
    return frozenset(id(slip.numbers) for slip in context.once(limit_slips))


_Given = list[tuple[JointView, LimitView, float]]


def _speeds(context: Context) -> Iterator[LimitSlip]:
    most = context.thresholds.most_velocity
    found = [each for each in _given(context, "velocity") if each[0].type in _TURNING and each[2] < most]
    large = [each for each in found if each[2] > (_FASTEST if each[0].type == "revolute" else _FREELY)]
    why = _apart(large, found, _DEGREES, _SPEED_GAP, _SPEED_BAND)
    speeds = [each[2] for each in found]  # several values, for one alone may be a stand-in
    several = len(speeds) > 2 and len(set(speeds)) > 1 and any(each[0].type == "revolute" for each in found)
    if not why and several and all(speed >= _SLOWEST and speed % _ROUND == 0 for speed in speeds):
        large, why = found, f"those of all joints are multiples of {_ROUND:g}, which are speeds of no drive in rad/s"
    for _, limit, _ in large if why else ():
        yield LimitSlip(limit.velocity, _DEGREES, "deg/s", "rad/s", why)


def _efforts(context: Context) -> Iterator[LimitSlip]:
    limits = context.thresholds
    found = [
        each
        for each in _given(context, "effort")
        if each[0].type in _TURNING and each[2] < 1e3 * limits.most_effort
        if each[1].velocity.value is None or each[1].velocity.value < limits.most_velocity
    ]
    values = sorted(value for _, _, value in found)
    jump = next((above for below, above in pairwise(values) if above >= _EFFORT_GAP * below), None)
    large = [each for each in found if jump is not None and each[2] >= jump and not _stand_in(each[2])]
    why = _apart(large, found, 1e3, _EFFORT_GAP, _EFFORT_BAND)
    for _, limit, _ in large if why else ():
        yield LimitSlip(limit.effort, 1e3, "N mm", "N m", why)


def _slides(context: Context) -> Iterator[LimitSlip]:
    bound = max(_LONG, _REACHES * reach(context))
    why = f"the robot's longest offset between joints is {reach(context):.3g} m"
    for joint in context.view.joints:
        if joint.type != "prismatic" or joint.limit is None:
            continue
        for numbers in (joint.limit.lower, joint.limit.upper):
            if numbers.value is not None and bound < abs(numbers.value) <= context.thresholds.most_range:
                yield LimitSlip(numbers, 1e3, "mm", "m", why)
        speed = joint.limit.velocity
        if speed.value is not None and max(bound, _FASTEST) < speed.value < context.thresholds.most_velocity:
            yield LimitSlip(speed, 1e3, "mm/s", "m/s", why)


def _given(context: Context, attribute: str) -> _Given:
    """Return the joints that move, with their positive limits of this attribute."""
    found = []
    for joint in context.view.joints:
        limit = joint.limit if joint.moves else None
        value = None if limit is None else getattr(limit, attribute).value
        if limit is not None and value is not None and value > 0:
            found.append((joint, limit, value))
    return found


def _apart(large: _Given, found: _Given, factor: float, gap: float, band: float) -> str:
    """Return why the large limits are in another unit; empty if they are not.

    They are no more than the others, all above `gap` times these, and among them when they are divided by the factor.
    """
    marked = {id(each[0]) for each in large}
    others = [value for joint, _, value in found if id(joint) not in marked]
    values = [value for *_, value in large]
    if not large or len(large) > len(others) or len(others) < 2 or min(values) < gap * max(others):
        return ""
    least, most = min(others) / band, max(others) * band
    within = all(least <= value / factor <= most for value in values)
    between = " to ".join(f"{value:g}" for value in sorted({min(others), max(others)}))
    return f"those of the other joints are {between}" if within else ""


def _stand_in(value: float) -> bool:
    """Return whether a value is a power of ten, or all nines."""
    return any(isclose(power, round(power), abs_tol=1e-12) for power in (log10(value), log10(value + 1.0)))
