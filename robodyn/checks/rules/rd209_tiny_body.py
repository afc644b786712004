"""A moving body has a mass and a size that a machine part can have.

A rigid group (links joined by fixed joints) of less than 0.1 g, or of a radius of gyration below
0.1 mm, is a slip of units or a number put in to satisfy a program. It makes the mass matrix ill-conditioned and asks
for tiny steps.
"""

from robodyn.checks.bodies.masses import POINT, gyration
from robodyn.checks.examples import inertia, longer_arm
from robodyn.checks.reading.tree import Group
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule


@rule(
    Severity.WARNING,
    Stage.TREE,
    good=longer_arm("tip", "wrist"),
    bad=longer_arm("tip", "wrist", '<mass value="1e-5"/>' + inertia("1e-8 0 0 1e-8 0 1e-8")),
)
def check(context: Context) -> Faults:
    limits = context.thresholds
    for group in context.tree.groups:
        if group.joint is None or not group.mass or group.mass < 0:
            continue
        radius = gyration(context, group)
        if group.mass < limits.least_mass:
            yield _fault(group, "mass", group.mass, limits.least_mass, "kg")
        elif radius is not None and POINT < radius < limits.least_gyration:
            yield _fault(group, "radius of gyration", radius, limits.least_gyration, "m")


def _fault(group: Group, quantity: str, value: float, bound: float, unit: str) -> Fault:
    _, inertial = group.heaviest
    numbers = inertial.mass if unit == "kg" else inertial.entries[0]
    what = f"what moves with it has a {quantity} of {value:.3g} {unit}, less than {bound:g} {unit}"
    remedy = "check the unit (kg, m); write the inertia of the part, or fix the link to its neighbour"
    return Fault(numbers.span, what, remedy, value, bound)
