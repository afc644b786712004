"""RD501: an axis that is no direction."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import WITH_AXIS


def check(context: Context) -> Iterator[Fault]:
    for joint in context.view.joints:
        if joint.type in WITH_AXIS and joint.axis.values is not None and not any(joint.axis.values):
            yield Fault(
                at=joint.axis.span,
                subject=joint.subject,
                what="the axis is 0 0 0, which is no direction",
                remedy='write the direction in the joint frame, for example xyz="0 0 1"',
                measured=0.0,
                bound=1.0,
            )


RULE = Rule(
    code="RD501",
    name="zero-axis",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="The axis of a joint that moves is not zero.",
    explanation="""Readers divide by its length: the joint then turns about NaN, or not at all.""",
    bad=arm(f'<axis xyz="0 0 0"/>{LIMIT}'),
    good=arm(f'<axis xyz="0 0 1"/>{LIMIT}'),
    check=check,
)
