"""RD211: a root with an inertia, which KDL ignores."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import a_link, arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage


def check(context: Context) -> Iterator[Fault]:
    root = context.tree.root
    if root.inertial is not None and root.mass and context.view.joints:
        yield Fault(
            at=root.inertial.element.span,
            subject=root.subject,
            what=f"the root has a mass of {root.mass:g} kg, which KDL ignores",
            remedy="where KDL or robot_state_publisher matters, put an empty root link above it with a fixed joint",
            measured=root.mass,
        )


RULE = Rule(
    code="RD211",
    name="root-with-inertia",
    severity=Severity.I,
    stage=Stage.TREE,
    summary="KDL ignores the inertia of the root.",
    explanation="""kdl_parser warns of it and drops it. It matters for a robot whose base moves; nothing is wrong for
others.""",
    bad=arm().replace('<link name="base"/>', a_link("base").strip()),
    good=arm(),
    check=check,
)
