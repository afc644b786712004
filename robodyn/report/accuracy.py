"""`accuracy`: what each method costs and how wrong it is; `doctor`: whether robodyn can work here."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from pathlib import PurePath
from typing import Any

from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung, Spread
from robodyn.measure.doctor import Line, healthy
from robodyn.report import document as doc
from robodyn.report.table import printable

_UNITS = {"mesh": (1e3, "ms"), "motion": (1e3, "ms"), "sample": (1e9, "ns")}
_WHERE = {"end": "error at the end", "way": "along the way", "middle": "error in the middle", "whole": "anywhere"}


def accuracy_sections(accuracy: Accuracy, target: float | None = None) -> Iterator[doc.Section]:
    """Yield errors, times and operations of every method, the front of those worth their time, and prices beside it.

    Args:
        target: the error for which the quickest method is named.
    """
    for ladder in accuracy.ladders:
        answer = []
        if target is not None:
            best, found = error_text(min(rung.error for rung in ladder.rungs)), ladder.cheapest(target)
            none = f"no method reaches {target:g}; the best error is {best}"
            answer.append(f"cheapest within {target:g}: {found.name}" if found else none)
        yield [_ladder(accuracy.name, ladder), *doc.paragraphs(answer)]
    if accuracy.prices:
        prices = [(price.name, *_time(price.time, 1e3)) for price in accuracy.prices]
        yield [doc.Table("Beside it", ("what", "time [ms]", "quartiles [ms]"), prices)]
    if accuracy.effects:
        head = ("without", "torque lost, at most", "at", "operations saved")
        rows = [
            (effect.name, f"{effect.torque:#.4g} {effect.unit}", effect.joint, str(effect.saved))
            for effect in accuracy.effects
        ]
        yield [doc.Table("Effects", head, rows)]
    yield doc.paragraphs(accuracy.notes)


def _ladder(name: str, ladder: Ladder) -> doc.Table:
    scale, unit = _UNITS[ladder.per]
    per = f" per {ladder.per}" if ladder.per == "sample" else ""
    errors = [_WHERE.get(measure, f"error of {measure}") for measure in ladder.measures]
    moves = any(rung.drift is not None for rung in ladder.rungs)
    more = ("energy drift", "evaluations") if moves else ()
    head = ("method", *errors, *more[:1], f"time [{unit}]", f"quartiles [{unit}]", *more[1:], "operations", "verdict")
    rows = [
        (
            rung.name,
            *map(error_text, rung.errors),
            *((error_text(rung.drift or 0.0),) if moves else ()),
            *_time(rung.time, scale),
            *((_count(rung.evaluations),) if moves else ()),
            _count(rung.operations),
            f"dominated by {other.name}" if (other := ladder.dominator(rung)) else "front",
        )
        for rung in sorted(ladder.rungs, key=lambda rung: rung.time.median)
    ]
    return doc.Table(f"{printable(name)}: {ladder.title}{per}, errors against {ladder.reference}", head, rows)


def _time(time: Spread, scale: float) -> tuple[str, str]:
    return _digits(scale * time.median), f"{_digits(scale * time.low)} .. {_digits(scale * time.high)}"


def _count(number: float | None) -> str:
    return "-" if number is None else f"{number:.0f}" if number < 1e7 else f"{number:.2e}"


def error_text(error: float) -> str:
    """Return an error with two digits; 0 for none."""
    return f"{error:.1e}" if error else "0"


def accuracy_page(accuracy: Accuracy, target: float | None = None, pictures: bool = True) -> doc.Document:
    """Return which method to take, error against time, and every method in numbers.

    Args:
        target: the error for which the quickest method is named.
    """
    blocks: list[doc.Block] = [_met(accuracy, target)]
    if pictures:
        from robodyn.report.pictures.accuracy import ladder_figure

        figures = (ladder_figure(each, target, _front(each), f"ladder {k}") for k, each in enumerate(accuracy.ladders))
        blocks += doc.titled("Error against time", doc.gallery(figures))
    files = [("accuracy.json", accuracy_json(accuracy, target))]
    name, what = PurePath(accuracy.name).name, "What each further digit costs in time"
    how = "robodyn accuracy --format json prints it"
    return doc.page(name, what, blocks, accuracy_sections(accuracy, target), "", files, how)


def _met(accuracy: Accuracy, target: float | None) -> doc.Verdict:
    """Return the quickest method within the target, or the ends of the front."""
    if target is None:
        return doc.Verdict("neutral", "Methods that are worth their time", tuple(map(_front, accuracy.ladders)))
    found = [(ladder, ladder.cheapest(target)) for ladder in accuracy.ladders]
    met = all(rung is not None for _, rung in found)
    headline = f"The target of {target:g} {'is met' if met else 'is not met by every task'}"
    reasons = []
    for ladder, rung in found:
        best = rung or min(ladder.rungs, key=lambda each: each.error)
        who = f"{best.name} has" if rung else f"no method reaches it; the best is {best.name} with"
        reasons.append(f"{ladder.title}: {who} an error of {error_text(best.error)}.")
    return doc.Verdict("good" if met else "bad", headline, tuple(reasons))


def _front(ladder: Ladder) -> str:
    first, last = ladder.front[0], ladder.front[-1]
    if first is last:
        return (
            f"{ladder.title}: {first.name} is quickest and most accurate, with an error of {error_text(first.error)}."
        )
    least, most, times = error_text(last.error), error_text(first.error), last.time.median / first.time.median
    return (
        f"{ladder.title}: from {first.name}, with an error of {most}, to {last.name}, with {least} in {times:.3g} "
        "times the time."
    )


def _digits(x: float) -> str:
    """Return a number with three digits, and all those before the point."""
    return f"{x:.0f}" if x >= 99.95 else f"{x:#.3g}"


def doctor_sections(lines: tuple[Line, ...]) -> Iterator[doc.Section]:
    """Yield a line each with its verdict, group by group, and a sentence on the whole."""
    wide = max(len(line.name) for line in lines)
    for name, group in groupby(lines, key=lambda line: line.group):
        found = [(line, ": ".join(text for text in (line.found, line.remark) if text)) for line in group]
        yield doc.paragraphs(
            [name, *(f"  {each.name:<{wide}}  {each.verdict:<7}  {said}".rstrip() for each, said in found)]
        )
    broken, missing = (
        ", ".join(line.name for line in lines if line.verdict == verdict) for verdict in ("broken", "missing")
    )
    end = "everything that is needed works" if healthy(lines) else f"to be repaired: {broken}"
    yield [doc.Paragraph(f"{end}; missing: {missing}" if missing else end)]


def accuracy_json(accuracy: Accuracy, target: float | None = None) -> str:
    """Return the document of `accuracy`; times [s] are the median, the quartiles `low` and `high`, and the `runs`."""
    ladders = []
    for ladder in accuracy.ladders:
        cheapest = None if target is None else ladder.cheapest(target)
        methods, front = [_rung_json(ladder, rung) for rung in ladder.rungs], [rung.name for rung in ladder.front]
        keys, best = "title reference per methods front cheapest", cheapest and cheapest.name
        ladders.append(doc.select(ladder, keys, methods=methods, front=front, cheapest=best))
    return doc.written(doc.select(accuracy, "name target ladders prices effects notes", target=target, ladders=ladders))


def _rung_json(ladder: Ladder, rung: Rung) -> dict[str, Any]:
    other = ladder.dominator(rung)
    errors = dict(zip(ladder.measures, rung.errors, strict=True))
    return {
        **doc.select(rung, "name errors error time operations", errors=errors),
        **({} if rung.drift is None else doc.select(rung, "evaluations drift")),
        "dominated_by": other and other.name,
    }


def doctor_json(lines: tuple[Line, ...]) -> str:
    """Return {"ok": ..., "lines": [{group, name, found, verdict, remark, figures}]}."""
    return doc.written({"ok": healthy(lines), "lines": lines})
