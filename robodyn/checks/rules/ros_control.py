"""What <ros2_control> lists: joints, sensors and gpio with their interfaces, ranges and mimics."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from math import isclose, radians, tau
from typing import NamedTuple

from robodyn.checks.examples import LIMIT, a_joint, a_link, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.document import Element, Span, unexpanded
from robodyn.robot.urdf.parts import WITH_RANGE
from robodyn.robot.urdf.view import TEXT, JointView, Subject, View, numbers, value_span
from robodyn.support.wording import alternatives, figure, shown, slip_of

Numeric = tuple[float | None, float | None]
"""What is measured, and its bound."""


class Controlled(NamedTuple):
    """A joint, sensor or gpio (`element`) of a <ros2_control>; if it is a joint, that of the URDF."""

    control: Element
    element: Element
    joint: JointView | None

    @property
    def name(self) -> str:
        return self.element.get("name") or ""

    @property
    def interfaces(self) -> list[Element]:
        return [child for child in self.element.children if child.tag in ("command_interface", "state_interface")]

    def fault(
        self, at: Span, what: str, remedy: str, numbers: Numeric = (None, None), severity: Severity | None = None
    ) -> Fault:
        return Fault(at, what, remedy, *numbers, Subject(self.element.tag, self.name), severity)


def controlled(view: View) -> Iterator[Controlled]:
    for control in view.root.findall("ros2_control"):
        for element in control.children:
            if element.tag in ("joint", "sensor", "gpio"):
                joint = view.joint.get(element.get("name") or "") if element.tag == "joint" else None
                yield Controlled(control, element, joint)


def _parameter(owner: Element, name: str) -> Element | None:
    return next((child for child in owner.findall("param") if child.get("name") == name), None)


_STANDARD = ("position", "velocity", "effort", "acceleration")
_SHOULDER = """
  <ros2_control name="drives" type="system">
    <hardware><plugin>mock_components/GenericSystem</plugin></hardware>
    <joint name="shoulder">
      <command_interface name="position"/>
      <state_interface name="position"/>
    </joint>
  </ros2_control>"""
_LISTED_AGAIN = '</joint>\n    <joint name="shoulder"><state_interface name="position"/></joint>\n  </ros2_control>'


@rule("RD702", Severity.ERROR, good=arm(more=_SHOULDER), bad=("</joint>\n  </ros2_control>", _LISTED_AGAIN))
def controlled_joint(context: Context) -> Faults:
    """What ros2_control lists is named, is listed once, and moves; its hardware has a plugin.

    controller_manager ends at start where one interface of a joint, sensor or gpio is offered twice, and where one of
    them or an interface has no name. A fixed joint has nothing to command, and the controller that waits for it never
    starts; nor does one where the name of an interface has a letter too many. A sensor or gpio that offers nothing is
    not there for anybody.
    """
    listed: dict[tuple[int, str, str], Element] = {}
    offered: dict[tuple[str, str, str], Element] = {}
    for control in context.view.root.findall("ros2_control"):
        hardware = control.find("hardware")
        if hardware is not None and hardware.find("plugin") is None:
            what, remedy = "<hardware> names no plugin", "write <plugin>package/Class</plugin>"
            yield Fault(hardware.span, what, remedy, subject=Subject("ros2_control", control.get("name") or ""))
    for part in controlled(context.view):
        for element in (part.element, *part.interfaces):
            if not element.get("name"):
                one = part.fault(element.span, f"<{element.tag}> in <ros2_control> has no name", 'write name="..."')
                yield one if part.name else replace(one, subject=None)
        if part.element.tag != "joint" and part.name and not part.interfaces:
            what, remedy = f"<{part.element.tag}> offers no interface", "give it a <state_interface>, or delete it"
            yield part.fault(part.element.span, what, remedy, severity=Severity.WARNING)
        for interface in part.interfaces if part.element.tag == "joint" else ():
            name = interface.get("name") or ""
            if meant := slip_of(name, _STANDARD):
                what, remedy = f"no controller asks for the interface {shown(name)}", f"did you mean {shown(meant)}?"
                yield part.fault(value_span(interface, "name"), what, remedy, severity=Severity.WARNING)
        if part.joint is not None and part.joint.type == "fixed":
            what = f"ros2_control lists this joint, which is fixed in line {part.joint.element.line}"
            remedy = "let it move (type=...), or delete it from <ros2_control>"
            yield part.fault(value_span(part.element, "name"), what, remedy)
        yield from _again(part, listed, offered)


def _again(
    part: Controlled, listed: dict[tuple[int, str, str], Element], offered: dict[tuple[str, str, str], Element]
) -> Iterator[Fault]:
    """Yield what is listed a second time in its <ros2_control>, or offers an interface that another one offers."""
    name = part.name
    first = listed.setdefault((id(part.control), part.element.tag, name), part.element)
    if name and first is not part.element:
        what = f"<ros2_control> lists this {part.element.tag} a second time; the first is in line {first.line}"
        yield part.fault(value_span(part.element, "name"), what, "keep one of them")
        return
    for interface in part.interfaces if name else ():
        offer = interface.get("name") or ""
        other = offered.setdefault((interface.tag, name, offer), interface)
        if offer and other is not interface:
            what = f"<{interface.tag}> '{offer}' is offered a second time; the first is in line {other.line}"
            yield part.fault(value_span(interface, "name"), what, "offer each interface once")
            return


_BEYOND = 0.05
_WITH_RANGE = """
  <ros2_control name="drives" type="system">
    <joint name="shoulder">
      <command_interface name="position">
        <param name="min">-1.5</param>
        <param name="max">1.5</param>
      </command_interface>
    </joint>
  </ros2_control>"""


@rule("RD704", Severity.ERROR, good=arm(more=_WITH_RANGE), bad=(">-1.5<", ">2.5<"))
def control_range(context: Context) -> Faults:
    """Ranges in ros2_control are numbers, min is not above max, and positions keep to the joint's own range.

    The parameters min, max and initial_value of an interface are read as numbers when the hardware starts; with min
    above max nothing can be commanded, and an initial value outside is a jump or a refusal. Positions beyond
    <limit> of the joint are those of another joint, or in degrees; up to 5 % more of the range is passed over.
    """
    for part in controlled(context.view):
        for interface in part.interfaces:
            for at, what, remedy, measured, bound in _wrong(interface):
                whole = f"{what} for <{interface.tag}> '{interface.get('name') or ''}'"
                yield part.fault(at, whole, remedy, (measured, bound))
            if part.joint is not None and interface.get("name") == "position":
                yield from _beyond(part.joint, part, interface)


def _beyond(joint: JointView, part: Controlled, interface: Element) -> Iterator[Fault]:
    own = joint.limit.range if joint.limit is not None and joint.type in WITH_RANGE else None
    ends = [numbers(_parameter(interface, name), TEXT, 1) for name in ("min", "max")]
    if own is None or own[0] >= own[1]:
        return
    signed = zip(ends, own, (-1, 1), strict=True)
    over = [sign * (number.value - end) if number.value is not None else 0.0 for number, end, sign in signed]
    k = over.index(max(over))
    value, slack = ends[k].value, _BEYOND * (own[1] - own[0])
    if value is None or over[k] <= slack or (ends[0].value or 0.0) > (ends[1].value or 0.0):
        return
    fits = all(number.value is None or own[0] - slack <= radians(number.value) <= own[1] + slack for number in ends)
    in_degrees = joint.type == "revolute" and abs(value) > tau and fits
    what = f"{('min', 'max')[k]} {figure(value)} is beyond the joint's own range, {figure(own[0])} to {figure(own[1])}"
    cause = "the range is in degrees" if in_degrees else None
    remedy = "write radians" if in_degrees else "keep to the range in <limit>, or correct that"
    yield replace(part.fault(ends[k].span, what, remedy, (value, own[k]), Severity.WARNING), cause=cause)


def _wrong(interface: Element) -> Iterator[tuple[Span, str, str, float | None, float | None]]:
    found = {name: numbers(_parameter(interface, name), TEXT, 1) for name in ("min", "max", "initial_value")}
    for name, number in found.items():
        if number.problem is not None and number.element is not None and not unexpanded(number.element.text):
            yield number.element.span, f"{name} {number.problem}", number.problem.remedy, None, None
    least, most, first = (number.value for number in found.values())
    if least is not None and most is not None and least > most:
        yield found["min"].span, f"min {figure(least)} is above max {figure(most)}", "exchange them", least, most
    elif first is not None:
        for beyond, end, bound in ((-1, "below min", least), (1, "above max", most)):
            if bound is not None and beyond * (first - bound) > 0:
                what = f"initial_value {figure(first)} is {end} {figure(bound)}"
                yield found["initial_value"].span, what, "begin within the range", first, bound


_FINGER = a_link("finger") + a_joint(
    "follower", "upper", "finger", f'<axis xyz="0 1 0"/>{LIMIT}<mimic joint="shoulder"/>'
)
_FOLLOWED = """
  <ros2_control name="drives" type="system">
    <joint name="shoulder"><command_interface name="position"/></joint>
    <joint name="follower"><state_interface name="position"/></joint>
  </ros2_control>"""


@rule(
    "RD705",
    Severity.ERROR,
    good=arm(more=_FINGER + _FOLLOWED),
    bad=('follower"><state_interface', 'follower"><command_interface'),
)
def controlled_mimic(context: Context) -> Faults:
    """ros2_control follows the joints that the URDF says are followed.

    A joint with <mimic> has no command interface of its own, unless it says mimic="false"; mimic="true" needs a
    <mimic> in the URDF; and the joint that is followed is in the same <ros2_control>: otherwise controller_manager
    ends at start (ROS 2 Jazzy). The parameters mimic and multiplier, of Humble and before, name a joint of the same
    <ros2_control> and agree with the URDF.
    """
    parts = [part for part in controlled(context.view) if part.element.tag == "joint"]
    for part in parts:
        beside = [other.name for other in parts if other.control is part.control]
        if part.joint is not None:
            yield from _by_tag(part, part.joint, beside)
        yield from _by_parameter(part, part.joint, beside)


def _by_tag(part: Controlled, joint: JointView, beside: Collection[str]) -> Iterator[Fault]:
    said = (part.element.get("mimic") or "").lower()
    at = value_span(part.element, "mimic" if said else "name")
    if joint.mimic is None:
        if said == "true":
            what = "mimic is true, and the joint has no <mimic> in the URDF"
            yield part.fault(at, what, "write <mimic> in the URDF's joint")
    elif said != "false":
        if part.element.find("command_interface") is not None:
            what = f"the joint follows {shown(joint.mimic.joint)} and has a command interface"
            yield part.fault(at, what, 'delete <command_interface>, or write mimic="false"')
        elif joint.mimic.joint not in beside:
            what = f"the joint follows {shown(joint.mimic.joint)}, which is not in the same <ros2_control>"
            yield part.fault(at, what, 'list that joint there, or write mimic="false"')


def _by_parameter(part: Controlled, joint: JointView | None, beside: Collection[str]) -> Iterator[Fault]:
    mimic, multiplier = _parameter(part.element, "mimic"), _parameter(part.element, "multiplier")
    name = "" if mimic is None else mimic.text.strip()
    if mimic is not None and not unexpanded(name):
        if name not in beside:
            what = f"the parameter mimic names {shown(name)}, which is not in the same <ros2_control>"
            yield part.fault(mimic.span, what, alternatives(name, beside, "joints there"))
        elif joint is not None and joint.mimic is not None and joint.mimic.joint != name:
            what = f"the parameter mimic names {shown(name)}, <mimic> of the URDF {shown(joint.mimic.joint)}"
            yield part.fault(mimic.span, what, "name one joint in both")
    if multiplier is None or unexpanded(multiplier.text):
        return
    given = numbers(multiplier, TEXT, 1)
    factor = None if joint is None or joint.mimic is None else joint.mimic.multiplier.or_default(1.0)
    if given.problem is not None:
        what = f"the parameter multiplier {given.problem}"
        yield part.fault(multiplier.span, what, given.problem.remedy)
    elif given.value is not None and factor is not None and not isclose(given.value, factor[0], rel_tol=1e-6):
        what = f"the parameter multiplier is {figure(given.value)}, that of <mimic> in the URDF {figure(factor[0])}"
        yield part.fault(multiplier.span, what, "write one number in both", (given.value, factor[0]))
