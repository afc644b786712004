"""Plots by matplotlib, as SVG elements that take their colours from the page they stand in; panels and axes."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from math import ceil, floor, log10
from typing import TYPE_CHECKING, Any

from robodyn.support.floats import Floats
from robodyn.support.libraries import treated_warnings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
    from matplotlib.figure import Figure as Canvas

    from robodyn.support.floats import Floats


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


INK, SOFT, GRID, PAPER, BAD, GOOD = "#0a0b01", "#0a0b02", "#0a0b03", "#0a0b04", "#0a0b05", "#0a0b06"
SERIES = tuple(f"#0a0c{k:02d}" for k in range(1, 11))
"""Colours that stand for those of a page: words and axes, less important ones, lines behind, the page itself, what is
bad, what is good, and those of curves."""
_NAMES = {INK: "ink", SOFT: "soft", GRID: "grid", PAPER: "paper", BAD: "bad", GOOD: "good"}
_NAMES |= {colour: f"c{k}" for k, colour in enumerate(SERIES, start=1)}
_OF_ACTIONS = {"#2b8a3e": "c3", "#9c5fd0": "c4", "#2f7fd6": "c1", "#d6336c": "c6", "#b8680b": "c2"}
_OF_ACTIONS |= {"#11837f": "c5", "#d9480f": "c8"}
_RASTER = 2.0
"""Dots of a raster in a figure for each pixel of the page."""
DOTS = 72
"""Per inch, so that a point is a pixel of the page."""
_NUMBER = re.compile(r"(?<=\d\.\d)\d+")
_PATH = re.compile(r'(?<= d=")[^"]*')


def style(name: str) -> AbstractContextManager[Any]:
    """Return the look of all plots, within which they are made and written; nothing in a label is read as a formula."""
    from matplotlib import rc_context

    return rc_context(
        {
            **{"svg.fonttype": "none", "svg.hashsalt": name, "text.parse_math": False, "font.size": 11},
            **{"axes.edgecolor": SOFT, "axes.labelcolor": INK, "axes.titlecolor": INK, "text.color": INK},
            **{"axes.titlesize": 11, "axes.titlelocation": "left", "axes.titlepad": 5, "axes.titley": 1.0},
            **{"axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "axes.axisbelow": True},
            **{"axes.facecolor": "none", "figure.facecolor": "none", "savefig.facecolor": "none"},
            **{"axes.formatter.limits": (-4, 5), "axes.formatter.useoffset": False, "axes.xmargin": 0.0},
            **{"grid.color": GRID, "grid.linewidth": 0.8},
            **{"xtick.color": SOFT, "ytick.color": SOFT, "xtick.labelcolor": INK, "ytick.labelcolor": INK},
            **{"xtick.bottom": False, "ytick.left": False, "xtick.major.pad": 4, "ytick.major.pad": 4},
            **{"axes.labelsize": 11, "xtick.labelsize": 10, "ytick.labelsize": 10},
            **{"lines.linewidth": 1.4, "path.simplify": False},
            **{"legend.frameon": False, "legend.fontsize": 10, "legend.handlelength": 1.4, "legend.borderaxespad": 0.0},
        }
    )


def plot(width: int, height: int, draw: Callable[[Figure], None], name: str) -> str:
    """Return an SVG element of this size [px] for a page.

    Args:
        draw: puts what is to be seen on a figure.
        name: no other figure of the page has.
    """
    return Sheet(width, height).plot(draw, name)


class Sheet:
    """A figure to draw one plot after another on; axes that stay on it cost time once."""

    def __init__(self, width: int, height: int) -> None:
        """Args: width, height: px."""
        from matplotlib.figure import Figure

        self._figure = Figure(figsize=(width / DOTS, height / DOTS), facecolor="none")

    def plot(self, draw: Callable[[Figure], None], name: str) -> str:
        """Return an SVG element for a page; see `plot`."""
        import io

        from matplotlib.backends.backend_svg import FigureCanvasSVG

        with treated_warnings("ignore", "Glyph"), style(name):  # the page's own fonts may have it
            canvas: Any = FigureCanvasSVG(self._figure)
            for axes in self._figure.axes:
                _wipe(axes)
            self._figure.dpi = DOTS
            draw(self._figure)
            self._figure.dpi = DOTS * _RASTER
            stream = io.StringIO()
            canvas.print_svg(stream, metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
        return _themed(stream.getvalue())


def _wipe(axes: Axes) -> None:
    """Remove what was drawn on axes, and their limits; titles, ticks and labels stay."""
    for artist in [*axes.lines, *axes.collections]:
        artist.remove()
    axes.relim()
    axes.autoscale()


def few_ticks(axes: Axes, across: int = 5, up: int = 3) -> None:
    """Set the numbers along each axis, so many at most, without a factor beside it, which is overlooked."""
    for axis, bins in ((axes.xaxis, across), (axes.yaxis, up)):
        locator: Any = axis.get_major_locator()
        locator.set_params(nbins=bins)
        plain_numbers(axis)


def dots(axes: Axes, x: Floats, y: Floats, colour: str, size: float = 3.0) -> None:
    """Draw points as one short path: a marker each would make the page ten times as long."""
    import numpy as np

    across, up = (np.column_stack((each, each, np.full(len(each), np.nan))).ravel() for each in (x, y))
    axes.plot(across, up, color=colour, linewidth=size, solid_capstyle="round")


def of_page(drawing: str) -> str:
    """Return the drawing of a free body, which is made for a file of its own, in the colours of a page."""
    from robodyn.report.pictures.free_body import STYLE

    drawing = drawing.replace(STYLE, "").strip()
    for colour, name in _OF_ACTIONS.items():
        drawing = drawing.replace(colour, f"var(--{name})")
    return drawing


def _themed(svg: str) -> str:
    """Return the element alone: colours of the page, coordinates to a tenth of a pixel, no names of groups."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<!--.*?-->\n?", "", svg, flags=re.DOTALL)
    svg = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'<g id="[^"]*"', "<g", svg)
    svg = re.sub(r' style="image-rendering:[^"]*"', "", svg)
    svg = re.sub(r'(?<=style=")font: (bold |)([\d.]+px)[^;"]*', _font, svg)
    svg = re.sub(r'(<svg[^>]*?) width="[\d.]+pt" height="[\d.]+pt"', r"\1", svg, count=1)
    svg = _PATH.sub(_shorter, svg)
    for colour, name in _NAMES.items():
        svg = svg.replace(colour, f"var(--{name})")
    return svg.strip()


def _font(found: re.Match[str]) -> str:
    return f"font-size: {found[2]}" + ("; font-weight: bold" if found[1] else "")


def _shorter(path: re.Match[str]) -> str:
    return _NUMBER.sub("", path[0]).replace(".0 ", " ").replace("\n", "").replace(" L", "L")


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
