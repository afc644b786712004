"""RD902: dynamics that differ from those of an earlier version of the file."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from typing import TYPE_CHECKING

from robodyn.checks.context import Context
from robodyn.checks.examples import arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import Subject
from robodyn.robot.urdf.source_positions import Span

if TYPE_CHECKING:
    from robodyn.checks.regression import Change


def check(context: Context) -> Iterator[Fault]:
    """Silent unless a revision is asked for."""
    against = context.asked.against
    if against is None:
        return
    from robodyn.checks.regression import changes, model_at

    before = model_at(context.reading.file, against)
    if before is None:
        return
    for change in changes(before, context.model):
        yield Fault(
            at=_place(context, change),
            subject=Subject(change.kind, change.name),
            what=f"{change.what}, against {against}",
            remedy="see that the change is meant",
            measured=change.size if isfinite(change.size) else None,
        )


def _place(context: Context, change: Change) -> Span:
    if change.kind == "joint" and change.name in context.view.joint:
        return context.view.joint[change.name].name_span
    if change.kind == "link" and change.name in context.view.link:
        return context.view.link[change.name].name_span
    return context.view.root.span


RULE = Rule(
    code="RD902",
    name="regression",
    severity=Severity.W,
    stage=Stage.MODEL,
    summary="The dynamics are those of the earlier version.",
    explanation="""With --against REF, the robot is compared with what git has of the same file at that revision:
joints that come, go, move or change their order, types, axes, limits and friction; masses, centres of mass and
inertias of the moving bodies, with everything fixed to them; and the torques of both in random states, in percent of
the largest. Moving a fixed frame, renaming a fixed joint or splitting a link changes nothing here. The examples are
two versions of a file: the bad one is compared with the good one.""",
    bad=arm().replace('mass value="2"', 'mass value="2.2"'),
    good=arm(),
    check=check,
)
