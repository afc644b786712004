"""RD106: two joints of one name."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import a_joint, a_link, arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage


def check(context: Context) -> Iterator[Fault]:
    view = context.view
    for part in view.joints:
        first = view.joint.get(part.name, part)
        if first is not part:
            yield Fault(
                at=part.name_span,
                subject=part.subject,
                what=f"a second joint of this name; the first is in line {first.element.line}",
                remedy="rename or remove one of them",
            )


RULE = Rule(
    code="RD106",
    name="duplicate-joint",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="No two joints have the same name.",
    explanation="""Readers refuse the file, or keep one of the two and lose the other without a word.""",
    bad=arm(more=a_link("fore") + a_joint("shoulder", "upper", "fore")),
    good=arm(more=a_link("fore") + a_joint("elbow", "upper", "fore")),
    check=check,
)
