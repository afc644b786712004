"""The search for the least of a convex function along a step, for many samples at a time."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from robodyn.support.floats import Floats

ENOUGH = 1e-4
"""The part of what a step promises that the function must fall by (Armijo)."""
FLATTER = 0.5
"""The slope where a search ends is at most this part of that where it began (Wolfe)."""
NARROW = 0.1
"""A search also ends where this part of the length is left, as at kinks of the slope."""
MARGIN = 0.1
"""The part of what is left that each look at least takes away."""

TOWARDS = 0.2
"""Where to look between the ends once the same one has moved twice."""


class Search(NamedTuple):
    """Of each sample (N,): the length to look at, the ends between which the slope is 0, and the slopes there.

    Attributes:
        slope: where the step begins.
        side: the end that moved last, 1 or -1; 0: none has.
    """

    slope: Floats
    length: Floats
    low: Floats
    high: Floats
    slope_low: Floats
    slope_high: Floats
    side: Any


def begun(slope: Floats) -> Search:
    """Return the search along steps of length 1 that begin with these slopes."""
    zero, one = np.zeros_like(slope), np.ones_like(slope)
    return Search(slope, one, zero, one, slope, zero, zero)


def ended(search: Search, slope: Floats, fall: Floats) -> Any:
    """Return whether to go no further than to where the function is less by `fall` and has this slope."""
    flat = np.abs(slope) <= FLATTER * np.abs(search.slope)
    narrow = search.high - search.low <= NARROW * search.length
    return lower(search, fall) & (flat | narrow | (search.length == 1.0))


def lower(search: Search, fall: Floats) -> Any:
    """Return whether the function fell by enough."""
    return fall >= ENOUGH * search.length * np.abs(search.slope)


def narrowed(search: Search, slope: Floats, fall: Floats) -> Search:
    """Return the search after such a look: where a line between the slopes is 0, or nearer to an end that stays."""
    right = (slope >= 0.0) | ~lower(search, fall)
    side = np.where(right, 1.0, -1.0)
    low, high = np.where(right, search.low, search.length), np.where(right, search.length, search.high)
    slope_low, slope_high = np.where(right, search.slope_low, slope), np.where(right, slope, search.slope_high)
    left = high - low
    with np.errstate(all="ignore"):
        zero = np.nan_to_num(low + left * slope_low / (slope_low - slope_high), nan=0.0)
    length = np.clip(zero, low + MARGIN * left, high - MARGIN * left)
    length = np.where(side == search.side, low + TOWARDS * left, length)
    return Search(search.slope, length, low, high, slope_low, slope_high, side)
