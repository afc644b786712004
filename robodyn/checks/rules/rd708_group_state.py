"""States of the SRDF are poses that the robot can take.

A planner refuses to start from, or to go to, a state beyond the limits of a joint. Each joint has one
number; a continuous one may have two, cosine and sine, as Pinocchio writes it. Held against the limits of revolute and
prismatic joints, within a thousandth, since states are often rounded to three digits. The examples are SRDFs
of an arm.
"""

from collections.abc import Iterator

from robodyn.checks import examples
from robodyn.checks.ros.srdf import srdf
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import NumbersError, parse_numbers, value_span
from robodyn.robot.urdf.view import JointView, Subject
from robodyn.support.wording import figure

_ROUNDED = 1e-3 + 1e-9
"""How far a state may be beyond a limit [rad or m]: the nearest number of three digits."""
_KIND = "a state that no pose has"
_ONE = ("revolute", "prismatic")


@rule(Severity.WARNING, good=examples.srdf(), bad=('value="0"', 'value="2.5"'))
def check(context: Context) -> Faults:
    """Silent without an SRDF."""
    found = context.once(srdf)
    if found is None or found.is_of_another:
        return
    for state in found.root.findall("group_state"):
        subject = Subject("group_state", state.get("name") or "")
        for element in state.findall("joint"):
            joint = context.view.joint.get(element.get("name") or "")
            for what, remedy, measured, bound in () if joint is None else _wrong(element, joint):
                at, severity = value_span(element, "value"), Severity.ERROR if bound is None else None
                yield Fault(
                    at, what, remedy, measured, bound, subject, severity=severity, kind=_KIND, document=found.document
                )


def _wrong(element: Element, joint: JointView) -> Iterator[tuple[str, str, float | None, float | None]]:
    """Yield what is wrong with the value of a joint, what to do, the value, and the limit that it breaks."""
    text = element.get("value")
    if text is None:
        yield f"joint '{joint.name}' has no value", 'write value="..."', None, None
        return
    try:
        values = parse_numbers(text, max(len(text.split()), 1))
    except NumbersError as error:
        yield f"the value of joint '{joint.name}' {error}", error.remedy, None, None
        return
    if joint.type in _ONE and len(values) != 1:
        what = f"joint '{joint.name}' has {len(values)} values; a {joint.type} joint has one"
        yield what, "write one number", None, None
    limit = None if joint.limit is None else joint.limit.range
    if joint.type not in _ONE or len(values) != 1 or limit is None or limit[0] >= limit[1]:
        return
    for bound, name, excess in ((limit[0], "lower", limit[0] - values[0]), (limit[1], "upper", values[0] - limit[1])):
        if excess > _ROUNDED:
            what = f"joint '{joint.name}' is at {figure(values[0], 6)}, beyond its {name} limit {figure(bound, 6)}"
            yield what, "move it within the limits, or correct these", values[0], bound
