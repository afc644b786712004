"""RD210: bodies of very different mass on both sides of a joint."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import INERTIA, a_joint, a_link, arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.tree import Group

_HEAVY = f'<mass value="5000"/>{INERTIA}'


def check(context: Context) -> Iterator[Fault]:
    bound, least = context.thresholds.mass_ratio, context.thresholds.least_mass
    reported: set[Group] = set()
    for group in context.tree.groups:
        inner = None if group.parent is None else group.parent.mass
        if group.joint is None or group.parent is None or not group.mass or not inner:
            continue
        if min(group.mass, inner) < least:
            continue
        ratio = max(group.mass / inner, inner / group.mass)
        if ratio <= bound:
            continue
        odd = group if group.mass > inner else group.parent if group.parent.joint is not None else group
        if odd in reported:
            continue
        reported.add(odd)
        heaviest = max(odd.links, key=lambda link: link.mass or 0.0)
        assert heaviest.inertial is not None, "it has mass"
        yield Fault(
            at=heaviest.inertial.mass.span,
            subject=group.joint.subject,
            what=f"it joins bodies of {inner:g} kg and {group.mass:g} kg, a ratio of {ratio:.3g}",
            remedy="check the unit of both masses (kg)",
            measured=ratio,
            bound=bound,
        )


RULE = Rule(
    code="RD210",
    name="mass-ratio",
    severity=Severity.W,
    stage=Stage.TREE,
    summary="The bodies on both sides of a joint differ in mass by less than a factor of 1000.",
    explanation="""A factor of 1000 is most often grams for kilograms. Where it is real, the mass matrix is
ill-conditioned, and iterative solvers of simulators need many more steps.""",
    bad=arm(more=a_link("fore", _HEAVY) + a_joint("elbow", "upper", "fore")),
    good=arm(more=a_link("fore") + a_joint("elbow", "upper", "fore")),
    check=check,
)
