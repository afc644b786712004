"""Plots by matplotlib, as SVG elements that take their colours from the page they stand in."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.loads.history import Curves, MinMaxDecimation
from robodyn.report.document import Figure
from robodyn.report.sizes import simulation_sizes
from robodyn.report.table import NOISE, drift_text, is_noise, number, printable
from robodyn.support.floats import Floats
from robodyn.support.libraries import treated_warnings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from robodyn.identification.faults.compare import Comparison
    from robodyn.simulation.result import Simulation

INK, SOFT, GRID, PAPER, BAD, GOOD = "#0a0b01", "#0a0b02", "#0a0b03", "#0a0b04", "#0a0b05", "#0a0b06"
SERIES = tuple(f"#0a0c{k:02d}" for k in range(1, 11))
"""Colours that stand for those of a page: words and axes, less important ones, lines behind, the page itself, what is
bad, what is good, and those of curves."""
_NAMES = {INK: "ink", SOFT: "soft", GRID: "grid", PAPER: "paper", BAD: "bad", GOOD: "good"}
_NAMES |= {colour: f"c{k}" for k, colour in enumerate(SERIES, start=1)}
WIDE = 380
"""Width of a figure [px]."""
_DOTS, _RASTER = 72, 2.0
"""Per inch, so that a point is a pixel of the page; dots of a raster for each pixel."""
Line = tuple[Floats, Floats]
"""Times and values."""


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
            **{"axes.formatter.limits": (-6, 11), "axes.formatter.useoffset": False, "axes.xmargin": 0.0},
            **{"grid.color": GRID, "grid.linewidth": 0.8},
            **{"xtick.color": SOFT, "ytick.color": SOFT, "xtick.labelcolor": INK, "ytick.labelcolor": INK},
            **{"xtick.bottom": False, "ytick.left": False, "xtick.major.pad": 4, "ytick.major.pad": 4},
            **{"axes.labelsize": 11, "xtick.labelsize": 10, "ytick.labelsize": 10},
            **{"lines.linewidth": 1.4, "path.simplify": False},
            **{"legend.frameon": False, "legend.fontsize": 10, "legend.handlelength": 1.4, "legend.borderaxespad": 0.0},
        }
    )


def plot(width: int, height: int, draw: Callable[[Canvas], None], name: str) -> str:
    """Return an SVG element of this size [px] for a page, by a name that no other figure of the page has."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure as Canvas

    with treated_warnings("ignore", "Glyph"), style(name):  # the page's own fonts may have it
        figure = Canvas(figsize=(width / _DOTS, height / _DOTS), dpi=_DOTS, facecolor="none")
        draw(figure)
        figure.dpi = _DOTS * _RASTER
        stream = io.StringIO()
        canvas: Any = FigureCanvasSVG(figure)
        canvas.print_svg(stream, metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))

    def shorter(path: re.Match[str]) -> str:
        return re.sub(r"(?<=\d\.\d)\d+", "", path[0]).replace(".0 ", " ").replace("\n", "").replace(" L", "L")

    svg = stream.getvalue()  # colours of the page, coordinates to a tenth of a pixel, no names of groups
    svg = svg[svg.index("<svg") :]
    for pattern, kept in (
        (r"(?s)<!--.*?-->\n?|<metadata>.*?</metadata>|<style.*?</style>", ""),
        (r'<g id="[^"]*"', "<g"),
        (r' style="image-rendering:[^"]*"', ""),
        (r'(?<=style=")font: bold ([\d.]+px)[^;"]*', r"font-weight: bold; font-size: \1"),
        (r'(?<=style=")font: ([\d.]+px)[^;"]*', r"font-size: \1"),
    ):
        svg = re.sub(pattern, kept, svg)
    svg = re.sub(r'(<svg[^>]*?) width="[\d.]+pt" height="[\d.]+pt"', r"\1", svg, count=1)
    svg = re.sub(r'(?<= d=")[^"]*', shorter, svg)
    for colour, own in _NAMES.items():
        svg = svg.replace(colour, f"var(--{own})")
    return svg.strip()


def quiet(values: Floats, scale: float) -> Floats:
    """Return zeros for what is rounding noise throughout."""
    return np.zeros_like(values) if is_noise(float(np.abs(values).max()), scale) else values


def quiet_line(curves: Curves, quantity: str, column: int, scale: float) -> Line:
    """Return a curve, zero throughout where there is nothing but rounding noise."""
    time, values = curves.line(quantity, column)
    return time, quiet(values, scale)


def panel(canvas: Canvas, bottom: float, height: float) -> Axes:
    """Return axes of this height above the bottom of a figure [px], with few numbers along them."""
    tall = canvas.get_figheight() * _DOTS
    axes = canvas.add_axes((0.16, bottom / tall, 0.8, height / tall))
    axes.locator_params("x", nbins=5)
    axes.locator_params("y", nbins=3)
    return axes


def lines_figure(
    caption: str, alt: str, lines: Mapping[str, Line], unit: str, looks: Sequence[dict[str, Any]] = ({},) * len(SERIES)
) -> Figure:
    """Return quantities of one unit against time, with their names above where there are several."""

    def draw(canvas: Canvas) -> None:
        axes = panel(canvas, 42, 190)
        for (name, line), look, colour in zip(lines.items(), looks, SERIES, strict=False):
            axes.plot(*line, label=name, color=colour, **look)
        if len(lines) > 1:
            axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.02), ncols=len(lines), columnspacing=1.0)
        axes.set_title(f"[{unit}]")
        axes.set_xlabel("time [s]")

    return Figure(caption, alt, plot(WIDE, 280, draw, caption))


