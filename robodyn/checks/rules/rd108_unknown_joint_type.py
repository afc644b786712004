"""RD108: a joint of a type that URDF does not have."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import arm
from robodyn.checks.reading import unexpanded
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import JOINT_TYPES, value_span
from robodyn.support.wording import alternatives, shown


def check(context: Context) -> Iterator[Fault]:
    for joint in context.view.joints:
        if joint.type in JOINT_TYPES or unexpanded(joint.type):
            continue
        what = f"URDF has no joint type {shown(joint.type)}" if joint.type else "it has no type"
        remedy = alternatives(joint.type.lower(), JOINT_TYPES, "types")
        yield Fault(at=value_span(joint.element, "type"), subject=joint.subject, what=what, remedy=remedy)


RULE = Rule(
    code="RD108",
    name="unknown-joint-type",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="The type of a joint is revolute, continuous, prismatic, fixed, floating or planar.",
    explanation="""Readers refuse other types; some take them for fixed. Types are written in small letters.""",
    bad=arm(kind="hinge"),
    good=arm(kind="revolute"),
    check=check,
)
