"""What ros2_control lists is named, is listed once, and moves.

controller_manager ends at start where one interface of a joint, sensor or gpio is offered twice, and
where one of them or an interface has no name. A fixed joint has nothing to command: simulators drop it, and the
controller that waits for it never starts.
"""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.examples import arm
from robodyn.checks.ros.control import Controlled, controlled
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import value_span

_CONTROL = """
  <ros2_control name="drives" type="system">
    <hardware><plugin>mock_components/GenericSystem</plugin></hardware>
    <joint name="shoulder">
      <command_interface name="position"/>
      <state_interface name="position"/>
    </joint>
  </ros2_control>"""
_AGAIN = '</joint>\n    <joint name="shoulder"><state_interface name="position"/></joint>\n  </ros2_control>'


@rule(Severity.ERROR, good=arm(more=_CONTROL), bad=("</joint>\n  </ros2_control>", _AGAIN))
def check(context: Context) -> Faults:
    listed: dict[tuple[int, str, str], Element] = {}
    offered: dict[tuple[str, str, str], Element] = {}
    for part in controlled(context.view):
        yield from _unnamed(part)
        joint = context.view.joint.get(part.subject.name) if part.element.tag == "joint" else None
        if joint is not None and joint.type == "fixed":
            what = f"ros2_control lists this joint, which is fixed in line {joint.element.line}"
            remedy = "let it move (type=...), or delete it from <ros2_control>"
            yield Fault(value_span(part.element, "name"), what, remedy, subject=part.subject)
        yield from _again(part, listed, offered)


def _unnamed(part: Controlled) -> Iterator[Fault]:
    for element in (part.element, *part.interfaces):
        if not element.get("name"):
            what = f"<{element.tag}> in <ros2_control> has no name"
            yield Fault(element.span, what, 'write name="..."', subject=part.subject if part.subject.name else None)


def _again(
    part: Controlled, listed: dict[tuple[int, str, str], Element], offered: dict[tuple[str, str, str], Element]
) -> Iterator[Fault]:
    """Yield what is listed a second time in its <ros2_control>, or offers an interface that another one offers."""
    name = part.subject.name
    if not name:
        return
    first = listed.setdefault((id(part.control), part.element.tag, name), part.element)
    if first is not part.element:
        what = f"<ros2_control> lists this {part.element.tag} a second time; the first is in line {first.line}"
        yield Fault(value_span(part.element, "name"), what, "keep one of them", subject=part.subject)
        return
    for interface in part.interfaces:
        offer = interface.get("name") or ""
        other = offered.setdefault((interface.tag, name, offer), interface)
        if offer and other is not interface:
            what = f"<{interface.tag}> '{offer}' is offered a second time; the first is in line {other.line}"
            yield Fault(value_span(interface, "name"), what, "offer each interface once", subject=part.subject)
            return
