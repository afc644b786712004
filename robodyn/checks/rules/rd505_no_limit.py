"""Revolute and prismatic joints have a <limit>.

URDF asks for it, and urdfdom refuses the robot.
"""

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.parts import WITH_RANGE


@rule(Severity.ERROR, Stage.DOCUMENT, bad=arm('<axis xyz="0 1 0"/>'), good=arm(f'<axis xyz="0 1 0"/>{LIMIT}'))
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        if joint.type in WITH_RANGE and joint.limit is None:
            remedy = 'add <limit lower="..." upper="..." effort="..." velocity="..."/>'
            if joint.type == "revolute":
                remedy += ", or make it continuous"
            yield Fault(
                at=joint.name_span, subject=joint.subject, what=f"a {joint.type} joint without <limit>", remedy=remedy
            )
