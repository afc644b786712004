"""Ranges in ros2_control are numbers, min is not above max, and positions keep to the joint's own range.

The parameters min, max and initial_value of an interface are read as numbers when the hardware
starts; with min above max nothing can be commanded, and an initial value outside is a jump or a refusal.
Positions beyond <limit> of the joint are those of another joint, or in degrees; up to 5 % more of the range is passed
over.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import radians, tau

from robodyn.checks.examples import arm
from robodyn.checks.ros.control import Controlled, controlled, parameter
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element, Span
from robodyn.robot.urdf.numbers import TEXT, Numbers, numbers
from robodyn.robot.urdf.parts import WITH_RANGE
from robodyn.robot.urdf.view import JointView
from robodyn.robot.urdf.xml_reader import unexpanded
from robodyn.support.wording import figure

_BEYOND = 0.05
_CONTROL = """
  <ros2_control name="drives" type="system">
    <joint name="shoulder">
      <command_interface name="position">
        <param name="min">-1.5</param>
        <param name="max">1.5</param>
      </command_interface>
    </joint>
  </ros2_control>"""


@rule(Severity.ERROR, good=arm(more=_CONTROL), bad=(">-1.5<", ">2.5<"))
def check(context: Context) -> Faults:
    for part in controlled(context.view):
        for interface in part.interfaces:
            for at, what, remedy, measured, bound in _wrong(interface):
                whole = f"{what} for <{interface.tag}> '{interface.get('name') or ''}'"
                yield Fault(at, whole, remedy, measured, bound, subject=part.subject)
            joint = context.view.joint.get(part.subject.name) if part.element.tag == "joint" else None
            if joint is not None and interface.get("name") == "position":
                yield from _beyond(joint, part, interface)


def _beyond(joint: JointView, part: Controlled, interface: Element) -> Iterator[Fault]:
    """Yield the end of a range of positions that is farthest beyond that of the joint itself."""
    own = joint.limit.range if joint.limit is not None and joint.type in WITH_RANGE else None
    ends = [_read(interface, name) for name in ("min", "max")]
    if own is None or own[0] >= own[1]:
        return
    over = [
        sign * (number.value - end) if number.value is not None else 0.0
        for number, end, sign in zip(ends, own, (-1, 1), strict=True)
    ]
    k = over.index(max(over))
    value, slack = ends[k].value, _BEYOND * (own[1] - own[0])
    if value is None or over[k] <= slack or (ends[0].value or 0.0) > (ends[1].value or 0.0):
        return
    in_degrees = joint.type == "revolute" and abs(value) > tau and over[k] > 0
    in_degrees = in_degrees and all(
        number.value is None or own[0] - slack <= radians(number.value) <= own[1] + slack for number in ends
    )
    what = f"{('min', 'max')[k]} {figure(value)} is beyond the joint's own range, {figure(own[0])} to {figure(own[1])}"
    cause = "the range is in degrees" if in_degrees else None
    remedy = "write radians" if in_degrees else "keep to the range in <limit>, or correct that"
    yield Fault(ends[k].span, what, remedy, value, own[k], part.subject, Severity.WARNING, cause)


def _wrong(interface: Element) -> Iterator[tuple[Span, str, str, float | None, float | None]]:
    found = {name: _read(interface, name) for name in ("min", "max", "initial_value")}
    for name, number in found.items():
        if number.problem is not None and number.element is not None and not unexpanded(number.element.text):
            yield number.element.span, f"{name} {number.problem}", number.problem.remedy, None, None
    least, most, first = (number.value for number in found.values())
    if least is not None and most is not None and least > most:
        yield found["min"].span, f"min {figure(least)} is above max {figure(most)}", "exchange them", least, most
    elif first is not None and least is not None and first < least:
        what = f"initial_value {figure(first)} is below min {figure(least)}"
        yield found["initial_value"].span, what, "begin within the range", first, least
    elif first is not None and most is not None and first > most:
        what = f"initial_value {figure(first)} is above max {figure(most)}"
        yield found["initial_value"].span, what, "begin within the range", first, most


def _read(interface: Element, name: str) -> Numbers:
    return numbers(parameter(interface, name), TEXT, 1)
