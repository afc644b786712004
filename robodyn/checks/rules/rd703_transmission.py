"""A transmission drives each joint once, by a reduction that is not zero.

A joint in two transmissions gets two drives, or the later one replaces the earlier. A reduction of 0
divides by zero: ros_control and ros2_control refuse it ("reduction ratio cannot be zero").
"""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import TEXT, numbers, value_span
from robodyn.robot.urdf.view import Subject
from robodyn.robot.urdf.xml_reader import unexpanded

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


def _again(transmission: Element, driven: dict[str, Element]) -> Iterator[Fault]:
    for joint in transmission.findall("joint"):
        name = joint.get("name")
        if name and (first := driven.setdefault(name, joint)) is not joint:
            what = f"joint '{name}' is driven a second time; the first is in line {first.line}"
            yield Fault(value_span(joint, "name"), what, "keep one of the two", subject=_subject(transmission))


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
