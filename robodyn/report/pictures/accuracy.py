"""Error against time, both on logarithmic axes: every method as a point, those worth their time on a line."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, log10
from typing import TYPE_CHECKING, Any

from robodyn.errors import InputError
from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung
from robodyn.report.pictures.figures import log_axis
from robodyn.report.table import printable
from robodyn.support.extras import need
from robodyn.support.wording import alternatives

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMS = "svg", "png", "pdf"
_UNITS = {"mesh": (1e3, "ms"), "motion": (1e3, "ms"), "sample": (1e9, "ns per sample")}
_MARKERS = "osD^v<>Ph*Xd"
_NO_ERROR = 1e-16
"""The least error of a ladder without any, for the scale."""


def accuracy_figure(accuracy: Accuracy, target: float | None = None) -> Figure:
    """Return a figure for a file, in inches."""
    figure = new_figure(9.0, 5.0 * len(accuracy.ladders))
    panels = figure.subplots(len(accuracy.ladders), 1, squeeze=False)[:, 0]
    for panel, ladder in zip(panels, accuracy.ladders, strict=True):
        draw_ladder(panel, ladder, target)
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")
        panel.set_title(f"{printable(accuracy.name)}: {ladder.title}", loc="left")
    return figure


def draw_ladder(panel: Any, ladder: Ladder, target: float | None = None) -> None:
    """Draw a ladder; bars are quartiles of the time, a dashed line is the target."""
    scale, unit = _UNITS[ladder.per]
    best, zero = ladder.front, _zero(ladder.rungs, target)
    for k, (family, rungs) in enumerate(_families(ladder.rungs).items()):
        times = [scale * rung.time.median for rung in rungs]
        spread = [
            [scale * (rung.time.median - rung.time.low) for rung in rungs],
            [scale * (rung.time.high - rung.time.median) for rung in rungs],
        ]
        marker = _MARKERS[k // 10 % len(_MARKERS)]
        panel.errorbar(times, _heights(rungs, zero), xerr=spread, fmt=marker, ms=5, lw=1, label=family)
    ink = panel.spines["left"].get_edgecolor()
    line = [scale * rung.time.median for rung in best], _heights(best, zero)
    panel.plot(*line, color=ink, lw=1.2, zorder=0, label="front")
    if target is not None:
        panel.axhline(target, color=ink, lw=1, ls="--", label=f"target {target:g}")
    across = f"time [{unit}], median and quartiles\nerrors against {ladder.reference}"
    panel.set(xscale="log", yscale="log", xlabel=across, ylabel="largest error")
    panel.margins(x=0.04)
    log_axis(panel.xaxis)
    log_axis(panel.yaxis, zero=zero)
    panel.grid(visible=True, which="major", alpha=0.3)


def _families(rungs: tuple[Rung, ...]) -> dict[str, list[Rung]]:
    """Return rungs by what stands before the comma of their names: one method with several settings has one colour."""
    found: dict[str, list[Rung]] = {}
    for rung in rungs:
        found.setdefault(rung.name.partition(",")[0], []).append(rung)
    return found


def _zero(rungs: Sequence[Rung], target: float | None) -> float | None:
    """Return where an error of 0 is drawn: two decades below every other; None where no error is 0."""
    errors = [rung.error for rung in rungs]
    if all(errors):
        return None
    others = [error for error in (*errors, target) if error]
    return 10.0 ** (floor(log10(min(others, default=_NO_ERROR))) - 2)


def _heights(rungs: Sequence[Rung], zero: float | None) -> list[float]:
    """Return where the errors of rungs are drawn."""
    return [rung.error or zero or _NO_ERROR for rung in rungs]


def form_of(path: str) -> str:
    """Return the form of a picture by the suffix of its file.

    Raises:
        InputError: there is none such.
    """
    suffix = path.rpartition(".")[2].lower() if "." in path else ""
    if suffix not in FORMS:
        raise InputError("unknown type of picture by this suffix", remedy="name it .svg, .png or .pdf", file=path)
    return suffix


def new_figure(width: float = 8.0, height: float = 5.0) -> Figure:
    """Return an empty figure, in inches.

    Raises:
        InputError: matplotlib is not installed.
    """
    need("plots", "matplotlib")
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def rendered(figure: Figure, form: str = "svg", dpi: float = 150.0) -> bytes:
    """Return the picture as the content of a file; letters of an SVG stay letters."""
    from io import BytesIO

    import matplotlib as mpl

    if form not in FORMS:
        raise InputError(f"no picture is made as {form!r}", remedy=alternatives(form, FORMS, "forms"))
    stream = BytesIO()
    undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": None}[form]
    with mpl.rc_context({"svg.hashsalt": "robodyn", "svg.fonttype": "none"}):
        figure.savefig(stream, format=form, dpi=dpi, metadata=undated)
    return stream.getvalue()
