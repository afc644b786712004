"""Revolute and prismatic joints have a <limit>.

URDF asks for it, and urdfdom refuses the robot.
"""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.parts import WITH_RANGE


@rule(Severity.ERROR, good=arm(), bad=arm('<axis xyz="0 1 0"/>'))
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        if joint.type in WITH_RANGE and joint.limit is None:
            remedy = 'add <limit lower="..." upper="..." effort="..." velocity="..."/>'
            if joint.type == "revolute":
                remedy += ", or make it continuous"
            yield Fault(joint.name_span, f"a {joint.type} joint without <limit>", remedy)
