"""RD109: a robot without links."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import one_link
from robodyn.checks.rule import Fault, Rule, Severity, Stage


def check(context: Context) -> Iterator[Fault]:
    if not context.view.links:
        what = "the robot has no links"
        yield Fault(at=context.view.root.span, what=what, remedy="add a <link>", measured=0, bound=1)


RULE = Rule(
    code="RD109",
    name="no-links",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="A robot has one link at least.",
    explanation="""Often a sign of a file that was written by a failed conversion, or of xacro macros that were never
called.""",
    bad='<robot name="part">\n</robot>\n',
    good=one_link(),
    check=check,
)
