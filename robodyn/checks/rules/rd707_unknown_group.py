"""Groups of the SRDF that are named are there.

MoveIt passes over a state, an end effector or a group of groups whose group it does not know: the
pose cannot be called up, the gripper cannot be planned for. A state that names no group at all is one that only
Pinocchio reads, and a remark. The examples are SRDFs of an arm.
"""

from collections.abc import Iterator

from robodyn.checks import examples
from robodyn.checks.ros.srdf import srdf
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.view import Subject
from robodyn.support.wording import alternatives, shown


@rule(Severity.WARNING, good=examples.srdf(), bad=('group="all"', 'group="arm"'))
def check(context: Context) -> Faults:
    """Silent without an SRDF."""
    found = context.once(srdf)
    if found is None or found.is_of_another:
        return
    groups = [group.get("name") or "" for group in found.root.findall("group")]
    unnamed, unknown = [], dict[str, tuple[Element, Element, str]]()
    uses = 0
    for use in _uses(found.root):
        user, element, attribute = use
        name = element.get(attribute)
        if not name and user.tag == "group_state":
            unnamed.append(element)
        elif name and name not in groups:
            unknown.setdefault(name, use)
            uses += 1
    if unknown:
        user, element, attribute = next(iter(unknown.values()))
        more = f" (named in {uses} places)" if uses > 1 else ""
        what = f"the SRDF has no group {' or '.join(map(shown, unknown))}{more}"
        at, remedy = value_span(element, attribute), alternatives(next(iter(unknown)), groups, "groups")
        yield Fault(at, what, remedy, subject=_subject(user), document=found.document)
    if unnamed:
        more = f" (and {len(unnamed) - 1} more)" if unnamed[1:] else ""
        subject, what = _subject(unnamed[0]), f"the state names no group{more}: MoveIt passes over it"
        yield Fault(
            unnamed[0].span, what, 'write group="..."', None, None, subject, Severity.NOTE, document=found.document
        )


def _subject(user: Element) -> Subject:
    return Subject(user.tag, user.get("name") or "")


def _uses(root: Element) -> Iterator[tuple[Element, Element, str]]:
    """Yield who uses the name of a group, and the element and attribute that have it."""
    for group in root.findall("group"):
        yield from ((group, inner, "name") for inner in group.findall("group"))
    for state in root.findall("group_state"):
        yield state, state, "group"
    for effector in root.findall("end_effector"):
        yield from ((effector, effector, name) for name in ("group", "parent_group") if effector.get(name))
