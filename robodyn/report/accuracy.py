"""`accuracy`: what each method costs and how wrong it is, in words and pictures; `doctor`: what works here."""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO
from itertools import groupby
from math import floor, log10
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung, Spread
from robodyn.measure.doctor import Line, healthy
from robodyn.report import document as doc
from robodyn.report.table import printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


_UNITS = {"mesh": (1e3, "ms"), "motion": (1e3, "ms"), "sample": (1e9, "ns")}
_WHERE = {"end": "error at the end", "way": "along the way", "middle": "error in the middle", "whole": "anywhere"}
_MARKERS = "osD^v<>Ph*Xd"


def accuracy_sections(accuracy: Accuracy, target: float | None = None) -> Iterator[doc.Section]:
    """Yield errors, times, operations and verdict of every method, the quickest within the target, prices beside it."""
    for ladder in accuracy.ladders:
        scale, unit = _UNITS[ladder.per]
        per = f" per {ladder.per}" if ladder.per == "sample" else ""
        errors = [_WHERE.get(measure, f"error of {measure}") for measure in ladder.measures]
        moves = any(rung.drift is not None for rung in ladder.rungs)
        head = ["method", *errors, *["energy drift"] * moves, f"time [{unit}]", f"quartiles [{unit}]"]
        head += [*["evaluations"] * moves, "operations", "verdict"]
        rows = []
        for rung in sorted(ladder.rungs, key=lambda rung: rung.time.median):
            other = ladder.dominator(rung)
            row = [rung.name, *map(error_text, rung.errors), *[error_text(rung.drift or 0.0)] * moves]
            row += [*_time(rung.time, scale), *[_count(rung.evaluations)] * moves, _count(rung.operations)]
            rows.append([*row, f"dominated by {other.name}" if other else "front"])
        title = f"{printable(accuracy.name)}: {ladder.title}{per}, errors against {ladder.reference}"
        answer = []
        if target is not None:
            best, found = error_text(min(rung.error for rung in ladder.rungs)), ladder.cheapest(target)
            none = f"no method reaches {target:g}; the best error is {best}"
            answer.append(f"cheapest within {target:g}: {found.name}" if found else none)
        yield [doc.Table(title, head, rows), *doc.paragraphs(answer)]
    if accuracy.prices:
        prices = [(price.name, *_time(price.time, 1e3)) for price in accuracy.prices]
        yield [doc.Table("Beside it", ("what", "time [ms]", "quartiles [ms]"), prices)]
    if accuracy.effects:
        head = ["without", "torque lost, at most", "at", "operations saved"]
        effects = [(x.name, f"{x.torque:#.4g} {x.unit}", x.joint, str(x.saved)) for x in accuracy.effects]
        yield [doc.Table("Effects", head, effects)]
    yield doc.paragraphs(accuracy.notes)


def _time(time: Spread, scale: float) -> tuple[str, str]:
    # three digits, and all those before the point
    scaled = (scale * x for x in (time.median, time.low, time.high))
    median, low, high = (f"{x:.0f}" if x >= 99.95 else f"{x:#.3g}" for x in scaled)
    return median, f"{low} .. {high}"


def _count(number: float | None) -> str:
    return "-" if number is None else f"{number:.0f}" if number < 1e7 else f"{number:.2e}"


def error_text(error: float) -> str:
    """Return an error with two digits; 0 for none."""
    return f"{error:.1e}" if error else "0"


def accuracy_page(accuracy: Accuracy, target: float | None = None, pictures: bool = True) -> doc.Document:
    """Return the quickest method within the target, error against time, and every method in numbers."""
    if target is None:
        words = tuple(map(_front, accuracy.ladders))
        verdict = doc.Verdict("neutral", "Methods that are worth their time", words)
    else:
        found = [(ladder, ladder.cheapest(target)) for ladder in accuracy.ladders]
        met = all(rung is not None for _, rung in found)
        reasons = []
        for ladder, rung in found:
            best = rung or min(ladder.rungs, key=lambda each: each.error)
            who = f"{best.name} has" if rung else f"no method reaches it; the best is {best.name} with"
            reasons.append(f"{ladder.title}: {who} an error of {error_text(best.error)}.")
        headline = f"The target of {target:g} {'is met' if met else 'is not met by every task'}"
        verdict = doc.Verdict("good" if met else "bad", headline, tuple(reasons))
    blocks: list[doc.Block] = [verdict]
    if pictures:
        figures = (ladder_figure(each, target, _front(each), f"ladder {k}") for k, each in enumerate(accuracy.ladders))
        blocks += doc.titled("Error against time", doc.gallery(figures))
    files = [("accuracy.json", accuracy_json(accuracy, target))]
    name, what = PurePath(accuracy.name).name, "What each further digit costs in time"
    how = "robodyn accuracy --format json prints it"
    return doc.page(name, what, blocks, accuracy_sections(accuracy, target), "", files, how)


