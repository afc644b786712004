"""What transmissions, ros2_control and Gazebo's plugins name and list: joints, sensors, gpio, ranges, mimics."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from math import isclose, radians, tau
from typing import NamedTuple

from robodyn.checks.examples import LIMIT, a_joint, a_link, arm
from robodyn.checks.rule import ERROR, WARNING, Context, Fault, Faults, Severity, namesakes, rule, subject_of
from robodyn.checks.srdf import Named, own_srdf
from robodyn.robot.urdf.document import Element, Span, unexpanded
from robodyn.robot.urdf.parts import WITH_RANGE
from robodyn.robot.urdf.view import TEXT, JointView, Subject, View, numbers, value_span
from robodyn.support.wording import alternatives, figure, shown, slip_of

_PAIRS_ONLY = frozenset({"disable_collisions", "enable_collisions", "disable_default_collisions"})
_SIDES = ("left", "right", "leftfront", "leftrear", "rightfront", "rightrear")
_JOINTS = ("joint", "jointname", "jointnames", "mimicjoint", "actuatedjoint", *(f"{side}joint" for side in _SIDES))
_NAMES = {**dict.fromkeys(_JOINTS, "joint"), **dict.fromkeys(("bodyname", "linkname", "canonicalbody"), "link")}
"""Tags of plugins, in lower case and without _, whose text names a joint or a link; no frames: others may make them."""
_TRANSMISSION = """
  <transmission name="drive">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="shoulder"><hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint>
    <actuator name="motor"><mechanicalReduction>50</mechanicalReduction></actuator>
  </transmission>"""


@rule("RD701", ERROR, good=arm(more=_TRANSMISSION), bad=('<joint name="shoulder"><', '<joint name="sholder"><'))
def names_nothing(context: Context) -> Faults:
    """Transmissions, ros2_control, Gazebo and SRDF entries name links and joints that exist.

    Controllers fail at start, or the entry is dropped without a word, where a joint was renamed in one place and not in
    the others. Asked are <joint> in <transmission> and <ros2_control>, the reference of <gazebo>, the joints and bodies
    that its plugins name (jointName, mimicJoint, bodyName and so on; no frames, which others may publish), and the SRDF
    of the same name (or the only one for this robot) beside the file or in a folder config or srdf. Collisions of links
    that do not exist, and an SRDF of another name, which may belong to a variant of the robot, are warnings.
    root_joint, as Pinocchio calls a free base, is understood. A plugin of Gazebo names its library."""
    view = context.view
    both = {**view.link, **view.joint}
    remedies: dict[str, str] = {}
    for owner in view.root.children:
        for used in _uses(owner):
            names: Collection[str] = view.joint if used.kind == "joint" else both
            if used.name in names or unexpanded(used.name):
                continue
            if used.name not in remedies:
                remedies[used.name] = alternatives(used.name, names, "joints" if used.kind == "joint" else "links")
            at = value_span(used.element, used.attribute)
            what = f"there is no {used.kind} {shown(used.name)} in the robot"
            subject = Subject(owner.tag, owner.get("name") or owner.get("reference") or "")
            yield Fault(at, what, remedies[used.name], subject=subject)
        for plugin in owner.walk() if owner.tag == "gazebo" else ():
            if plugin.tag == "plugin" and not plugin.get("filename"):
                yield Fault(plugin.span, "a <plugin> names no library", 'write filename="lib....so"', subject=None)
    found = own_srdf(context)
    if found is None:
        return
    missing, more = found.missing, ""
    if not found.is_namesake and missing[1:]:
        missing, more = missing[:1], f", and {len(missing) - 1} more names that are not in the robot"
    for used in missing:  # one warning of an SRDF of another name, which may be of a variant of the robot
        names, tag = view.link if used.kind == "link" else view.joint, used.element.tag
        what = f"there is no {used.kind} {shown(used.name)} in the robot {shown(view.root.get('name') or '')}{more}"
        at, subject = value_span(used.element, used.attribute), subject_of(used.element)
        severity = None if found.is_namesake and tag not in _PAIRS_ONLY else WARNING
        remedy = alternatives(used.name, names, f"{used.kind}s")
        yield Fault(at, what, remedy, subject=subject, severity=severity, document=found.document)


def _uses(owner: Element) -> Iterator[Named]:
    if owner.tag in ("transmission", "ros2_control"):
        for inner in (owner, *owner.findall("transmission")):
            for joint in inner.findall("joint"):
                if joint.get("name"):
                    yield Named("joint", joint.values["name"], joint, "name")
    if owner.tag == "gazebo":
        if reference := owner.get("reference"):
            yield Named("link or joint", reference, owner, "reference")
        made = {element.get("name") for element in owner.walk() if element.tag.partition(":")[0] in ("joint", "link")}
        for plugin in (element for element in owner.walk() if element.tag == "plugin"):
            for element in plugin.walk():
                kind = _NAMES.get(element.tag.lower().replace("_", ""), "")
                for name in element.text.replace(",", " ").split() if kind and not element.children else ():
                    if name.rpartition("::")[2] not in {"world", *made}:
                        yield Named(kind, name.rpartition("::")[2], element, "")
                called = element.find("name") if element.tag == "virtualJoint" else None
                if called is not None and called.text.strip():
                    yield Named("joint", called.text.strip(), called, "")


_TYPES = ("SimpleTransmission", "DifferentialTransmission", "FourBarLinkageTransmission")
_INTERFACES = tuple(
    f"{kind}Interface"
    for kind in ("EffortJoint", "PositionJoint", "VelocityJoint", "PosVelJoint", "PosVelAccJoint", "JointState")
)
_REDUCTIONS = ("mechanicalReduction", "mechanical_reduction")


@rule("RD703", ERROR, good=arm(more=_TRANSMISSION), bad=(">50<", ">0<"))
def transmission(context: Context) -> Faults:
    """A transmission has a name of its own and a type, and drives moving joints, each once, by a ratio that is not 0.

    A joint in two transmissions gets two drives, or the later one replaces the earlier. A reduction of 0 is refused.
    One without a type is passed over, and so is a joint whose hardware interface has a name that nobody offers; a drive
    of a fixed joint moves nothing. Types and interfaces of other packages are not judged, but for slips of the usual
    ones."""
    root = context.view.root
    inside = [each for control in root.findall("ros2_control") for each in control.findall("transmission")]
    for transmissions in (root.findall("transmission"), inside):
        driven = [(joint, subject_of(each)) for each in transmissions for joint in each.findall("joint")]
        subjects = {id(joint): subject for joint, subject in driven}
        for joint, first in namesakes(joint for joint, _ in driven):
            what = f"joint '{joint.get('name')}' is driven a second time; the first is in line {first.line}"
            yield Fault(value_span(joint, "name"), what, "keep one of the two", subject=subjects[id(joint)])
        for each in transmissions:
            yield from _reductions(each)
    for again, first in namesakes(root.findall("transmission")):
        what = f"a second transmission of this name; the first is in line {first.line}"
        at = value_span(again, "name")
        yield Fault(at, what, "rename one of them", subject=subject_of(again), severity=WARNING)
    for each in root.findall("transmission"):
        subject, kind = subject_of(each), each.find("type")
        said = each.get("type") if kind is None else kind.text.strip()
        if not said:
            what = "the transmission has no type: readers pass over it"
            remedy = f"write <type>transmission_interface/{_TYPES[0]}</type>"
            yield Fault(each.span, what, remedy, subject=subject, severity=WARNING)
        elif meant := slip_of(said.rpartition("/")[2], _TYPES):
            what, remedy = f"nobody offers the type {shown(said)}", f"did you mean {shown(meant)}?"
            yield Fault((kind or each).span, what, remedy, subject=subject, severity=WARNING)
        for joint in each.findall("joint"):
            moved = context.view.joint.get(joint.get("name") or "")
            if moved is not None and moved.type == "fixed":
                what = f"it drives joint {shown(moved.name)}, which is fixed in line {moved.element.line}"
                remedy = "delete the transmission, or let the joint move (type=...)"
                yield Fault(value_span(joint, "name"), what, remedy, subject=subject, severity=WARNING)
            for interface in joint.findall("hardwareInterface"):
                name = interface.text.strip().rpartition("/")[2]
                if meant := slip_of(name, _INTERFACES):
                    what, remedy = f"nobody offers the interface {shown(name)}", f"did you mean {shown(meant)}?"
                    yield Fault(interface.span, what, remedy, subject=subject, severity=WARNING)


def _reductions(transmission: Element) -> Iterator[Fault]:
    subject = subject_of(transmission)
    for element in (transmission, *transmission.children):
        for reduction in (child for child in element.children if child.tag in _REDUCTIONS):
            ratio = numbers(reduction, TEXT, 1)
            if unexpanded(reduction.text):
                continue
            if ratio.problem is not None:
                yield Fault(reduction.span, f"the reduction {ratio.problem}", ratio.problem.remedy, subject=subject)
            elif ratio.value == 0:
                what = "the reduction is 0: its inverse is infinite"
                yield Fault(reduction.span, what, "write turns in per turn out", 0.0, None, subject)


Numeric = tuple[float | None, float | None]  # what is measured, and its bound


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


@rule("RD702", ERROR, good=arm(more=_SHOULDER), bad=("</joint>\n  </ros2_control>", _LISTED_AGAIN))
def controlled_joint(context: Context) -> Faults:
    """What ros2_control lists is named, is listed once, and moves; its hardware has a plugin.

    controller_manager ends at start where one interface of a joint, sensor or gpio is offered twice, and where one of
    them or an interface has no name. A fixed joint has nothing to command, and the controller that waits for it never
    starts; nor does one where the name of an interface has a letter too many. A sensor or gpio that offers nothing is
    of no use."""
    listed: dict[tuple[int, str, str], Element] = {}
    offered: dict[tuple[str, str, str], Element] = {}
    for control in context.view.root.findall("ros2_control"):
        hardware = control.find("hardware")
        plugin = None if hardware is None else hardware.find("plugin")
        if hardware is not None and (plugin is None or not plugin.text.strip()):
            what, remedy = "<hardware> names no plugin", "write <plugin>package/Class</plugin>"
            yield Fault(hardware.span, what, remedy, subject=subject_of(control))
    for part in controlled(context.view):
        for element in (part.element, *part.interfaces):
            if not element.get("name"):
                one = part.fault(element.span, f"<{element.tag}> in <ros2_control> has no name", 'write name="..."')
                yield one if part.name else replace(one, subject=None)
        if part.element.tag != "joint" and part.name and not part.interfaces:
            what, remedy = f"<{part.element.tag}> offers no interface", "give it a <state_interface>, or delete it"
            yield part.fault(part.element.span, what, remedy, severity=WARNING)
        for interface in part.interfaces if part.element.tag == "joint" else ():
            name = interface.get("name") or ""
            if meant := slip_of(name, _STANDARD):
                what, remedy = f"no controller asks for the interface {shown(name)}", f"did you mean {shown(meant)}?"
                yield part.fault(value_span(interface, "name"), what, remedy, severity=WARNING)
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


@rule("RD704", ERROR, good=arm(more=_WITH_RANGE), bad=(">-1.5<", ">2.5<"))
def control_range(context: Context) -> Faults:
    """Ranges in ros2_control are numbers, min is not above max, and positions keep to the joint's own range.

    The parameters min, max and initial_value of an interface are read as numbers when the hardware starts; with min
    above max nothing can be commanded, and an initial value outside is a jump or a refusal. Positions beyond <limit> of
    the joint are those of another joint, or in degrees; up to 5 % more of the range is passed over."""
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
    yield replace(part.fault(ends[k].span, what, remedy, (value, own[k]), WARNING), cause=cause)


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
    ERROR,
    good=arm(more=_FINGER + _FOLLOWED),
    bad=('follower"><state_interface', 'follower"><command_interface'),
)
def controlled_mimic(context: Context) -> Faults:
    """ros2_control follows the joints that the URDF says are followed.

    A joint with <mimic> has no command interface of its own, unless it says mimic="false"; mimic="true" needs a <mimic>
    in the URDF; and the joint that is followed is in the same <ros2_control>: otherwise controller_manager ends at
    start (ROS 2 Jazzy). The parameters mimic and multiplier, of Humble and before, name a joint in it and agree with
    the URDF."""
    parts = [part for part in controlled(context.view) if part.element.tag == "joint"]
    for part in parts:
        beside = [other.name for other in parts if other.control is part.control]
        if part.joint is not None:
            yield from _by_tag(part, part.joint, beside)
        mimic, multiplier = _parameter(part.element, "mimic"), _parameter(part.element, "multiplier")
        name = "" if mimic is None else mimic.text.strip()
        if mimic is not None and not unexpanded(name):
            if name not in beside:
                what = f"the parameter mimic names {shown(name)}, which is not in the same <ros2_control>"
                yield part.fault(mimic.span, what, alternatives(name, beside, "joints there"))
            elif part.joint is not None and part.joint.mimic is not None and part.joint.mimic.joint != name:
                what = f"the parameter mimic names {shown(name)}, <mimic> of the URDF {shown(part.joint.mimic.joint)}"
                yield part.fault(mimic.span, what, "name one joint in both")
        if multiplier is None or unexpanded(multiplier.text):
            continue
        given = numbers(multiplier, TEXT, 1)
        factor = None if part.joint is None or part.joint.mimic is None else part.joint.mimic.multiplier.or_default(1.0)
        if given.problem is not None:
            what = f"the parameter multiplier {given.problem}"
            yield part.fault(multiplier.span, what, given.problem.remedy)
        elif given.value is not None and factor is not None and not isclose(given.value, factor[0], rel_tol=1e-6):
            what = f"the parameter multiplier is {figure(given.value)}, that of <mimic> in the URDF {figure(factor[0])}"
            yield part.fault(multiplier.span, what, "write one number in both", (given.value, factor[0]))


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
