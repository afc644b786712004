"""Elements and attributes are those of URDF, and each stands where URDF has it and as often.

urdfdom and most other readers ignore what they do not know: a misspelt <inertal> makes a link
without mass, a misspelt attribute takes its default. What is like a name that is missing, what URDF has elsewhere
(an <origin> in a <link>, an rpy of an <axis>), and an element none of whose attributes is read are warnings. Other
names are most often the additions of one tool, and remarks. Elements with a namespace prefix, and those at the top that
belong to other tools (gazebo, ros2_control, ...), are left alone.
"""

from collections.abc import Collection, Iterator

from robodyn.checks.examples import INERTIA, one_link
from robodyn.checks.reading.grammar import KINDS, Kind, own_elements
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.view import Subject
from robodyn.support.wording import alternatives, shown

_OF_DRAKE = {
    "controller_gains": "the <actuator> of a <transmission>",
    "rotor_inertia": "the <actuator> of a <transmission>",
    "gear_ratio": "the <actuator> of a <transmission>",
    "proximity_properties": "a <collision>",
}
"""Elements that Drake knows by its prefix, and where."""
_ELSEWHERE = {"min": "lower", "max": "upper"}
"""What other formats call an attribute."""
_NUMBERS = frozenset(name for kind in KINDS.values() for name, count in kind.attributes.items() if count)
"""Attributes that hold numbers, somewhere in URDF."""


@rule(Severity.WARNING, good=one_link(f'<mass value="2"/>{INERTIA}<origin xyz="0 0 0.1"/>'), bad=("<origin", "<orgin"))
def check(context: Context) -> Faults:
    for element, kind, subject in context.once(own_elements):
        yield from _children(element, kind, subject)
        nothing_read = kind.attributes and not (kind.children or element.values.keys() & kind.attributes.keys())
        for name in element.values:
            if name not in kind.attributes and ":" not in name and name != "xmlns":
                what = f"<{element.tag}> has no attribute {shown(name)} in URDF; readers ignore it"
                remedy = alternatives(name, kind.attributes, "attributes") if kind.attributes else "delete it"
                absent, other = kind.attributes.keys() - element.values, _ELSEWHERE.get(name)
                if other is not None and other in absent:
                    remedy = f"did you mean {shown(other)}?"
                meant = nothing_read or name in _NUMBERS or other in absent or _is_near(name, absent)
                at, severity = element.attributes[name].span, None if meant else Severity.NOTE
                yield Fault(at, what, remedy, subject=subject, severity=severity)


def _children(element: Element, kind: Kind, subject: Subject | None) -> Iterator[Fault]:
    seen: dict[str, Element] = {}
    for child in element.children:
        known = child.tag in kind.children
        if not known and ":" not in child.tag and (element.tag != "robot" or _is_near(child.tag, kind.children)):
            what = f"<{element.tag}> has no element {shown(child.tag)} in URDF; readers ignore it"
            remedy = alternatives(child.tag, kind.children, "elements") if kind.children else "delete it"
            if child.tag in _OF_DRAKE:
                remedy = f"Drake reads it as <drake:{child.tag}> in {_OF_DRAKE[child.tag]}; otherwise delete it"
            meant = child.tag in KINDS or child.tag in _OF_DRAKE or _is_near(child.tag, [*KINDS, *kind.children])
            yield Fault(child.span, what, remedy, subject=subject, severity=None if meant else Severity.NOTE)
        elif known and child.tag not in kind.repeated and child.tag in seen:
            first = f"the first is in line {seen[child.tag].line}"
            what = f"a second <{child.tag}> in <{element.tag}>, {first}; readers differ in which they take"
            yield Fault(child.span, what, "keep one of them", subject=subject)
        seen.setdefault(child.tag, child)


def _is_near(tag: str, known: Collection[str]) -> bool:
    """Return whether it is a slip of the pen: at the top other tools may keep elements of any name."""
    from difflib import get_close_matches

    shuffled = any(sorted(tag) == sorted(name) for name in known)
    return len(tag) < 30 and (shuffled or bool(get_close_matches(tag.lower(), known, n=1, cutoff=0.75)))
