"""What accuracy costs, as a report for people."""

from __future__ import annotations

from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING

from robodyn.measure.accuracy.ladder import Accuracy, Ladder
from robodyn.report.document import Block, Document, Download, Figure, Gallery, Heading, Verdict, downloads
from robodyn.report.json_accuracy import accuracy_json
from robodyn.report.text_accuracy import accuracy_text, error_text
from robodyn.report.text_blocks import blocks_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


def accuracy_page(accuracy: Accuracy, target: float | None = None, pictures: bool = True) -> Document:
    """Which method to take, error against time, and every method in numbers.

    Args:
        target: the error for which the quickest method is named.
    """
    blocks: list[Block] = [_verdict(accuracy, target)]
    if pictures:
        blocks += [Heading("Error against time"), Gallery(tuple(_figure(accuracy, k, target) for k in _all(accuracy)))]
    blocks += [Heading("Methods"), *blocks_of(lambda page: accuracy_text(accuracy, target, page))]
    files = [Download("accuracy.json", "application/json", accuracy_json(accuracy, target))]
    blocks += [Heading("Data"), downloads(files, "robodyn accuracy --format json prints it")]
    return Document(PurePath(accuracy.name).name, "What each further digit costs in time", tuple(blocks))


def _all(accuracy: Accuracy) -> range:
    return range(len(accuracy.ladders))


def _verdict(accuracy: Accuracy, target: float | None) -> Verdict:
    """The quickest method within the target, or the ends of the front."""
    if target is None:
        return Verdict("neutral", "Methods that are worth their time", tuple(map(_front, accuracy.ladders)))
    found = [(ladder, ladder.cheapest(target)) for ladder in accuracy.ladders]
    met = all(rung is not None for _, rung in found)
    headline = f"The target of {target:g} {'is met' if met else 'is not met by every task'}"
    reasons = [
        f"{ladder.title}: {f'{rung.name} has an error of {error_text(rung.error)}' if rung else _best(ladder)}."
        for ladder, rung in found
    ]
    return Verdict("good" if met else "bad", headline, tuple(reasons))


def _best(ladder: Ladder) -> str:
    best = min(ladder.rungs, key=lambda rung: rung.error)
    return f"no method reaches it; the best is {best.name} with an error of {error_text(best.error)}"


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


def _figure(accuracy: Accuracy, k: int, target: float | None) -> Figure:
    from matplotlib import rc_context
    from matplotlib.rcsetup import cycler

    from robodyn.report.figures import SERIES, plot
    from robodyn.report.plot_accuracy import draw_accuracy

    ladder = accuracy.ladders[k]

    def draw(canvas: Canvas) -> None:
        canvas.set_layout_engine("constrained")
        with rc_context({"axes.prop_cycle": cycler(color=SERIES)}):
            draw_accuracy(canvas, replace(accuracy, ladders=(ladder,)), target)
        (axes,) = canvas.axes
        axes.set_title("")
        beside = axes.get_legend()
        assert beside is not None
        beside.remove()
        canvas.legend(loc="outside lower left", ncols=2, fontsize="small")

    words = f"Error against time of {len(ladder.rungs)} methods, on logarithmic axes; {_front(ladder)}"
    return Figure(ladder.title, words, plot(400, 500, draw, f"ladder {k}"))
