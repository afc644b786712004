"""RD004: something of xacro that was not expanded."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import INERTIA, one_link
from robodyn.checks.rule import Fault, Rule, Severity, Stage


def check(context: Context) -> Iterator[Fault]:
    for found in context.reading.found("RD004"):
        yield Fault(at=found.at, what=found.what, remedy=found.remedy)


RULE = Rule(
    code="RD004",
    name="unexpanded-xacro",
    severity=Severity.E,
    stage=Stage.TEXT,
    summary="Nothing is left of xacro: no xacro: element, no ${...}, no $(...).",
    explanation="""A reader takes ${mass} for a text, not for a number, and drops the element that it stands in. Where
an element of xacro is left, links may be missing, and nothing else is checked.""",
    bad=one_link(f'<mass value="${{arm_mass}}"/>{INERTIA}'),
    good=one_link(f'<mass value="2"/>{INERTIA}'),
    check=check,
)
