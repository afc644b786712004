"""A transmission has a name of its own and a type, and drives joints that move, each once, by a ratio that is not 0.

A joint in two transmissions gets two drives, or the later one replaces the earlier. A reduction of 0
divides by zero: ros_control and ros2_control refuse it ("reduction ratio cannot be zero"). One without a type is passed
over, and so is a joint whose hardware interface has a name that nobody offers; a drive of a fixed joint moves nothing.
Types and interfaces of other packages are not judged, but for those that are the usual ones' but for a slip.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import TEXT, numbers, value_span
from robodyn.robot.urdf.view import Subject, View
from robodyn.robot.urdf.xml_reader import unexpanded
from robodyn.support.wording import shown, slip_of

_TYPES = ("SimpleTransmission", "DifferentialTransmission", "FourBarLinkageTransmission")
_INTERFACES = tuple(
    f"{kind}Interface"
    for kind in ("EffortJoint", "PositionJoint", "VelocityJoint", "PosVelJoint", "PosVelAccJoint", "JointState")
)
_REDUCTIONS = ("mechanicalReduction", "mechanical_reduction")
_TRANSMISSION = """
  <transmission name="drive">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="shoulder"><hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint>
    <actuator name="motor"><mechanicalReduction>50</mechanicalReduction></actuator>
  </transmission>"""


@rule(Severity.ERROR, good=arm(more=_TRANSMISSION), bad=(">50<", ">0<"))
def check(context: Context) -> Faults:
    root = context.view.root
    inside = [each for control in root.findall("ros2_control") for each in control.findall("transmission")]
    for transmissions in (root.findall("transmission"), inside):
        driven: dict[str, Element] = {}
        for transmission in transmissions:
            yield from _again(transmission, driven)
            yield from _reductions(transmission)
    yield from _named_again(root.findall("transmission"))
    for transmission in root.findall("transmission"):
        yield from _drives_nothing(transmission, context.view)


def _again(transmission: Element, driven: dict[str, Element]) -> Iterator[Fault]:
    for joint in transmission.findall("joint"):
        name = joint.get("name")
        if name and (first := driven.setdefault(name, joint)) is not joint:
            what = f"joint '{name}' is driven a second time; the first is in line {first.line}"
            yield Fault(value_span(joint, "name"), what, "keep one of the two", subject=_subject(transmission))


def _named_again(transmissions: Sequence[Element]) -> Iterator[Fault]:
    first: dict[str, Element] = {}
    for transmission in transmissions:
        name = transmission.get("name")
        if name and (other := first.setdefault(name, transmission)) is not transmission:
            what = f"a second transmission of this name; the first is in line {other.line}"
            at = value_span(transmission, "name")
            yield Fault(at, what, "rename one of them", subject=_subject(transmission), severity=Severity.WARNING)


def _drives_nothing(transmission: Element, view: View) -> Iterator[Fault]:
    """Yield what keeps a transmission from being loaded: no type, an interface that is misspelt, a fixed joint."""
    subject, kind = _subject(transmission), transmission.find("type")
    said = transmission.get("type") if kind is None else kind.text.strip()
    if not said:
        what, remedy = (
            "the transmission has no type: readers pass over it",
            f"write <type>transmission_interface/{_TYPES[0]}</type>",
        )
        yield Fault(transmission.span, what, remedy, subject=subject, severity=Severity.WARNING)
    elif meant := slip_of(said.rpartition("/")[2], _TYPES):
        what, remedy = f"nobody offers the type {shown(said)}", f"did you mean {shown(meant)}?"
        yield Fault((kind or transmission).span, what, remedy, subject=subject, severity=Severity.WARNING)
    for joint in transmission.findall("joint"):
        moved = view.joint.get(joint.get("name") or "")
        if moved is not None and moved.type == "fixed":
            what = f"it drives joint {shown(moved.name)}, which is fixed in line {moved.element.line}"
            remedy = "delete the transmission, or let the joint move (type=...)"
            yield Fault(value_span(joint, "name"), what, remedy, subject=subject, severity=Severity.WARNING)
        for interface in joint.findall("hardwareInterface"):
            name = interface.text.strip().rpartition("/")[2]
            if meant := slip_of(name, _INTERFACES):
                what, remedy = f"nobody offers the interface {shown(name)}", f"did you mean {shown(meant)}?"
                yield Fault(interface.span, what, remedy, subject=subject, severity=Severity.WARNING)


def _reductions(transmission: Element) -> Iterator[Fault]:
    subject = _subject(transmission)
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


def _subject(transmission: Element) -> Subject:
    return Subject("transmission", transmission.get("name") or "")
