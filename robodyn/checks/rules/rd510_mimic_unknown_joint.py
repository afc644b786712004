"""A joint mimics one of the robot's joints.

Readers refuse the robot, or make the follower a free joint that nothing drives.
"""

from robodyn.checks.examples import LIMIT, longer_arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.xml_reader import unexpanded
from robodyn.support.wording import alternatives, shown

_FOLLOWER = f'<axis xyz="0 1 0"/>{LIMIT}<mimic joint="shoulder" multiplier="0.5"/>'


@rule(
    Severity.ERROR, good=longer_arm(inside=_FOLLOWER), bad=('joint="shoulder"', 'joint="sholder"'), explains=("RD901",)
)
def check(context: Context) -> Faults:
    joints = context.view.joint
    for joint in context.view.joints:
        if joint.mimic is None or joint.mimic.joint in joints or unexpanded(joint.mimic.joint):
            continue
        name = joint.mimic.joint
        what = f"it mimics joint {shown(name)}, which does not exist" if name else "<mimic> names no joint"
        remedy = alternatives(name, joints, "joints") if name else 'write joint="..."'
        yield Fault(value_span(joint.mimic.element, "joint"), what, remedy)
