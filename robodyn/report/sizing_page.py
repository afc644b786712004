"""What motors, gears, bearings and the foundation bear, as a part of a report for people."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from robodyn.loads.history import Curves
from robodyn.loads.result import Result
from robodyn.report.document import Block, Gallery, Heading, Level, Table, Verdict
from robodyn.report.limits import offenders, offenders_first
from robodyn.report.sizing import in_words, sizing_sections
from robodyn.report.table import printable
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene

if TYPE_CHECKING:
    pass


def sizing_blocks(result: Result, model: Model, scene: Scene, curves: Curves | None) -> Iterator[Block]:
    """Yield a verdict if all is well (others lead the page), torque against speed at the shafts of motors, and tables.

    Args:
        curves: of the joints; None without figures.
    """
    sizing = result.sizing
    if sizing is None:
        return
    yield Heading("Motors, bearings, foundation")
    if not sizing.exceeded:
        yield sizing_verdict(result)
    if curves is not None:
        from robodyn.report.pictures.motors import motor_figures

        figures = dict(motor_figures(sizing, model, scene, curves))
        over = offenders(result)
        ordered = sorted(figures, key=lambda name: name not in over)
        if ordered:
            yield Gallery(tuple(figures[name] for name in ordered))
    for section in sizing_sections(offenders_first(result)):
        yield from (block for block in section if isinstance(block, Table))  # verdicts come first here


def sizing_verdict(result: Result) -> Verdict:
    """Return whether motors, gears and joints bear the motion; green only where all have limits, none in doubt."""
    sizing = result.sizing
    assert sizing is not None, "it is asked for"
    over = [joint for joint in sizing.joints if joint.exceeded]
    if not over:
        known = [joint for joint in sizing.joints if joint.level == "OK"]
        if not known:
            return Verdict("neutral", "No limits of motors and gears are known")
        clauses = ", ".join(doubt.clause for doubt in result.doubts)
        headline = f"{len(known)} of {len(sizing.joints)} joints have limits, and keep to them"
        sure: Level = "good" if len(known) == len(sizing.joints) else "neutral"
        return Verdict("doubtful" if clauses else sure, f"{headline} {clauses}".strip())
    level: Level = "bad" if any(joint.level == "over peak" for joint in over) else "doubtful"
    reasons = tuple(f"{printable(joint.name)}: {in_words(each)}." for joint in over for each in joint.exceeded)
    count = f"{len(over)} of {len(sizing.joints)} joints ask more than their motors, gears or limits bear"
    return Verdict(level, count if len(sizing.joints) > 1 else "The joint asks more than its drive bears", reasons)
