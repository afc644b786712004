"""RD510: a joint that mimics none of the robot's."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import LIMIT, a_joint, a_link, arm
from robodyn.checks.reading import unexpanded
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import value_span
from robodyn.support.wording import alternatives, shown

_FOLLOWER = f'<axis xyz="0 1 0"/>{LIMIT}<mimic joint="shoulder" multiplier="0.5"/>'


def check(context: Context) -> Iterator[Fault]:
    joints = context.view.joint
    for joint in context.view.joints:
        if joint.mimic is None or joint.mimic.joint in joints or unexpanded(joint.mimic.joint):
            continue
        name = joint.mimic.joint
        yield Fault(
            at=value_span(joint.mimic.element, "joint"),
            subject=joint.subject,
            what=f"it mimics joint {shown(name)}, which does not exist" if name else "<mimic> names no joint",
            remedy=alternatives(name, joints, "joints") if name else 'write joint="..."',
        )


RULE = Rule(
    code="RD510",
    name="mimic-unknown-joint",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="A joint mimics one of the robot's joints.",
    explanation="""Readers refuse the robot, or make the follower a free joint that nothing drives.""",
    bad=arm(more=a_link("fore") + a_joint("elbow", "upper", "fore", _FOLLOWER.replace("shoulder", "sholder"))),
    good=arm(more=a_link("fore") + a_joint("elbow", "upper", "fore", _FOLLOWER)),
    check=check,
)
