"""RD008: a comment that is meant as a waiver and is none."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import one_link
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.waivers import waivers

_IDENTITY = '<mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'


def check(context: Context) -> Iterator[Fault]:
    for waiver in context.once(waivers):
        if not waiver.in_force(context.codes):
            what, remedy = waiver.problem(context.codes)
            yield Fault(at=waiver.at, what=what, remedy=remedy)


RULE = Rule(
    code="RD008",
    name="waiver-not-in-force",
    severity=Severity.W,
    stage=Stage.DOCUMENT,
    summary="A waiver names rules that exist, and says why.",
    explanation="""A comment `<!-- robodyn: allow RD208 no tensor is published, see issue 52 -->` above an element, or
behind it on its line, allows the finding there. Without a reason nobody can tell later whether it still holds, so a
waiver without one is not in force; nor is one with a code that no rule has, or a comment that begins with `robodyn:`
and goes on in another way.""",
    bad=one_link(f"<!-- robodyn: allow RD208 -->{_IDENTITY}"),
    good=one_link(f"{_IDENTITY} <!-- robodyn: allow RD208 a test weight, its tensor does not matter -->"),
    check=check,
)
