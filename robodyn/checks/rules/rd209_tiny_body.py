"""RD209: a moving body that is next to nothing."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import INERTIA, a_joint, a_link, arm
from robodyn.checks.masses import POINT, gyration
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import LinkView

_SPECK = INERTIA.replace("0.01", "1e-8").replace("0.02", "1e-8")


def check(context: Context) -> Iterator[Fault]:
    limits = context.thresholds
    for group in context.tree.groups:
        if group.joint is None or not group.mass or group.mass < 0:
            continue
        radius = gyration(context, group)
        heaviest = max(group.links, key=lambda link: link.mass or 0.0)
        if group.mass < limits.least_mass:
            yield _fault(heaviest, "mass", group.mass, limits.least_mass, "kg")
        elif radius is not None and POINT < radius < limits.least_gyration:
            yield _fault(heaviest, "radius of gyration", radius, limits.least_gyration, "m")


def _fault(link: LinkView, quantity: str, value: float, bound: float, unit: str) -> Fault:
    assert link.inertial is not None, "it has mass"
    numbers = link.inertial.mass if unit == "kg" else link.inertial.entries[0]
    return Fault(
        at=numbers.span,
        subject=link.subject,
        what=f"what moves with it has a {quantity} of {value:.3g} {unit}, less than {bound:g} {unit}",
        remedy="check the unit (kg, m); write the inertia of the part, or fix the link to its neighbour",
        measured=value,
        bound=bound,
    )


RULE = Rule(
    code="RD209",
    name="tiny-body",
    severity=Severity.W,
    stage=Stage.TREE,
    summary="A moving body has a mass and a size that a machine part can have.",
    explanation="""A rigid group (links joined by fixed joints) of less than 0.1 g, or of a radius of gyration below
0.1 mm, is a slip of units or a number put in to satisfy a program. It makes the mass matrix ill-conditioned and asks
for tiny steps.""",
    bad=arm(more=a_link("tip", f'<mass value="1e-5"/>{_SPECK}') + a_joint("wrist", "upper", "tip")),
    good=arm(more=a_link("tip") + a_joint("wrist", "upper", "tip")),
    check=check,
)
