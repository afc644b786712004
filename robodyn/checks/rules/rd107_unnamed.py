"""RD107: a robot, link or joint without a name."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import value_span


def check(context: Context) -> Iterator[Fault]:
    view = context.view
    links, joints = (part.element for part in view.links), (part.element for part in view.joints)
    for element in (view.root, *links, *joints):
        if not element.get("name"):
            state = "no name" if element.get("name") is None else "an empty name"
            yield Fault(at=value_span(element, "name"), what=f"<{element.tag}> has {state}", remedy='write name="..."')


RULE = Rule(
    code="RD107",
    name="unnamed",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="The robot and every link and joint have a name.",
    explanation="""Joints refer to links by name, and programs to joints. urdfdom refuses a robot or a joint without
one.""",
    bad=arm().replace('<joint name="shoulder" ', "<joint "),
    good=arm(),
    check=check,
)
