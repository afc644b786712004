"""ros2_control follows the joints that the URDF says are followed.

A joint with <mimic> has no command interface of its own, unless it says mimic="false"; mimic="true"
needs a <mimic> in the URDF; and the joint that is followed is in the same <ros2_control>: otherwise controller_manager
ends at start (ROS 2 Jazzy). The parameters mimic and multiplier, of Humble and before, name a joint of the same
<ros2_control> and agree with the URDF.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from math import isclose

from robodyn.checks.examples import LIMIT, a_joint, a_link, arm
from robodyn.checks.ros.control import Controlled, controlled, parameter
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import TEXT, numbers, value_span
from robodyn.robot.urdf.view import JointView
from robodyn.robot.urdf.xml_reader import unexpanded
from robodyn.support.wording import alternatives, figure, shown

_FINGER = a_link("finger") + a_joint(
    "follower", "upper", "finger", f'<axis xyz="0 1 0"/>{LIMIT}<mimic joint="shoulder"/>'
)
_CONTROL = """
  <ros2_control name="drives" type="system">
    <joint name="shoulder"><command_interface name="position"/></joint>
    <joint name="follower"><state_interface name="position"/></joint>
  </ros2_control>"""


@rule(
    Severity.ERROR,
    good=arm(more=_FINGER + _CONTROL),
    bad=('follower"><state_interface', 'follower"><command_interface'),
)
def check(context: Context) -> Faults:
    parts = [part for part in controlled(context.view) if part.element.tag == "joint"]
    for part in parts:
        joint = context.view.joint.get(part.subject.name)
        beside = [other.subject.name for other in parts if other.control is part.control]
        if joint is not None:
            yield from _by_tag(part, joint, beside)
        yield from _by_parameter(part, joint, beside)


def _by_tag(part: Controlled, joint: JointView, beside: Collection[str]) -> Iterator[Fault]:
    said = (part.element.get("mimic") or "").lower()
    at = value_span(part.element, "mimic" if said else "name")
    if joint.mimic is None:
        if said == "true":
            what, remedy = (
                "mimic is true, and the joint has no <mimic> in the URDF",
                "write <mimic> in the URDF's joint",
            )
            yield Fault(at, what, remedy, subject=part.subject)
    elif said != "false":
        if part.is_commanded:
            what = f"the joint follows {shown(joint.mimic.joint)} and has a command interface"
            yield Fault(at, what, 'delete <command_interface>, or write mimic="false"', subject=part.subject)
        elif joint.mimic.joint not in beside:
            what = f"the joint follows {shown(joint.mimic.joint)}, which is not in the same <ros2_control>"
            yield Fault(at, what, 'list that joint there, or write mimic="false"', subject=part.subject)


def _by_parameter(part: Controlled, joint: JointView | None, beside: Collection[str]) -> Iterator[Fault]:
    mimic, multiplier = parameter(part.element, "mimic"), parameter(part.element, "multiplier")
    name = "" if mimic is None else mimic.text.strip()
    if mimic is not None and not unexpanded(name):
        if name not in beside:
            what = f"the parameter mimic names {shown(name)}, which is not in the same <ros2_control>"
            yield Fault(mimic.span, what, alternatives(name, beside, "joints there"), subject=part.subject)
        elif joint is not None and joint.mimic is not None and joint.mimic.joint != name:
            what = f"the parameter mimic names {shown(name)}, <mimic> of the URDF {shown(joint.mimic.joint)}"
            yield Fault(mimic.span, what, "name one joint in both", subject=part.subject)
    if multiplier is None or unexpanded(multiplier.text):
        return
    given = numbers(multiplier, TEXT, 1)
    factor = None if joint is None or joint.mimic is None else joint.mimic.multiplier.or_default(1.0)
    if given.problem is not None:
        yield Fault(
            multiplier.span, f"the parameter multiplier {given.problem}", given.problem.remedy, subject=part.subject
        )
    elif given.value is not None and factor is not None and not isclose(given.value, factor[0], rel_tol=1e-6):
        what = f"the parameter multiplier is {figure(given.value)}, that of <mimic> in the URDF {figure(factor[0])}"
        yield Fault(multiplier.span, what, "write one number in both", given.value, factor[0], subject=part.subject)
