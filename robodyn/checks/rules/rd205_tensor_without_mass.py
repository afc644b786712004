"""RD205: moments of inertia without mass."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import INERTIA, a_joint, a_link, arm
from robodyn.checks.masses import severity_of_zero, trace
from robodyn.checks.rule import Fault, Rule, Severity, Stage


def check(context: Context) -> Iterator[Fault]:
    for link in context.view.links:
        if link.inertial is None or link.mass != 0 or link.tensor is None or not any(link.tensor):
            continue
        if severity_of_zero(context, link) is Severity.E:
            continue
        yield Fault(
            at=link.inertial.mass.span,
            subject=link.subject,
            what=f"the mass is 0, and the moments of inertia add up to {trace(link.tensor):g} kg m^2",
            remedy="write the mass of the part, or zeros for its inertia",
            measured=trace(link.tensor),
            bound=0.0,
        )


RULE = Rule(
    code="RD205",
    name="tensor-without-mass",
    severity=Severity.W,
    stage=Stage.DOCUMENT,
    summary="What has no mass has no moments of inertia.",
    explanation="""A moment of inertia is mass times distance squared. The zero is often a mass that was rounded away,
or a placeholder that was forgotten. A body that moves without any mass is RD201's.""",
    bad=arm(more=a_link("tip", f'<mass value="0"/>{INERTIA}') + a_joint("flange", "upper", "tip", "", "fixed")),
    good=arm(more=a_link("tip", f'<mass value="1"/>{INERTIA}') + a_joint("flange", "upper", "tip", "", "fixed")),
    check=check,
)
