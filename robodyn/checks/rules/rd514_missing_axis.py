"""A joint that turns or slides says about which axis.

Without `<axis>` it is 1 0 0, the x axis of the joint: a part that was to turn about z rolls instead,
and nothing else tells. Writing it down costs nothing where x is meant.
"""

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.parts import WITH_AXIS


@rule(Severity.WARNING, good=arm(), bad=arm(LIMIT))
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        if joint.type in WITH_AXIS and joint.element.find("axis") is None:
            what = f"it is {joint.type} and has no <axis>: it is taken to be 1 0 0, the x axis of the joint"
            yield Fault(joint.name_span, what, 'write <axis xyz="..."/>, also where it is 1 0 0')
