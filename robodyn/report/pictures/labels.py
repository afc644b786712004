"""Where labels of a drawing go, so that they cover neither each other nor the arrows."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, sin
from typing import NamedTuple

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
        """Whether a segment passes through, by clipping it at each side in turn."""
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
    """About how wide a text in a bold sans-serif is, rather more than less [px]."""
    return 0.64 * size * len(text)


def place(anchor: Point, along: Point, size: Point, taken: Sequence[Box], lines: Sequence[Segment], page: Box) -> Box:
    """A box of this size near `anchor`, best straight on in the direction `along`.

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
