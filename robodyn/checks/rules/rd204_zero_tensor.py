"""What has mass has moments of inertia.

Only a point has none. Simulators refuse such a body or put in a number of their own. It is a
remark where heavier links are fixed to this one, and a warning for the base, which most often stands still.
"""

from robodyn.checks.bodies.masses import POINT, gyration, is_a_point
from robodyn.checks.examples import inertia, longer_arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.view import LinkView


@rule(
    Severity.ERROR,
    good=longer_arm(),
    bad=longer_arm(inertial='<mass value="1"/>' + inertia("0 0 0 0 0 0")),
    explains=("RD402", "RD901"),
)
def check(context: Context) -> Faults:
    for link in context.view.links:
        if link.inertial is None or not link.mass or link.mass < 0 or not is_a_point(link):
            continue
        what = f"a mass of {link.mass:g} kg has no moments of inertia: it would be a point"
        remedy = "write the inertia of the part; robodyn inertia computes it from its mesh"
        yield Fault(link.inertial.entries[0].span, what, remedy, measured=0.0, severity=_severity(context, link))


def _severity(context: Context, link: LinkView) -> Severity:
    """Return a remark where heavier links are fixed to it and the body has an inertia by them, or there is no tree that
    tells; a warning for a base."""
    if context.tree_or_none is None:
        return Severity.NOTE
    group = context.tree_or_none.group[link.name]
    if group.mass is None or link.mass is None:
        return Severity.ERROR
    if group.mass > 2 * link.mass and (gyration(context, group) or 0.0) > POINT:
        return Severity.NOTE
    return Severity.ERROR if group.joint is not None else Severity.WARNING
