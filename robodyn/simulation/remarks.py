"""What there is to say about a simulated motion: joints that friction holds, and limits that springs guard."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.effects.friction import rubbing
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Scene
from robodyn.simulation.limits import Limits
from robodyn.support.ties import first_largest, ranked

Floats = NDArray[np.float64]
SLOW = 3.0
"""Slip speeds below which a joint is held: friction then balances up to 95 % of what it is at speed."""
SHORT = 0.05
"""Of the motion: a joint that is held for less merely turns back."""


class Held(NamedTuple):
    """A joint that friction held for some time [s], and how far and how fast it crept meanwhile [rad, rad/s]."""

    joint: Joint
    time: float
    creep: float
    speed: float

    def __str__(self) -> str:
        unit = "m" if self.joint.kind == "prismatic" else "rad"
        return (
            f'friction holds "{self.joint.name}" for {self.time:.4g} s, in which it creeps {self.creep:.2g} {unit}, '
            f"at most {self.speed:.2g} {unit}/s"
        )


def held(model: Model, scene: Scene, time: Floats, qd: Floats) -> Iterator[Held]:
    """The joints with Coulomb friction that were held, of a motion with speeds qd (N, n)."""
    lasting = np.diff(time)
    for _, joint, friction in rubbing(model, scene):
        if not (scene.slip_speed and (friction.forward or friction.backward or friction.stribeck)):
            continue
        speed = np.abs(joint.multiplier * qd[:, joint.rate])
        slow = speed <= SLOW * scene.slip_speed
        still = slow[:-1] & slow[1:]
        if lasting[still].sum() > SHORT * (time[-1] - time[0]):
            mean = 0.5 * (speed[:-1] + speed[1:])
            most = float(np.maximum(speed[:-1], speed[1:])[still].max())
            yield Held(joint, float(lasting[still].sum()), float((mean * lasting)[still].sum()), most)


class Deepest(NamedTuple):
    """The limit that a motion passes by most: its joint, side and value, by how much, when, and how many are passed."""

    joint: Joint
    side: str
    value: float
    depth: float
    time: float
    limits: int

    def __str__(self) -> str:
        unit = "m" if self.joint.kind == "prismatic" else "rad"
        others = f", the most of {self.limits} limits that are passed" if self.limits > 1 else ""
        where = f'"{self.joint.name}" passes its {self.side} limit of {self.value:g} {unit}'
        return f"{where} by at most {self.depth:.4g} {unit}, at {self.time:.4g} s{others}"


def deepest(model: Model, time: Floats, q: Floats, qd: Floats) -> Deepest | None:
    """How far joints went beyond their limits, at most; None if they did not."""
    limits = Limits(model, True)
    room = limits.room(q)
    if not limits.stops or room.min() >= 0.0:
        return None
    row, place = (int(k) for k in np.unravel_index(first_largest(-room), room.shape))
    stop = limits.stops[place]
    approach = stop.side * stop.joint.multiplier * qd[:, stop.joint.rate]
    when, depth = _peak(time, -room[:, place], approach, row)
    side = "upper" if stop.side > 0 else "lower"
    return Deepest(stop.joint, side, stop.value, depth, when, int((room < 0.0).any(axis=0).sum()))


def _peak(time: Floats, x: Floats, xd: Floats, row: int) -> tuple[float, float]:
    """When x is largest, and how large, on cubics through the rows with their slopes, near the largest row."""
    best = float(time[row]), float(x[row])
    for k in range(max(row - 1, 0), min(row + 1, len(time) - 1)):
        h, s = time[k + 1] - time[k], np.linspace(0.0, 1.0, 65)
        start, end = (1 + 2 * s) * (1 - s) ** 2 * x[k], s * s * (3 - 2 * s) * x[k + 1]
        curve = start + end + h * (s * (1 - s) ** 2 * xd[k] - s * s * (1 - s) * xd[k + 1])
        top = first_largest(curve)
        best = ranked([best, (float(time[k] + s[top] * h), float(curve[top]))], key=lambda pair: pair[1])[0]
    return best
