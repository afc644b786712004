"""RD509: friction that drives."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import numbers


def check(context: Context) -> Iterator[Fault]:
    for joint in context.view.joints:
        dynamics = joint.element.find("dynamics")
        for name in ("damping", "friction"):
            found = numbers(dynamics, name, 1)
            if found.value is not None and found.value < 0:
                yield Fault(
                    at=found.span,
                    subject=joint.subject,
                    what=f"the {name} is {found.value:g}, and feeds energy in",
                    remedy="write it without the sign",
                    measured=found.value,
                    bound=0.0,
                )


RULE = Rule(
    code="RD509",
    name="negative-friction",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="Damping and friction are not negative.",
    explanation="""Friction takes energy out of a joint. With a negative coefficient it speeds up by itself, and a
simulation diverges.""",
    bad=arm(f'<axis xyz="0 1 0"/>{LIMIT}<dynamics damping="-0.1"/>'),
    good=arm(f'<axis xyz="0 1 0"/>{LIMIT}<dynamics damping="0.1"/>'),
    check=check,
)
