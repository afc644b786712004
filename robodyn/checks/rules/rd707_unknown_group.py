"""Groups of the SRDF that are named are there, once, and their chains run from the base to the tip.

MoveIt passes over a state, an end effector or a group of groups whose group it does not know: the
pose cannot be called up, the gripper cannot be planned for. A state that names no group at all is one that only
Pinocchio reads, and a remark. Of two groups of one name one is passed over, and a chain whose base hangs on its tip is
planned for the wrong end. The examples are SRDFs of an arm.
"""

from collections.abc import Collection, Iterator, Mapping

from robodyn.checks import examples
from robodyn.checks.ros.srdf import Srdf, srdf
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
    yield from _twice_or_reversed(context, found)
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


def _twice_or_reversed(context: Context, found: Srdf) -> Iterator[Fault]:
    first: dict[str, Element] = {}
    above = {joint.child: joint.parent for joint in context.view.joints}
    for group in found.root.findall("group"):
        name = group.get("name") or ""
        if first.setdefault(name, group) is not group:
            what = f"a second group of this name; the first is in line {first[name].line}"
            at = value_span(group, "name")
            yield Fault(at, what, "rename or delete one of them", subject=_subject(group), document=found.document)
        for chain in group.findall("chain"):
            base, tip = chain.get("base_link") or "", chain.get("tip_link") or ""
            if base != tip and tip in _upward(base, above):
                what = f"the chain's base {shown(base)} hangs on its tip {shown(tip)}"
                remedy, at = "exchange base_link and tip_link", value_span(chain, "base_link")
                yield Fault(at, what, remedy, subject=_subject(group), document=found.document)


def _upward(link: str, above: Mapping[str, str]) -> Collection[str]:
    """Return the link and what it hangs on, as far as the parents lead."""
    passed = {link: None}
    while (link := above.get(link, "")) and link not in passed:
        passed[link] = None
    return passed


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
