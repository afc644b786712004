"""Joint limits as events: how far each joint is from its limits, and the moment at which one is reached."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import InputError
from robodyn.model import Joint, Model
from robodyn.ties import first_largest

Floats = NDArray[np.float64]


class Stop(NamedTuple):
    """A limit: `side * (value - joint's position)` is the room that is left."""

    joint: Joint
    side: float
    value: float

    def reached(self, time: float) -> str:
        unit, word = "m" if self.joint.kind == "prismatic" else "rad", "upper" if self.side > 0 else "lower"
        return f'"{self.joint.name}" reaches its {word} limit of {self.value:g} {unit} at {time:.6g} s'


class Limits:
    """The limits of a model's joints, followers of mimicked ones among them."""

    def __init__(self, model: Model, watched: bool) -> None:
        """Args: watched: False for none."""
        self.stops = [
            Stop(body.joint, side, value)
            for body in model.bodies
            if watched and body.joint.kind in ("revolute", "prismatic")
            for side, value in ((-1.0, body.joint.lower), (1.0, body.joint.upper))
            if value is not None
        ]
        self._places = [stop.joint.coordinate for stop in self.stops]
        self._gain = np.array([stop.side * stop.joint.multiplier for stop in self.stops])
        self._room = np.array([stop.side * (stop.value - stop.joint.offset) for stop in self.stops])

    def room(self, q: Floats) -> Floats:
        """(..., stops) rad or m left for q (..., nq); negative beyond a limit."""
        return self._room - self._gain * q[..., self._places]

    def check_start(self, q: Floats) -> None:
        """Raise if a joint begins beyond a limit."""
        for stop, room in zip(self.stops, self.room(q).tolist(), strict=True):
            if room < 0.0:
                joint = stop.joint
                at = joint.multiplier * q[joint.coordinate] + joint.offset
                raise InputError(
                    f'"{joint.name}" begins at {at:g}, beyond its limit of {stop.value:g}',
                    remedy='begin within the limits, or write joint_limits = "ignore" in the scene',
                )

    def first_beyond(self, q: Floats) -> int | None:
        """The first of the rows q (N, nq) at which a joint is beyond a limit."""
        if not self.stops:
            return None
        beyond = (self.room(q) < 0.0).any(axis=1)
        return int(np.argmax(beyond)) if beyond.any() else None

    def nearest(self, q: Floats) -> Stop:
        """The limit that q (nq) is nearest to, or farthest beyond."""
        return self.stops[first_largest(-self.room(q))]


def moment(beyond: Callable[[float], bool], end: float) -> float:
    """The last time in [0, end] before `beyond`, which holds at `end` and not at 0, by bisection to a rounding."""
    low, high = 0.0, end
    while low < (middle := 0.5 * (low + high)) < high and high - low > 1e-15 * end:
        low, high = (low, middle) if beyond(middle) else (middle, high)
    return low
