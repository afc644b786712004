"""Forces and moments of a free body as arrows on paper: isometric, to scale, side by side where they would coincide."""

from __future__ import annotations

from math import hypot, sqrt
from typing import NamedTuple

import numpy as np

from robodyn.equations.free_body.types import FreeBody
from robodyn.programs.vectors import Array, length, product
from robodyn.report.pictures.labels import Point
from robodyn.report.sizes import Sizes
from robodyn.report.table import is_noise

RIGHT = np.array([-1.0, 1.0, 0.0]) / sqrt(2)
UP = np.array([-1.0, -1.0, 2.0]) / sqrt(6)
TOWARDS = np.array([1.0, 1.0, 1.0]) / sqrt(3)
"""Ground axes seen from (1, 1, 1): x runs to the left below, y to the right below, z upwards."""

LONGEST, SHORTEST = 120.0, 42.0
"""Arrows in pixels; the largest force and the largest moment are the longest."""
HEAD_ON = 14.0
"""Shorter arrows point at the reader or away, and are drawn as discs."""
_ASIDE, _ALIKE = 12.0, 0.97


class Arrow(NamedTuple):
    """A vector on paper.

    Attributes:
        kind: of the action, which gives the colour.
        symbol, value, unit: for its label.
        start, end: px; equal for a vector along the line of sight, which then points `towards` the reader or away.
        turning: a moment, drawn with two heads.
    """

    kind: str
    symbol: str
    value: float
    unit: str
    start: Point
    end: Point
    towards: bool
    turning: bool

    @property
    def direction(self) -> Point:
        x, y = self.end[0] - self.start[0], self.end[1] - self.start[1]
        length = hypot(x, y)
        return (x / length, y / length) if length else (0.0, -1.0)


def on_paper(vector: Array) -> Point:
    """A vector in ground axes as (right, down)."""
    return float(product(RIGHT, vector)), -float(product(UP, vector))


def arrows(body: FreeBody, spot: dict[int, Point], size: Sizes) -> list[Arrow]:
    """The arrows of every force and moment that does not vanish beside the largest on the robot.

    Args:
        spot: by action, where on paper it acts.
        size: of forces and moments, see `free_body_sizes`.
    """
    out: list[Arrow] = []
    for turning, name, unit in ((False, "force", "N"), (True, "moment", "N m")):
        amounts = [length(getattr(action, name)) for action in body.actions]
        largest = max(amounts, default=0.0)
        for k, (action, amount) in enumerate(zip(body.actions, amounts, strict=True)):
            if is_noise(amount, size[unit]):
                continue
            unit_vector = product(body.pose.R, getattr(action, name)) / amount
            drawn = max(SHORTEST, LONGEST * amount / largest)
            x, y = (drawn * sqrt(1.5) * part for part in on_paper(unit_vector))
            start, symbol = spot[k], action.symbols[turning]
            flat = hypot(x, y) >= HEAD_ON
            end = (start[0] + x, start[1] + y) if flat else start
            towards = bool(product(TOWARDS, unit_vector) > 0)
            out.append(_aside(Arrow(action.kind, symbol, amount, unit, start, end, towards, turning), out))
    return out


def _aside(arrow: Arrow, others: list[Arrow]) -> Arrow:
    """The arrow moved sideways past those that leave about the same spot in the same or the opposite direction."""
    x, y = arrow.direction
    for step in (0, 1, -1, 2, -2, 3, -3, 4, -4):
        dx, dy = -y * _ASIDE * step, x * _ASIDE * step
        moved = arrow._replace(
            start=(arrow.start[0] + dx, arrow.start[1] + dy), end=(arrow.end[0] + dx, arrow.end[1] + dy)
        )
        if not any(_alike(moved, other) for other in others):
            break
    return moved


def _alike(one: Arrow, other: Arrow) -> bool:
    apart = hypot(one.start[0] - other.start[0], one.start[1] - other.start[1])
    if one.start == one.end or other.start == other.end:
        return one.start == one.end and other.start == other.end and apart < 2 * _ASIDE
    (a, b), (c, d) = one.direction, other.direction
    return apart < 0.7 * _ASIDE and a * c + b * d > _ALIKE
