"""What has no mass has no moments of inertia.

A moment of inertia is mass times distance squared. The zero is often a mass that was rounded away,
or a placeholder that was forgotten. A body that moves without any mass is RD201's.
"""

from robodyn.checks.bodies.masses import severity_of_zero, trace
from robodyn.checks.examples import longer_arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule


@rule(Severity.WARNING, good=longer_arm("tip", "flange", inside="", kind="fixed"), bad=('"1"', '"0"'))
def check(context: Context) -> Faults:
    for link in context.view.links:
        if link.inertial is None or link.mass != 0 or link.tensor is None or not any(link.tensor):
            continue
        if severity_of_zero(context, link) is Severity.ERROR:
            continue
        what = f"the mass is 0, and the moments of inertia add up to {trace(link.tensor):g} kg m^2"
        remedy = "write the mass of the part, or zeros for its inertia"
        yield Fault(link.inertial.mass.span, what, remedy, trace(link.tensor), 0.0)
