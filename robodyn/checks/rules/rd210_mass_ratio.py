"""The bodies on both sides of a joint differ in mass by less than a factor of 1000.

A factor of 1000 is most often grams for kilograms. Where it is real, the mass matrix is
ill-conditioned, and iterative solvers of simulators need many more steps.
"""

from robodyn.checks.examples import INERTIA, longer_arm
from robodyn.checks.reading.tree import Group
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_HEAVY = f'<mass value="5000"/>{INERTIA}'


@rule(Severity.WARNING, Stage.TREE, good=longer_arm(), bad=('"1"', '"5000"'))
def check(context: Context) -> Faults:
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
        what = f"it joins bodies of {inner:g} kg and {group.mass:g} kg, a ratio of {ratio:.3g}"
        remedy = "check the unit of both masses (kg)"
        yield Fault(odd.heaviest[1].mass.span, what, remedy, ratio, bound, subject=group.joint.subject)
