"""RD007: what should be a number is none."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import INERTIA, one_link
from robodyn.checks.grammar import own_elements
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import numbers


def check(context: Context) -> Iterator[Fault]:
    for element, kind, subject in own_elements(context.view.root):
        for name, count in kind.attributes.items():
            if not count:
                continue
            found = numbers(element, name, count)
            if found.problem is not None:
                what = f"{name} of <{element.tag}> {found.problem}"
                yield Fault(at=found.span, subject=subject, what=what, remedy=found.problem.remedy)
            elif not found.given and name in kind.needed:
                what = f"<{element.tag}> has no attribute '{name}'"
                yield Fault(at=found.span, subject=subject, what=what, remedy=f'write {name}="..."')


RULE = Rule(
    code="RD007",
    name="bad-number",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="Numbers are finite, decimal, no larger than 1e30, and as many as the attribute holds.",
    explanation="""NaN and infinity, decimal commas, units, and too few or too many numbers. urdfdom then drops the
whole element, an <inertial> for example, and reports success; other readers take a part of the text.""",
    bad=one_link(f'<origin xyz="0 0,1 0"/><mass value="2"/>{INERTIA}'),
    good=one_link(f'<origin xyz="0 0.1 0"/><mass value="2"/>{INERTIA}'),
    check=check,
)
