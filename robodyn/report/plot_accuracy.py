"""Error against time, both on logarithmic axes: every method as a point, those worth their time on a line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robodyn.accuracy.ladder import Accuracy, Ladder, Rung
from robodyn.report.plotting import new_figure
from robodyn.report.table import printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_UNITS = {"mesh": (1e3, "ms"), "motion": (1e3, "ms"), "sample": (1e9, "ns per sample")}
_MARKERS = "osD^v<>Ph*Xd"
LEAST = 1e-17
"""Where an error of zero is drawn."""


def accuracy_figure(accuracy: Accuracy, target: float | None = None) -> Figure:
    """A figure for a file, in inches."""
    figure = new_figure(9.0, 5.0 * len(accuracy.ladders))
    draw_accuracy(figure, accuracy, target)
    return figure


def draw_accuracy(figure: Figure, accuracy: Accuracy, target: float | None = None) -> None:
    """A panel for each ladder; bars are quartiles of the time, a dashed line is the target."""
    panels = figure.subplots(len(accuracy.ladders), 1, squeeze=False)[:, 0]
    for panel, ladder in zip(panels, accuracy.ladders, strict=True):
        _draw(panel, ladder, target)
        panel.set_title(f"{printable(accuracy.name)}: {ladder.title}", loc="left")


def _draw(panel: Any, ladder: Ladder, target: float | None) -> None:
    scale, unit = _UNITS[ladder.per]
    best = ladder.front
    for k, (family, rungs) in enumerate(_families(ladder.rungs).items()):
        times = [scale * rung.time.median for rung in rungs]
        spread = [
            [scale * (rung.time.median - rung.time.low) for rung in rungs],
            [scale * (rung.time.high - rung.time.median) for rung in rungs],
        ]
        marker = _MARKERS[k // 10 % len(_MARKERS)]
        panel.errorbar(times, list(map(_shown, rungs)), xerr=spread, fmt=marker, ms=5, lw=1, label=family)
    ink = panel.spines["left"].get_edgecolor()
    line = [scale * rung.time.median for rung in best], list(map(_shown, best))
    panel.plot(*line, color=ink, lw=1.2, zorder=0, label="front")
    if target is not None:
        panel.axhline(target, color=ink, lw=1, ls="--", label=f"target {target:g}")
    panel.set(xscale="log", yscale="log", xlabel=f"time [{unit}], median and quartiles", ylabel="largest error")
    panel.grid(visible=True, which="major", alpha=0.3)
    panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")
    panel.text(0.0, -0.14, f"errors against {ladder.reference}", transform=panel.transAxes, fontsize="x-small")


def _families(rungs: tuple[Rung, ...]) -> dict[str, list[Rung]]:
    """Rungs by what stands before the comma of their names: one method with several settings has one colour."""
    found: dict[str, list[Rung]] = {}
    for rung in rungs:
        found.setdefault(rung.name.partition(",")[0], []).append(rung)
    return found


def _shown(rung: Rung) -> float:
    return max(rung.error, LEAST)
