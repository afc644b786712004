"""The dynamics are those of the earlier version.

With --against REF, the robot is compared with what git has of the same file at that revision:
joints that come, go, move or change their order, types, axes, limits and friction; masses, centres of mass and
inertias of the moving bodies, with everything fixed to them; and the torques of both in random states, in percent of
the largest. Moving a fixed frame, renaming a fixed joint or splitting a link changes nothing here. The examples are
two versions of a file: the bad one is compared with the good one.
"""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.elements import Span
from robodyn.robot.urdf.view import Subject

if TYPE_CHECKING:
    from robodyn.checks.compare.regression import Change


@rule(Severity.WARNING, Stage.MODEL, good=arm(), bad=('value="2"', 'value="2.2"'))
def check(context: Context) -> Faults:
    """Silent unless a revision is asked for."""
    against = context.asked.against
    if against is None:
        return
    from robodyn.checks.compare.regression import changes, model_at

    before = model_at(context.reading.file, against)
    if before is None:
        return
    for change in changes(before, context.model):
        subject, measured = Subject(change.kind, change.name), change.size if isfinite(change.size) else None
        what = f"{change.what}, against {against}"
        yield Fault(_place(context, change), what, "see that the change is meant", measured, subject=subject)


def _place(context: Context, change: Change) -> Span:
    if change.kind == "joint" and change.name in context.view.joint:
        return context.view.joint[change.name].name_span
    if change.kind == "link" and change.name in context.view.link:
        return context.view.link[change.name].name_span
    return context.view.root.span
