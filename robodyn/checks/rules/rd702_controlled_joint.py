"""What ros2_control lists is named, is listed once, and moves; its hardware has a plugin.

controller_manager ends at start where one interface of a joint, sensor or gpio is offered twice, and
where one of them or an interface has no name. A fixed joint has nothing to command: simulators drop it, and the
controller that waits for it never starts; so it does where the name of an interface has a letter too many. A sensor or
gpio that offers nothing is not there for anybody.
"""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.examples import arm
from robodyn.checks.ros.control import Controlled, controlled
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.view import Subject, View
from robodyn.support.wording import shown, slip_of

_STANDARD = ("position", "velocity", "effort", "acceleration")
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
    yield from _without_plugin(context.view)
    for part in controlled(context.view):
        yield from _unnamed(part)
        yield from _misspelt(part)
        joint = context.view.joint.get(part.subject.name) if part.element.tag == "joint" else None
        if joint is not None and joint.type == "fixed":
            what = f"ros2_control lists this joint, which is fixed in line {joint.element.line}"
            remedy = "let it move (type=...), or delete it from <ros2_control>"
            yield Fault(value_span(part.element, "name"), what, remedy, subject=part.subject)
        yield from _again(part, listed, offered)


def _without_plugin(view: View) -> Iterator[Fault]:
    for control in view.root.findall("ros2_control"):
        hardware = control.find("hardware")
        if hardware is not None and hardware.find("plugin") is None:
            what, remedy = "<hardware> names no plugin", "write <plugin>package/Class</plugin>"
            yield Fault(hardware.span, what, remedy, subject=Subject("ros2_control", control.get("name") or ""))


def _misspelt(part: Controlled) -> Iterator[Fault]:
    """Yield the interfaces of a joint that controllers ask for by almost the same name, and parts that have none."""
    if part.element.tag != "joint" and part.subject.name and not part.interfaces:
        what, remedy = f"<{part.element.tag}> offers no interface", "give it a <state_interface>, or delete it"
        yield Fault(part.element.span, what, remedy, subject=part.subject, severity=Severity.WARNING)
    for interface in part.interfaces if part.element.tag == "joint" else ():
        name = interface.get("name") or ""
        if meant := slip_of(name, _STANDARD):
            what, remedy = f"no controller asks for the interface {shown(name)}", f"did you mean {shown(meant)}?"
            yield Fault(value_span(interface, "name"), what, remedy, subject=part.subject, severity=Severity.WARNING)


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
