"""A joint mimics one of the robot's joints.

Readers refuse the robot, or make the follower a free joint that nothing drives.
"""

from robodyn.checks.examples import LIMIT, a_joint, a_link, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.xml_reader import unexpanded
from robodyn.support.wording import alternatives, shown

_FOLLOWER = f'<axis xyz="0 1 0"/>{LIMIT}<mimic joint="shoulder" multiplier="0.5"/>'


@rule(
    Severity.ERROR,
    Stage.DOCUMENT,
    bad=arm(more=a_link("fore") + a_joint("elbow", "upper", "fore", _FOLLOWER.replace("shoulder", "sholder"))),
    good=arm(more=a_link("fore") + a_joint("elbow", "upper", "fore", _FOLLOWER)),
)
def check(context: Context) -> Faults:
    joints = context.view.joint
    for joint in context.view.joints:
        if joint.mimic is None or joint.mimic.joint in joints or unexpanded(joint.mimic.joint):
            continue
        name = joint.mimic.joint
        yield Fault(
            at=value_span(joint.mimic.element, "joint"),
            subject=joint.subject,
            what=f"it mimics joint {shown(name)}, which does not exist" if name else "<mimic> names no joint",
            remedy=alternatives(name, joints, "joints") if name else 'write joint="..."',
        )
