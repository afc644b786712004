"""Limits that a motion only just reaches or misses: how small its error has to be to tell which."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from robodyn.measure.accuracy.motion_error import MotionError
from robodyn.simulation.events import Limits, Stop, lowest_of_cubic
from robodyn.simulation.result import Simulation
from robodyn.support.floats import Floats, first_largest

NEAREST = 16
"""Turns that are looked at closely."""


class Graze(NamedTuple):
    """A limit that a motion misses or passes by little.

    Attributes:
        depth: by how much, rad or m; negative where it misses.
        time: s, when.
        error: relative to the largest of the kind (see `MotionError`), at which either could be true.
    """

    stop: Stop
    depth: float
    time: float
    error: float

    def __str__(self) -> str:
        unit = "m" if self.stop.joint.kind == "prismatic" else "rad"
        side = "upper" if self.stop.side > 0 else "lower"
        how = "passes" if self.depth > 0.0 else "misses"
        where = f"its {side} limit of {self.stop.value:g} {unit} by {abs(self.depth):.1g} {unit}"
        return f'"{self.stop.joint.name}" {how} {where}, at {self.time:.6g} s'


def graze(motion: Simulation) -> Graze | None:
    """Return the limit that the least error of a motion would turn from missed to reached, or the other way round.

    Places at which joints turn back are looked at, and how far the joint would go on that ended the motion.
    """
    limits = Limits(motion.model, motion.scene.joint_limits == "stop")
    if not limits.stops:
        return None
    scale = MotionError.over(motion.model, np.hstack((motion.q, motion.qd))).scale[: motion.model.nq]
    moved = np.abs(limits.room(scale) - limits.room(0.0 * scale))
    found = [*_missed(limits, motion, moved), *_passed(limits, motion)]
    if not found:
        return None
    errors = [abs(depth) / moved[place] for place, depth, _ in found]
    first = first_largest(-np.array(errors))
    place, depth, time = found[first]
    return Graze(limits.stops[place], depth, time, float(errors[first]))


def _missed(limits: Limits, motion: Simulation, moved: Floats) -> Iterator[tuple[int, float, float]]:
    """Where joints turn back before a limit: which, minus what was left to it, and when; the nearest of them."""
    room, rate, length = limits.room(motion.q), limits.rate(motion.qd), np.diff(motion.time)
    rows, places = np.nonzero((rate[:-1] < 0.0) & (rate[1:] >= 0.0))
    least = np.minimum(room[rows, places], room[rows + 1, places])
    slopes = length[rows] * (np.abs(rate[rows, places]) + np.abs(rate[rows + 1, places]))
    for k in np.argsort((least - 4.0 / 27.0 * slopes) / moved[places], kind="stable")[:NEAREST]:
        row, place, h = int(rows[k]), int(places[k]), float(length[rows[k]])
        ends = room[row, place], h * rate[row, place], room[row + 1, place], h * rate[row + 1, place]
        at, left = lowest_of_cubic(*map(float, ends))
        yield place, -left, float(motion.time[row] + at * h)


def _passed(limits: Limits, motion: Simulation) -> Iterator[tuple[int, float, float]]:
    """How far the joint that ended a motion would have gone on, braked as it is at the limit."""
    if not motion.ended:
        return
    place = first_largest(-limits.room(motion.q[-1]))
    speed, braked = limits.rate(motion.qd[-1])[place], limits.rate(motion.qdd[-1])[place]
    if braked > 0.0:
        yield place, float(0.5 * speed * speed / braked), float(motion.time[-1])
