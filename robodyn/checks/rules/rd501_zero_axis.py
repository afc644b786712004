"""The axis of a joint that moves is not zero.

Readers divide by its length: the joint then turns about NaN, or not at all.
"""

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.parts import WITH_AXIS


@rule(Severity.ERROR, good=arm(f'<axis xyz="0 0 1"/>{LIMIT}'), bad=('"0 0 1"', '"0 0 0"'), explains=("RD901",))
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        if joint.type in WITH_AXIS and joint.axis.values is not None and not any(joint.axis.values):
            remedy = 'write the direction in the joint frame, for example xyz="0 0 1"'
            yield Fault(joint.axis.span, "the axis is 0 0 0, which is no direction", remedy, 0.0, 1.0)
