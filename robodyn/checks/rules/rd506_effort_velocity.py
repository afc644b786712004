"""RD506: an effort or a velocity limit that says nothing."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage


def check(context: Context) -> Iterator[Fault]:
    limits = context.thresholds
    for joint in context.view.joints:
        if joint.limit is None or not joint.moves:
            continue
        for numbers, most in ((joint.limit.effort, limits.most_effort), (joint.limit.velocity, limits.most_velocity)):
            value = numbers.value
            if not numbers.given:
                what = f"<limit> has no {numbers.attribute}"
            elif value is None or 0 < value < most:
                continue
            else:
                what = f"{numbers.attribute} is {value:g}, " + (
                    "a stand-in that limits nothing" if value > 0 else "not positive"
                )
            yield Fault(
                at=numbers.span,
                subject=joint.subject,
                what=what,
                remedy="write what the drive can do",
                measured=value,
                bound=most if value is not None and value > 0 else 0.0,
            )


RULE = Rule(
    code="RD506",
    name="effort-velocity",
    severity=Severity.W,
    stage=Stage.DOCUMENT,
    summary="Effort and velocity limits are positive and those of a machine.",
    explanation="""URDF asks for both. A limit of 0 makes a joint that some simulators can never move, and that others
do not limit; 1e9 is a stand-in that nothing can be sized against.""",
    bad=arm('<axis xyz="0 1 0"/>' + LIMIT.replace('effort="30"', 'effort="0"')),
    good=arm(f'<axis xyz="0 1 0"/>{LIMIT}'),
    check=check,
)