def _front(ladder: Ladder) -> str:
    first, last = ladder.front[0], ladder.front[-1]
    if first is last:
        best = f"{first.name} is quickest and most accurate"
        return f"{ladder.title}: {best}, with an error of {error_text(first.error)}."
    least, most, times = error_text(last.error), error_text(first.error), last.time.median / first.time.median
    way = f"from {first.name}, with an error of {most}, to {last.name}, with {least}"
    return f"{ladder.title}: {way} in {times:.3g} times the time."


def doctor_sections(lines: tuple[Line, ...]) -> Iterator[doc.Section]:
    """Yield a line each with its verdict, group by group, and a sentence on the whole."""
    wide = max(len(line.name) for line in lines)
    for name, group in groupby(lines, key=lambda line: line.group):
        rows = [name]
        for line in group:
            said = ": ".join(text for text in (line.found, line.remark) if text)
            rows.append(f"  {line.name:<{wide}}  {line.verdict:<7}  {said}".rstrip())
        yield doc.paragraphs(rows)
    broken, missing = (
        ", ".join(line.name for line in lines if line.verdict == verdict) for verdict in ("broken", "missing")
    )
    end = "everything that is needed works" if healthy(lines) else f"to be repaired: {broken}"
    yield [doc.Paragraph(f"{end}; missing: {missing}" if missing else end)]


def accuracy_json(accuracy: Accuracy, target: float | None = None) -> str:
    """Return the document of `accuracy`; times [s] are the median, the quartiles `low` and `high`, and the `runs`."""
    ladders = []
    for ladder in accuracy.ladders:
        methods = []
        for rung in ladder.rungs:
            errors, other = dict(zip(ladder.measures, rung.errors, strict=True)), ladder.dominator(rung)
            method = doc.select(rung, "name errors error time operations", errors=errors)
            method |= {} if rung.drift is None else doc.select(rung, "evaluations drift")
            methods.append({**method, "dominated_by": other and other.name})
        cheapest = None if target is None else ladder.cheapest(target)
        keys, best = "title reference per methods front cheapest", cheapest and cheapest.name
        front = [rung.name for rung in ladder.front]
        ladders.append(doc.select(ladder, keys, methods=methods, front=front, cheapest=best))
    return doc.written(doc.select(accuracy, "name target ladders prices effects notes", target=target, ladders=ladders))


def doctor_json(lines: tuple[Line, ...]) -> str:
    """Return {"ok": ..., "lines": [{group, name, found, verdict, remark, figures}]}."""
    return doc.written({"ok": healthy(lines), "lines": lines})


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


def ladder_figure(ladder: Ladder, target: float | None, words: str, name: str) -> doc.Figure:
    from robodyn.report.pictures.figures import SERIES, plot

    def draw(canvas: Canvas) -> None:
        from matplotlib import rc_context
        from matplotlib.rcsetup import cycler

        canvas.set_layout_engine("constrained")
        with rc_context({"axes.prop_cycle": cycler(color=SERIES)}):
            draw_ladder(canvas.subplots(), ladder, target)
        canvas.legend(loc="outside lower left", ncols=2, fontsize="small")

    alt = f"Error against time of {len(ladder.rungs)} methods, on logarithmic axes; {words}"
    return doc.Figure(ladder.title, alt, plot(400, 500, draw, name))


def draw_ladder(panel: Any, ladder: Ladder, target: float | None = None) -> None:
    """Draw error against time on logarithmic axes: methods as points with quartiles of their time, those worth it on a
    line, the target dashed; an error of 0 two decades below every other."""
    from matplotlib.ticker import LogLocator, NullLocator

    scale, unit = _UNITS[ladder.per]
    unit += " per sample" if ladder.per == "sample" else ""
    errors = [rung.error for rung in ladder.rungs]
    others = [error for error in (*errors, target) if error]
    zero = None if all(errors) else 10.0 ** (floor(log10(min(others, default=1e-16))) - 2)
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
    for axis, zero_at in ((panel.xaxis, None), (panel.yaxis, zero)):  # plain numbers, and 0 where that is drawn
        low, high = (float(x) for x in axis.get_view_interval())
        least = low if zero_at is None else 30.0 * zero_at
        locator = LogLocator(subs=(1.0, 2.0, 5.0) if high < 1e3 * least else (1.0,), numticks=9)
        ticks = [float(x) for x in locator.tick_values(least, max(high, 2.0 * least)) if least <= x <= high]
        marked = {zero_at: "0"} if zero_at is not None else {}
        marked |= {x: f"{x:.5g}".replace("-", "\u2212") for x in ticks}
        axis.set_ticks(list(marked), list(marked.values()))
        axis.set_minor_locator(NullLocator())
    panel.grid(visible=True, which="major", alpha=0.3)
