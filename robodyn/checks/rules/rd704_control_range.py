"""Ranges in ros2_control are numbers, and min is not above max.

The parameters min, max and initial_value of an interface are read as numbers when the hardware
starts; with min above max nothing can be commanded, and an initial value outside is a jump or a refusal.
"""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.examples import arm
from robodyn.checks.ros.control import controlled, parameter
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element, Span
from robodyn.robot.urdf.numbers import TEXT, Numbers, numbers
from robodyn.robot.urdf.xml_reader import unexpanded
from robodyn.support.wording import figure

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
