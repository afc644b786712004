"""Joint limits as events: which is reached within a step, found on an interpolant, then by shorter steps."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from math import sqrt
from typing import NamedTuple

import numpy as np

from robodyn.errors import InputError
from robodyn.robot.model import Joint, Model
from robodyn.support.floats import Floats, first_largest

ASIDE = 0.25  # of a step, to both sides of an extremum of the interpolant: there is that of the method
DIP = 8.0 / 27.0
"""Cubics dip by at most half of this times the sum of their slopes: twice that deep they may be by the method."""
FINEST = 1e-8  # of a step: an extremum found to this has its value to a rounding


class Stop(NamedTuple):
    """A limit: `side * (value - joint's position)` is the room that is left."""

    joint: Joint
    side: float
    value: float

    @property
    def unit(self) -> str:
        return "m" if self.joint.kind == "prismatic" else "rad"

    @property
    def word(self) -> str:
        return "upper" if self.side > 0 else "lower"

    def met(self, verb: str) -> str:
        return f'"{self.joint.name}" {verb} its {self.word} limit of {self.value:g} {self.unit}'


class Limits:
    """The limits of a model's joints, followers of mimicked ones among them; none if they are not watched."""

    def __init__(self, model: Model, watched: bool) -> None:
        self.model = model
        self.stops = [
            Stop(body.joint, side, value)
            for body in model.bodies
            if watched and body.joint.kind in ("revolute", "prismatic")
            for side, value in ((-1.0, body.joint.lower), (1.0, body.joint.upper))
            if value is not None
        ]
        self._places = [stop.joint.coordinate for stop in self.stops]
        self._rates = [stop.joint.rate for stop in self.stops]
        self._gain = np.array([stop.side * stop.joint.multiplier for stop in self.stops])
        self._room = np.array([stop.side * (stop.value - stop.joint.offset) for stop in self.stops])

    def room(self, q: Floats) -> Floats:
        """(..., stops) rad or m left for q (..., nq); negative beyond a limit."""
        return self._room - self._gain * q[..., self._places]

    def rate(self, qd: Floats) -> Floats:
        """(..., stops) rad/s or m/s at which the room grows at speeds qd (..., n)."""
        return -self._gain * qd[..., self._rates]

    def check_start(self, q: Floats) -> None:
        for stop, room in zip(self.stops, self.room(q).tolist(), strict=True):
            if room < 0.0:
                joint = stop.joint
                at = joint.multiplier * q[joint.coordinate] + joint.offset
                raise InputError(
                    f'"{joint.name}" begins at {at:g}, beyond its limit of {stop.value:g}',
                    remedy='begin within the limits, or write joint_limits = "ignore" in the scene',
                )

    def reached(self, q: Floats, time: float) -> str:
        """That a joint reaches the limit that q (nq) is nearest to, or farthest beyond."""
        return f"{self.stops[first_largest(-self.room(q))].met('reaches')} at {time:.6g} s"


class Touch(NamedTuple):
    """A step in which a joint may pass a limit, by numbers, and where in it (0 to 1) the joint is farthest."""

    step: int
    stop: int
    at: float


def hermite_touches(limits: Limits, q: Floats, qd: Floats, length: Floats) -> list[Touch]:
    """Where N steps of lengths (N,) [s] may pass limits, up to the first that ends beyond one, in order of time: at
    their ends, or where cubics through q and qd before, between and after them (N + 1, ...) turn."""
    if not limits.stops:
        return []
    room, rate = limits.room(q), limits.rate(qd)
    least, moved = room.min(axis=0), np.abs(rate).max(axis=0) * length.max(initial=0.0)
    stops = np.flatnonzero(least < 2.0 * DIP * moved)  # the others are too far away for these steps
    if not len(stops) and least.min() >= 0.0:
        return []
    ends = np.flatnonzero((room[1:] < 0.0).any(axis=1))[:1]
    count = int(ends[0]) + 1 if len(ends) else len(length)
    found = [Touch(int(step), int(stop), 1.0) for step in ends for stop in np.flatnonzero(room[step + 1] < 0.0)]
    room, rate = room[: count + 1, stops], rate[: count + 1, stops]
    slope, after = rate[:-1] * length[:count, None], rate[1:] * length[:count, None]
    near = np.minimum(room[:-1], room[1:]) < DIP * (np.abs(slope) + np.abs(after))
    for step, k in np.argwhere(near).tolist():
        start, end = room[step, k], room[step + 1, k]
        at, value = lowest_of_cubic(start, slope[step, k], end, after[step, k])
        if 0.0 < at < 1.0 and value < 0.5 * min(start, end):
            found.append(Touch(step, int(stops[k]), at))
    return sorted(found, key=lambda touch: (touch.step, touch.at))


def lowest_of_cubic(start: float, slope: float, end: float, after: float) -> tuple[float, float]:
    """Where the cubic with these values and slopes at 0 and 1 has its minimum, and its value; 0 if it has none."""
    rise = end - start
    b, c = 3.0 * rise - 2.0 * slope - after, slope + after - 2.0 * rise
    root = b * b - 3.0 * slope * c
    if root <= 0.0:
        return 0.0, start
    below = sqrt(root)
    at = -slope / (b + below) if b > 0.0 else (below - b) / (3.0 * c) if c else 0.0
    return at, start + at * (slope + at * (b + at * c))


def first_passed(touches: Iterable[Touch], room: Callable[[float], Floats], length: float) -> float | None:
    """The last moment of a step before a joint is beyond a limit, by its touches and the room that the method itself
    leaves to every limit at a time after its beginning; None if it is nowhere."""
    moments = []
    for _, stop, at in touches:
        left = partial(lambda stop, time: float(room(time)[stop]), stop)
        time = length
        if at < 1.0:
            from scipy.optimize import minimize_scalar

            ends = max(at - ASIDE, 0.0) * length, min(at + ASIDE, 1.0) * length
            how = {"xatol": FINEST * (ends[1] - ends[0])}
            time = float(minimize_scalar(left, bounds=ends, method="bounded", options=how).x)
        if left(time) < 0.0:
            moments.append(moment(left, time))
    return min(moments, default=None)


def moment(room: Callable[[float], float], end: float) -> float:
    """The last time in [0, end] before the room is negative, as it is at `end` and not at 0, by bisection."""
    low, high = 0.0, end
    while low < (middle := 0.5 * (low + high)) < high and high - low > 1e-15 * end:
        low, high = (low, middle) if room(middle) < 0.0 else (middle, high)
    return low
