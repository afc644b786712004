"""What accuracy costs, as text for a person."""

from __future__ import annotations

from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Price, Rung
from robodyn.measure.timing import Spread
from robodyn.report.table import PLAIN, Page, printable

_UNITS = {"mesh": (1e3, "ms"), "motion": (1e3, "ms"), "sample": (1e9, "ns")}
_WHERE = {"end": "error at the end", "way": "along the way", "middle": "error in the middle", "whole": "anywhere"}


def accuracy_text(accuracy: Accuracy, target: float | None = None, page: Page = PLAIN) -> str:
    """Errors, times and operations of every method, the front of those worth their time, and prices beside it.

    Args:
        target: the error for which the quickest method is named.
    """
    parts = [_ladder(accuracy.name, ladder, target, page) for ladder in accuracy.ladders]
    if accuracy.prices:
        parts.append("Beside it\n" + page.table((("what", "time [ms]", "quartiles [ms]"), _prices(accuracy.prices))))
    if accuracy.effects:
        head = ("without", "torque lost, at most", "at", "operations saved")
        rows = [
            (effect.name, f"{effect.torque:#.4g} {effect.unit}", effect.joint, str(effect.saved))
            for effect in accuracy.effects
        ]
        parts.append("Effects\n" + page.table((head, rows)))
    parts += ["".join(f"{printable(note)}\n" for note in accuracy.notes)] if accuracy.notes else []
    return "\n".join(parts)


def _ladder(name: str, ladder: Ladder, target: float | None, page: Page) -> str:
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
            _verdict(ladder, rung),
        )
        for rung in sorted(ladder.rungs, key=lambda rung: rung.time.median)
    ]
    title = f"{printable(name)}: {ladder.title}{per}, errors against {ladder.reference}\n"
    return title + page.table((head, rows)) + ("" if target is None else _answer(ladder, target))


def _answer(ladder: Ladder, target: float) -> str:
    found = ladder.cheapest(target)
    if found is None:
        best = min(rung.error for rung in ladder.rungs)
        return f"no method reaches {target:g}; the best error is {error_text(best)}\n"
    return f"cheapest within {target:g}: {found.name}\n"


def _verdict(ladder: Ladder, rung: Rung) -> str:
    other = ladder.dominator(rung)
    return "front" if other is None else f"dominated by {other.name}"


def _prices(prices: tuple[Price, ...]) -> list[tuple[str, ...]]:
    return [(price.name, *_time(price.time, 1e3)) for price in prices]


def _time(time: Spread, scale: float) -> tuple[str, str]:
    return _digits(scale * time.median), f"{_digits(scale * time.low)} .. {_digits(scale * time.high)}"


def _count(number: float | None) -> str:
    return "-" if number is None else f"{number:.0f}" if number < 1e7 else f"{number:.2e}"


def _digits(x: float) -> str:
    return f"{x:.0f}" if x >= 99.95 else f"{x:#.3g}"


def error_text(error: float) -> str:
    """Two digits; 0 for none."""
    return f"{error:.1e}" if error else "0"
