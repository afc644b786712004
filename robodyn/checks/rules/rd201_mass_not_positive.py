"""Masses are positive.

No body has a negative mass, and one of zero mass that moves takes on any acceleration: its
equation of motion is 0 = force. A zero counts only where the whole rigid group (links joined by fixed joints) has no
mass; it is a warning where the group carries on to one that has mass, as in a universal joint: MuJoCo refuses such a
group, and Gazebo drops it and all that hangs on it.
"""

from robodyn.checks.bodies.masses import severity_of_zero
from robodyn.checks.examples import INERTIA, arm, one_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule


@rule(Severity.ERROR, good=arm(), bad=one_link(f'<mass value="-2"/>{INERTIA}'), explains=("RD901",))
def check(context: Context) -> Faults:
    for link in context.view.links:
        if link.inertial is None or link.mass is None or link.mass > 0:
            continue
        severity = Severity.ERROR if link.mass < 0 else severity_of_zero(context, link)
        if severity is not None:
            what = f"the mass is {link.mass:g} kg, not positive"
            what += "; MuJoCo refuses it, Gazebo drops it and what hangs on it" * (link.mass == 0)
            remedy = "write the mass of the part, or fix the link to one that has mass"
            yield Fault(link.inertial.mass.span, what, remedy, link.mass, 0.0, severity=severity)
