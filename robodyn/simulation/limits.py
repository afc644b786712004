"""Joint limits as events: how far each joint is from its limits, and the moment at which one is reached."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import InputError
from robodyn.robot.model import Joint, Model
from robodyn.support.ties import first_largest

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
        """Raise if a joint begins beyond a limit."""
        for stop, room in zip(self.stops, self.room(q).tolist(), strict=True):
            if room < 0.0:
                joint = stop.joint
                at = joint.multiplier * q[joint.coordinate] + joint.offset
                raise InputError(
                    f'"{joint.name}" begins at {at:g}, beyond its limit of {stop.value:g}',
                    remedy='begin within the limits, or write joint_limits = "ignore" in the scene',
                )

    def nearest(self, q: Floats) -> Stop:
        """The limit that q (nq) is nearest to, or farthest beyond."""
        return self.stops[first_largest(-self.room(q))]
