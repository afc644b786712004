"""Error against time, both on logarithmic axes: every method as a point, those worth their time on a line."""

from __future__ import annotations

from io import BytesIO
from math import floor, log10
from typing import TYPE_CHECKING, Any

from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import SERIES, plot
from robodyn.report.table import printable

if TYPE_CHECKING:
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure as Canvas

_UNITS = {"mesh": (1e3, "ms"), "motion": (1e3, "ms"), "sample": (1e9, "ns per sample")}
_MARKERS = "osD^v<>Ph*Xd"
_NO_ERROR = 1e-16
"""The least error of a ladder without any, for the scale."""


def accuracy_picture(accuracy: Accuracy, target: float | None, form: str) -> bytes:
    """Return the content of a file with all ladders: form svg, png or pdf; letters of an SVG stay letters."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(9.0, 5.0 * len(accuracy.ladders)), layout="constrained")
    panels = figure.subplots(len(accuracy.ladders), 1, squeeze=False)[:, 0]
    for panel, ladder in zip(panels, accuracy.ladders, strict=True):
        draw_ladder(panel, ladder, target)
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")
        panel.set_title(f"{printable(accuracy.name)}: {ladder.title}", loc="left")
    stream, dated = BytesIO(), {"svg": "Date", "pdf": "CreationDate"}.get(form)
    with rc_context({"svg.hashsalt": "robodyn", "svg.fonttype": "none"}):
        figure.savefig(stream, format=form, dpi=150.0, metadata={dated: None} if dated else None)
    return stream.getvalue()


def ladder_figure(ladder: Ladder, target: float | None, words: str, name: str) -> Figure:
    """Return a ladder for a page."""

    def draw(canvas: Canvas) -> None:
        from matplotlib import rc_context
        from matplotlib.rcsetup import cycler

        canvas.set_layout_engine("constrained")
        with rc_context({"axes.prop_cycle": cycler(color=SERIES)}):
            draw_ladder(canvas.subplots(), ladder, target)
        canvas.legend(loc="outside lower left", ncols=2, fontsize="small")

    alt = f"Error against time of {len(ladder.rungs)} methods, on logarithmic axes; {words}"
    return Figure(ladder.title, alt, plot(400, 500, draw, name))


def draw_ladder(panel: Any, ladder: Ladder, target: float | None = None) -> None:
    """Draw a ladder; bars are quartiles of the time, a dashed line is the target.

    An error of 0 is drawn two decades below every other.
    """
    scale, unit = _UNITS[ladder.per]
    errors = [rung.error for rung in ladder.rungs]
    others = [error for error in (*errors, target) if error]
    zero = None if all(errors) else 10.0 ** (floor(log10(min(others, default=_NO_ERROR))) - 2)
    families: dict[str, list[Rung]] = {}
    for rung in ladder.rungs:  # one method with several settings, behind a comma, has one colour
        families.setdefault(rung.name.partition(",")[0], []).append(rung)
    for k, (family, rungs) in enumerate(families.items()):
        times = [scale * rung.time.median for rung in rungs]
        below = [scale * (rung.time.median - rung.time.low) for rung in rungs]
        above = [scale * (rung.time.high - rung.time.median) for rung in rungs]
        heights, marker = [rung.error or zero for rung in rungs], _MARKERS[k // 10 % len(_MARKERS)]
        panel.errorbar(times, heights, xerr=[below, above], fmt=marker, ms=5, lw=1, label=family)
    ink = panel.spines["left"].get_edgecolor()
    line = [scale * rung.time.median for rung in ladder.front], [rung.error or zero for rung in ladder.front]
    panel.plot(*line, color=ink, lw=1.2, zorder=0, label="front")
    if target is not None:
        panel.axhline(target, color=ink, lw=1, ls="--", label=f"target {target:g}")
    across = f"time [{unit}], median and quartiles\nerrors against {ladder.reference}"
    panel.set(xscale="log", yscale="log", xlabel=across, ylabel="largest error")
    panel.margins(x=0.04)
    _log_axis(panel.xaxis, None)
    _log_axis(panel.yaxis, zero)
    panel.grid(visible=True, which="major", alpha=0.3)


def _log_axis(axis: Axis, zero: float | None) -> None:
    """Label a logarithmic axis, whose limits are set, with plain numbers, and with 0 where that is drawn."""
    from matplotlib.ticker import LogLocator, NullLocator

    low, high = (float(x) for x in axis.get_view_interval())
    least = low if zero is None else 30.0 * zero
    locator = LogLocator(subs=(1.0, 2.0, 5.0) if high < 1e3 * least else (1.0,), numticks=9)
    ticks = [float(x) for x in locator.tick_values(least, max(high, 2.0 * least)) if least <= x <= high]
    marked = {**({} if zero is None else {zero: "0"}), **{x: f"{x:.5g}".replace("-", "\u2212") for x in ticks}}
    axis.set_ticks(list(marked), list(marked.values()))
    axis.set_minor_locator(NullLocator())
