"""The axis of a joint that moves is not zero.

Readers divide by its length: the joint then turns about NaN, or not at all.
"""

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.parts import WITH_AXIS


@rule(
    Severity.ERROR,
    Stage.DOCUMENT,
    bad=arm(f'<axis xyz="0 0 0"/>{LIMIT}'),
    good=arm(f'<axis xyz="0 0 1"/>{LIMIT}'),
)
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        if joint.type in WITH_AXIS and joint.axis.values is not None and not any(joint.axis.values):
            yield Fault(
                at=joint.axis.span,
                subject=joint.subject,
                what="the axis is 0 0 0, which is no direction",
                remedy='write the direction in the joint frame, for example xyz="0 0 1"',
                measured=0.0,
                bound=1.0,
            )
