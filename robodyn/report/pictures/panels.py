"""Axes that several figures share: panels against time, quantities of one unit, lines of zero and of limits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from robodyn.report.pictures.figures import BAD, SERIES, SOFT, few_ticks
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

WIDE, LOW = 380, 280
"""The width of a figure, and the height of one with a single panel [px]."""
Lines = dict[str, tuple[Floats, Floats]]
"""Times and values by name."""


def panel(canvas: Canvas, bottom: float, height: float, tall: float) -> Axes:
    """Return axes of this height above the bottom of a figure [px]."""
    return canvas.add_axes((0.16, bottom / tall, 0.8, height / tall))


def against_time(
    canvas: Canvas,
    lines: Lines,
    unit: str,
    looks: Sequence[dict[str, Any]] = ({},) * len(SERIES),
    *,
    left: float = 0.16,
    width: float = 0.805,
    first: int = 0,
) -> None:
    """Draw quantities of one unit, with their names above where there are several, on axes that stay.

    Args:
        left, width: of the axes, in parts of the figure; first: colour.
    """
    if not canvas.axes:
        axes = canvas.add_axes((left, 0.15, width, 0.68))
        axes.set_xlabel("time [s]")
        few_ticks(axes, up=6)
    (axes,) = canvas.axes
    for (name, line), look, colour in zip(lines.items(), looks, SERIES[first:], strict=False):
        axes.plot(*line, label=name, color=colour, **look)
    if len(lines) > 1:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.02), ncols=len(lines), columnspacing=1.0)
    axes.set_title(f"[{unit}]")


def zero_lines(axes: Axes) -> None:
    """Draw the lines of zero behind all else."""
    for line in (axes.axhline, axes.axvline):
        line(0.0, color=SOFT, linewidth=0.8, zorder=1)


def limit_lines(axes: Axes, effort: float | None, velocity: float | None) -> None:
    """Draw the limits of torque, upwards, and of speed, across."""
    for limit, line in ((effort, axes.axhline), (velocity, axes.axvline)):
        for bound in () if limit is None else (-limit, limit):
            line(bound, color=BAD, linewidth=1.2, dashes=(5, 3))
