"""`accuracy`: what each method costs and how wrong it is, in words and pictures; `doctor`: what works here."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from math import floor, log10
from pathlib import PurePath

import numpy as np

from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung, Spread
from robodyn.measure.doctor import Line, healthy
from robodyn.report import document as doc
from robodyn.report.charts import plane_chart
from robodyn.report.table import printable
from robodyn.support.floats import Floats

_UNITS = {"mesh": (1e3, "ms"), "motion": (1e3, "ms"), "sample": (1e9, "ns")}
_WHERE = {"end": "error at the end", "way": "along the way", "middle": "error in the middle", "whole": "anywhere"}


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
        yield [doc.Table(title, head, rows), *doc.paragraphs([] if target is None else [_answer(ladder, target)])]
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
    verdict = doc.Verdict("neutral", "Methods that are worth their time", tuple(map(_front, accuracy.ladders)))
    if target is not None:
        met = all(ladder.cheapest(target) for ladder in accuracy.ladders)
        headline = f"The target of {target:g} {'is met' if met else 'is not met by every task'}"
        reasons = tuple(f"{ladder.title}: {_answer(ladder, target)}." for ladder in accuracy.ladders)
        verdict = doc.Verdict("good" if met else "bad", headline, reasons)
    blocks: list[doc.Block] = [verdict]
    if pictures:
        blocks += doc.titled("Error against time", [_ladder_chart(ladder, target) for ladder in accuracy.ladders])
    files = [("accuracy.json", accuracy_json(accuracy, target))]
    name, what = PurePath(accuracy.name).name, "What each further digit costs in time"
    how = "robodyn accuracy --format json prints it"
    return doc.page(name, what, blocks, accuracy_sections(accuracy, target), "", files, how)


def _answer(ladder: Ladder, target: float) -> str:
    if found := ladder.cheapest(target):
        return f"cheapest within {target:g}: {found.name}, with an error of {error_text(found.error)}"
    return f"no method reaches {target:g}; the best error is {error_text(min(rung.error for rung in ladder.rungs))}"


def _ladder_chart(ladder: Ladder, target: float | None) -> doc.Chart:
    """Return error against time: every setting of a method a dot, those worth it on a line; an error of 0 two decades
    below every other."""
    scale, unit = _UNITS[ladder.per]
    unit += " per sample" if ladder.per == "sample" else ""
    others = [error for error in (*(rung.error for rung in ladder.rungs), target) if error]
    zero = 10.0 ** (floor(log10(min(others, default=1e-16))) - 2)
    families: dict[str, list[Rung]] = {}
    for rung in ladder.rungs:  # one method with several settings, behind a comma, has one colour
        families.setdefault(rung.name.partition(",")[0], []).append(rung)

    def places(rungs: Sequence[Rung]) -> tuple[Floats, Floats]:
        return np.array([scale * rung.time.median for rung in rungs]), np.array([rung.error or zero for rung in rungs])

    lines = {"front": places(ladder.front)}
    if target is not None:
        times = places(ladder.rungs)[0]
        lines[f"target {target:g}"] = np.array((times.min(), times.max())), np.array((target, target))
    exact = "" if all(rung.error for rung in ladder.rungs) else f"; errors of 0 stand at {zero:.0e}"
    said = {
        name: [f"{rung.name}, quartiles {_time(rung.time, scale)[1]} {unit}" for rung in rungs]
        for name, rungs in families.items()
    }
    return plane_chart(
        f"{ladder.title}: largest error, against {ladder.reference}, over the median time{exact}",
        f"Error against time of {len(ladder.rungs)} methods, on logarithmic axes; {_front(ladder)}",
        f"time [{unit}]",
        "largest error",
        dots={name: places(rungs) for name, rungs in families.items()},
        lines=lines,
        colours={"front": "ink", f"target {target or 0:g}": "bad"},
        names=said,
        log=True,
    )


def _front(ladder: Ladder) -> str:
    first, last = ladder.front[0], ladder.front[-1]
    least, most, times = error_text(last.error), error_text(first.error), last.time.median / first.time.median
    way = f" to {last.name}, with {least} in {times:.3g} times the time" if first is not last else " alone"
    return f"{ladder.title}: from {first.name}, with an error of {most},{way}."


def doctor_sections(lines: tuple[Line, ...]) -> Iterator[doc.Section]:
    """Yield a line each with its verdict, group by group, and a sentence on the whole."""
    wide = max(len(line.name) for line in lines)
    for name, group in groupby(lines, key=lambda line: line.group):
        rows = [name]
        for line in group:
            said = ": ".join(text for text in (line.found, line.remark) if text)
            rows.append(f"  {line.name:<{wide}}  {line.verdict:<7}  {said}".rstrip())
        yield doc.paragraphs(rows)
    broken = ", ".join(line.name for line in lines if line.verdict == "broken")
    missing = ", ".join(line.name for line in lines if line.verdict == "missing")
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