def dots(axes: Axes, x: Floats, y: Floats, colour: str) -> None:
    """Draw points, those on the same pixel once, as one short path: markers would take ten times as much room."""
    cells = [np.rint(300 * each / (np.ptp(each) if len(each) and np.ptp(each) else 1.0)) for each in (x, y)]
    _, kept = np.unique(np.stack(cells), axis=1, return_index=True)
    across, up = (np.column_stack((each, each, np.full(len(kept), np.nan))).ravel() for each in (x[kept], y[kept]))
    axes.plot(across, up, color=colour, linewidth=3.0, solid_capstyle="round")


def zero_lines(axes: Axes) -> None:
    """Draw the lines of zero behind all else."""
    for line in (axes.axhline, axes.axvline):
        line(0.0, color=SOFT, linewidth=0.8, zorder=1)


def _line(time: Floats, values: Floats) -> Line:
    """Return the least and the greatest of every short span of time."""
    thinned = MinMaxDecimation(("",), ("value",))
    thinned.update(time, (values[None],), float(time[-1] - time[0]))
    return thinned.curves().line("value", 0)


def joint_figure(name: str, slides: bool, time: Floats, values: tuple[Floats, ...]) -> Figure:
    """Return position, speed and load of a joint against time, without what is zero throughout."""
    units = ("m", "m/s", "N") if slides else ("rad", "rad/s", "N m")
    what = ("position", "speed", "drive's force" if slides else "drive's torque")
    shown = [k for k in range(len(what)) if values[k].any()]
    height = 130 * len(shown) + 20

    def draw(canvas: Canvas) -> None:
        for row, k in enumerate(shown, start=1):
            axes = panel(canvas, height - 130 * row + 12, 96)
            axes.plot(*_line(time, values[k]), color=SERIES[k])
            axes.set_title(f"{what[k]} [{units[k]}]")
            axes.tick_params(labelbottom=row == len(shown))
        axes.set_xlabel("time [s]", labelpad=1)

    ranges = [f"{what[k]} {number(values[k].min())} to {number(values[k].max())} {units[k]}" for k in shown]
    alt = f"Joint {printable(name)} against time: {', '.join(ranges)}"
    return Figure(printable(name), alt, plot(WIDE, height, draw, f"joint {name}"))


def energy_figures(result: Simulation) -> Iterator[Figure]:
    """Yield energies and work that are not zero throughout, and the drift where it is more than rounding."""
    figures, size, work = result.figures, simulation_sizes(result).energy, result.work - result.work[0]
    given = {"kinetic": figures.kinetic, "potential": figures.energy - figures.kinetic, "work done": work}
    parts = {name: _line(result.time, kept) for name, each in given.items() if (kept := quiet(each, size)).any()}
    if parts:
        largest = f"Against time; the largest kinetic energy is {number(figures.kinetic.max(), size)} J"
        yield lines_figure("Energies, and work done by drives and wrenches", largest, parts, "J")
    if result.energy_drift > NOISE * size:
        off = f"Stored energy less work done against time, at most {drift_text(result.energy_drift, size)} J from zero"
        drift = _line(result.time, figures.energy - figures.energy[0] - work)
        yield lines_figure("Drift: stored energy less work", off, {"drift": drift}, "J")


def torque_figure(found: Comparison, j: int) -> Figure:
    """Return measured and computed torque of a joint over time, and below what is left, before and after effects."""
    joint, curves = found.joints[j], found.curves
    every = slice(None, None, max(1, len(curves.time) // 1500))
    time, measured = curves.time[every], curves.measured[every, j]
    computed, explained = curves.computed[every, j], curves.explained[every, j]

    def draw(canvas: Canvas) -> None:
        above, below = panel(canvas, 205, 170), panel(canvas, 40, 115)
        lines = (("computed", computed, 1), ("with effects", explained, 2), ("measured", measured, 0))
        for label, line, colour in lines:
            above.plot(time, line, label=label, color=SERIES[colour], linewidth=1.0)
            if colour:
                below.plot(time, measured - line, color=SERIES[colour], linewidth=1.0)
        above.legend(loc="lower right", bbox_to_anchor=(1.0, 1.02), ncols=3, columnspacing=1.0)
        above.set_title(f"[{joint.unit}]")
        below.set(title=f"residuals [{joint.unit}]", xlabel="time [s]")

    alt = (
        f"{printable(joint.name)}: measured {number(joint.measured)} {joint.unit} RMS, "
        f"computed {number(joint.computed)}, residual {number(joint.residual)}, {number(joint.left)} with effects"
    )
    return Figure(printable(joint.name), alt, plot(WIDE, 420, draw, f"measured {j}"))


def friction_figure(found: Comparison, j: int) -> Figure:
    """Return over speed the friction that was told, and what of the measured torque nothing else explains."""
    joint, curves = found.joints[j], found.curves
    speed, told = curves.speed[:, j], curves.friction[:, j]

    def draw(canvas: Canvas) -> None:
        axes = panel(canvas, 45, 195)
        dots(axes, speed, (curves.measured - curves.explained + curves.friction)[:, j], SERIES[0])
        if told.any():
            dots(axes, speed, told, BAD)
        axes.margins(0.06)
        zero_lines(axes)
        axes.set_title(f"[{joint.unit}] over speed [{'rad/s' if joint.unit == 'N m' else 'm/s'}]")

    size = number(float(np.abs(told).max()))
    alt = f"Torque over speed of {printable(joint.name)}; friction that was told reaches {size} {joint.unit}"
    return Figure(printable(joint.name), alt, plot(WIDE, 280, draw, f"friction {j}"))
