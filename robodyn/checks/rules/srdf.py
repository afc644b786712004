"""The SRDF that goes with a description."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from robodyn.checks.bodies.bodies import box_of, real_shapes, solids
from robodyn.checks.bodies.masses import STILL, pose
from robodyn.checks.examples import SRDF
from robodyn.checks.rule import ERROR, NOTE, WARNING, Context, Fault, Faults, namesakes, rule, subject_of
from robodyn.checks.srdf import own_srdf, srdf
from robodyn.robot.urdf.document import Element
from robodyn.robot.urdf.view import JointView, NumbersError, parse_numbers, value_span
from robodyn.support.wording import alternatives, count, figure, shown


@rule("RD706", WARNING, good=SRDF, bad=('robot name="arm"', 'robot name="leg"'))
def srdf_of_another_robot(context: Context) -> Faults:
    """The SRDF beside a description is for this robot.

    MoveIt complains where the names in the two <robot> differ. Most often the SRDF was copied from another robot. With
    names that are merely spelled otherwise this is a remark; where most of the links and joints that it names are not
    in the robot, an error. Looked at is the SRDF of the description's name beside it or in a folder config or srdf; the
    examples are SRDFs of an arm."""
    found = context.once(srdf)
    if found is None:
        return
    at, given, own = value_span(found.root, "name"), found.root.get("name") or "", context.view.root.get("name") or ""
    if found.is_of_another:
        names = len({(used.kind, used.name) for used in found.used})
        what = f"{len(found.missing)} of the {names} links and joints that it names are not in the robot {shown(own)}"
        remedy = "write the SRDF of this robot, or rename the file if it is another one's"
        yield Fault(at, what, remedy, len(found.missing), 0.0, None, severity=ERROR, document=found.document)
    elif own and given != own:
        what = f"the SRDF is for the robot {shown(given)}, the description is of {shown(own)}"
        first, second = ("".join(filter(str.isalnum, name.casefold())) for name in (given, own))
        alike = bool(first and second) and (first.startswith(second) or second.startswith(first))
        severity = NOTE if alike else None  # the case, what stands between words, or an ending differs
        yield Fault(at, what, f"write name={shown(own)}", subject=None, severity=severity, document=found.document)


@rule("RD707", WARNING, good=SRDF, bad=('group="all"', 'group="arm"'))
def unknown_group(context: Context) -> Faults:
    """Groups of the SRDF that are named are there, once, and their chains run from the base to the tip.

    MoveIt passes over a state, an end effector or a group of groups whose group it does not know. A state that names no
    group at all is one that only Pinocchio reads, and a remark. Of two groups of one name one is passed over, and a
    chain whose base is below its tip is planned for the wrong end. The examples are SRDFs of an arm."""
    found = own_srdf(context)
    if found is None:
        return
    root, groups = found.root, [group.get("name") or "" for group in found.root.findall("group")]
    above = {joint.child: joint.parent for joint in context.view.joints}
    for group, first in namesakes(root.findall("group")):
        what = f"a second group of this name; the first is in line {first.line}"
        at = value_span(group, "name")
        yield Fault(at, what, "rename or delete one of them", subject=subject_of(group), document=found.document)
    for group, chain in [(one, chain) for one in root.findall("group") for chain in one.findall("chain")]:
        base, tip = chain.get("base_link") or "", chain.get("tip_link") or ""
        link, passed = base, {base}
        while (link := above.get(link, "")) and link not in passed:
            passed.add(link)
        if base != tip and tip in passed:
            what = f"the chain's base {shown(base)} is below its tip {shown(tip)}"
            remedy, at = "exchange base_link and tip_link", value_span(chain, "base_link")
            yield Fault(at, what, remedy, subject=subject_of(group), document=found.document)
    uses = [(group, inner, "name") for group in root.findall("group") for inner in group.findall("group")]
    uses += [(state, state, "group") for state in root.findall("group_state")]
    for effector in root.findall("end_effector"):
        uses += [(effector, effector, name) for name in ("group", "parent_group") if effector.get(name)]
    unnamed = [state for state in root.findall("group_state") if not state.get("group")]
    unknown = [use for use in uses if use[1].get(use[2]) and use[1].get(use[2]) not in groups]
    if unknown:
        user, element, attribute = unknown[0]
        names = dict.fromkeys(element.get(attribute) or "" for _, element, attribute in unknown)
        more = f" (named in {len(unknown)} places)" if unknown[1:] else ""
        what = f"the SRDF has no group {' or '.join(map(shown, names))}{more}"
        at, remedy = value_span(element, attribute), alternatives(next(iter(names)), groups, "groups")
        yield Fault(at, what, remedy, subject=subject_of(user), document=found.document)
    if unnamed:
        more = f" (and {len(unnamed) - 1} more)" if unnamed[1:] else ""
        at, subject, what = unnamed[0].span, subject_of(unnamed[0]), f"the state names no group{more}"
        what, remedy = f"{what}: MoveIt passes over it", 'write group="..."'
        yield Fault(at, what, remedy, None, None, subject, NOTE, document=found.document)


_ROUNDED = 1e-3 + 1e-9  # how far a state may be beyond a limit [rad or m]: the nearest number of three digits
_KIND = "a state that no pose has"
_ONE = ("revolute", "prismatic")


@rule("RD708", WARNING, good=SRDF, bad=('value="0"', 'value="2.5"'))
def group_state(context: Context) -> Faults:
    """States of the SRDF are poses that the robot can take.

    A planner refuses to start from, or to go to, a state beyond the limits of a joint. Each joint has one number; a
    continuous one may have two, cosine and sine, as Pinocchio writes it. Held against the limits of revolute and
    prismatic joints, within a thousandth, since states are often rounded. The examples are SRDFs of an arm."""
    found = own_srdf(context)
    if found is None:
        return
    for state in found.root.findall("group_state"):
        subject = subject_of(state)
        for element in state.findall("joint"):
            joint = context.view.joint.get(element.get("name") or "")
            for what, remedy, measured, bound in () if joint is None else _wrong(element, joint):
                at, severity = value_span(element, "value"), ERROR if bound is None else None
                fault = Fault(at, what, remedy, measured, bound, subject, severity, kind=_KIND)
                yield replace(fault, document=found.document)


def _wrong(element: Element, joint: JointView) -> Iterator[tuple[str, str, float | None, float | None]]:
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


_MOST = 4  # pairs that are named


@rule("RD709", WARNING, good=SRDF, bad=('link1="base" link2="upper"', 'link1="base" link2="tool"'))
def neighbours_collide(context: Context) -> Faults:
    """The SRDF lets neighbours touch.

    A joint's two links touch where they are joined. A planner that has not been told so by <disable_collisions> finds a
    collision in every pose. Reported, in one finding, are the neighbours with collision shapes whose boxes overlap at
    rest, where the SRDF lists pairs at all. Two links that it lists with a link that is not there are RD701's alone.
    The examples are SRDFs of an arm."""
    found = own_srdf(context)
    pairs = [] if found is None else found.root.findall("disable_collisions")
    if found is None or not pairs or not found.is_namesake:
        return
    allowed = {frozenset((pair.get("link1"), pair.get("link2"))) for pair in pairs}
    told = {name for pair in allowed if any(name not in context.view.link for name in pair) for name in pair}
    free = {element.get("link") for element in found.root.findall("disable_default_collisions")}
    both = ((joint, frozenset((joint.parent, joint.child))) for joint in context.view.joints)
    unlisted = (joint for joint, pair in both if not (pair in allowed or free & pair or told >= pair))
    open_pairs = [joint for joint in unlisted if _touch(context, joint)]
    if open_pairs:
        named = ", ".join(f"{shown(joint.parent)} and {shown(joint.child)}" for joint in open_pairs[:_MOST])
        more = f" and {len(open_pairs) - _MOST} more" if open_pairs[_MOST:] else ""
        what = f"{count(len(open_pairs), 'pair')} of neighbours touch and may not: {named}{more}"
        remedy = '<disable_collisions link1="..." link2="..." reason="Adjacent"/> for each'
        yield Fault(pairs[0].span, what, remedy, len(open_pairs), 0.0, None, document=found.document)


def _touch(context: Context, joint: JointView) -> bool:
    parent, child, placed = context.view.link.get(joint.parent), context.view.link.get(joint.child), pose(joint.origin)
    if parent is None or child is None or placed is None or joint.parent == joint.child:
        return False
    one, other = (
        box_of(real_shapes(link, "collision"), context.once(solids), at)
        for link, at in ((parent, STILL), (child, placed))
    )
    return one is not None and other is not None and bool((one.lo <= other.hi).all() and (other.lo <= one.hi).all())
