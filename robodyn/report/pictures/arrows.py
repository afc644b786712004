"""Forces and moments of a free body as arrows on paper, isometric and to scale, and where their labels go."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from robodyn.equations.free_body.types import FreeBody
from robodyn.programs.vectors import Array, length, product
from robodyn.report.sizes import Sizes
from robodyn.report.table import is_noise

Point = tuple[float, float]
Segment = tuple[Point, Point]

_TURNS = 24
_REACHES = (12.0, 22.0, 34.0, 48.0, 64.0, 84.0, 110.0, 140.0, 175.0)


class Box(NamedTuple):
    """A rectangle in pixels; y grows downwards."""

    left: float
    top: float
    right: float
    bottom: float

    def meets(self, other: Box) -> bool:
        return (
            self.left < other.right and other.left < self.right and self.top < other.bottom and other.top < self.bottom
        )

    def inside(self, other: Box) -> bool:
        return (
            other.left <= self.left
            and self.right <= other.right
            and other.top <= self.top
            and self.bottom <= other.bottom
        )

    def cut_by(self, segment: Segment) -> bool:
        """Return whether a segment passes through, by clipping it at each side in turn."""
        (x0, y0), (x1, y1) = segment
        low, high = 0.0, 1.0
        for start, change, least, greatest in (
            (x0, x1 - x0, self.left, self.right),
            (y0, y1 - y0, self.top, self.bottom),
        ):
            if change == 0.0:
                if not least < start < greatest:
                    return False
                continue
            one, other = sorted(((least - start) / change, (greatest - start) / change))
            low, high = max(low, one), min(high, other)
        return low < high


def text_width(text: str, size: float) -> float:
    """Return about how wide a text in a bold sans-serif is, rather more than less [px]."""
    return 0.64 * size * len(text)


def place(anchor: Point, along: Point, size: Point, taken: Sequence[Box], lines: Sequence[Segment], page: Box) -> Box:
    """Return a box of this size near `anchor`, best straight on in the direction `along`.

    The nearest place wins that lies on the page and clear of other boxes and lines; where there is none, the one with
    the fewest collisions.
    """
    width, height = size
    best, least = None, float("inf")
    for reach in _REACHES:
        for k in range(_TURNS):
            turn = 2 * pi * k / _TURNS
            x, y = cos(turn), sin(turn)
            centre_x = anchor[0] + x * (reach + width / 2)
            centre_y = anchor[1] + y * (reach + height / 2)
            box = Box(centre_x - width / 2, centre_y - height / 2, centre_x + width / 2, centre_y + height / 2)
            collisions = 1000.0 * (not box.inside(page))
            collisions += 100.0 * sum(box.meets(other) for other in taken)
            collisions += 40.0 * sum(box.cut_by(line) for line in lines)
            cost = collisions + reach + 6.0 * (1.0 - (x * along[0] + y * along[1]))
            if cost < least:
                best, least = box, cost
    assert best is not None
    return best


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
    """Return a vector in ground axes as (right, down)."""
    return float(product(RIGHT, vector)), -float(product(UP, vector))


def arrows(body: FreeBody, spot: dict[int, Point], size: Sizes) -> list[Arrow]:
    """Return the arrows of every force and moment that does not vanish beside the largest on the robot.

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
    """Return the arrow moved sideways past those that leave about the same spot in about the same direction."""
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
