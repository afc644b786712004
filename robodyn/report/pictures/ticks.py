"""Where the numbers along an axis stand and how they are written: each label once, without a factor beside the axis."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor, log10
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axis import Axis

_MOST_DIGITS = 17
_ABOVE_ZERO = 30.0
"""The first number of a logarithmic axis is so many times as high as the place of its 0."""


def tick_labels(values: Sequence[float]) -> list[str]:
    """Return one label for each number, with as many digits as tell them apart, five at least."""
    for digits in range(5, _MOST_DIGITS + 1):
        labels = [f"{x:.{digits}g}".replace("-", "\u2212") for x in values]
        if len(set(labels)) == len(labels):
            break
    return labels


def plain_numbers(axis: Axis) -> None:
    """Label an axis by `tick_labels`."""
    from matplotlib.ticker import FuncFormatter

    formatter: Any = FuncFormatter(lambda x, _: tick_labels([x])[0])
    formatter.format_ticks = tick_labels
    axis.set_major_formatter(formatter)


def log_ticks(low: float, high: float, most: int) -> list[float]:
    """Return at most about `most` round numbers of a logarithmic axis between two positive numbers.

    Powers of ten over three decades and more, else 1, 2 and 5 times them over one decade and more, else equal steps.
    """
    decades = log10(high / low)
    first, last = floor(log10(low)), ceil(log10(high))
    if decades >= 3.0:
        step = max(1, ceil(decades / most))
        found = [10.0**k for k in range(ceil(first / step) * step, last + 1, step)]
    elif decades >= 1.0:
        found = [float(f"{lead}e{k}") for k in range(first, last + 1) for lead in (1, 2, 5)]
    else:
        from matplotlib.ticker import MaxNLocator

        found = [float(x) for x in MaxNLocator(most, steps=[1, 2, 5, 10]).tick_values(low, high)]
    return [x for x in found if low <= x <= high]


def log_axis(axis: Axis, most: int = 8, zero: float | None = None) -> None:
    """Give a logarithmic axis, whose limits are set, its ticks and labels.

    Args:
        zero: where 0 is drawn, below every number.
    """
    from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

    low, high = (float(x) for x in axis.get_view_interval())
    ticks = log_ticks(low if zero is None else zero * _ABOVE_ZERO, high, most)
    labels = tick_labels(ticks)
    if zero is not None:
        ticks, labels = [zero, *ticks], ["0", *labels]
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_major_formatter(FixedFormatter(labels))
    axis.set_minor_locator(NullLocator())
