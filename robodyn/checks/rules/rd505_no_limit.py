"""RD505: a joint without limits that needs them."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import WITH_RANGE


def check(context: Context) -> Iterator[Fault]:
    for joint in context.view.joints:
        if joint.type in WITH_RANGE and joint.limit is None:
            remedy = 'add <limit lower="..." upper="..." effort="..." velocity="..."/>'
            if joint.type == "revolute":
                remedy += ", or make it continuous"
            yield Fault(
                at=joint.name_span, subject=joint.subject, what=f"a {joint.type} joint without <limit>", remedy=remedy
            )


RULE = Rule(
    code="RD505",
    name="no-limit",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="Revolute and prismatic joints have a <limit>.",
    explanation="""URDF asks for it, and urdfdom refuses the robot.""",
    bad=arm('<axis xyz="0 1 0"/>'),
    good=arm(f'<axis xyz="0 1 0"/>{LIMIT}'),
    check=check,
)
