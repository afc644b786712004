"""The tree: names, parents and children, one root; where parts stand: detached, on a wrong parent, in millimetres."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from robodyn.checks.bodies.bodies import other_unit
from robodyn.checks.bodies.contacts import detached, too_large
from robodyn.checks.examples import a_joint, a_link, a_tower, arm, longer_arm, one_link, two_elbows
from robodyn.checks.mirror import named_pairs
from robodyn.checks.rule import ERROR, NOTE, TREE, WARNING, Context, Fault, Faults, namesakes, rule
from robodyn.robot.urdf.description import cycles
from robodyn.robot.urdf.document import unexpanded
from robodyn.robot.urdf.parts import JOINT_TYPES
from robodyn.robot.urdf.view import JointView, LinkView, View, value_span
from robodyn.support.wording import alternatives, listed, shown


@rule("RD101", ERROR, good=arm(), bad=('link="upper"', 'link="uper"'))
def dangling_reference(context: Context) -> Faults:
    """The parent and the child of every joint are links of the robot.

    Readers refuse the file, or leave out the joint and everything below it."""
    view, links = context.view, context.view.link
    missing = {name for joint in view.joints for name in (joint.parent, joint.child) if name} - links.keys()
    nameless = any(not joint.parent or not joint.child for joint in view.joints)
    unique = {link.name for link in view.links if not unexpanded(link.name)} - {""}
    if not view.links or (not nameless and len(missing) <= len(view.links) - len(unique)):
        return  # all that is missing are links that other rules report: unnamed, duplicate, not expanded
    for joint in view.joints:
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name in links or unexpanded(name):
                continue
            element = joint.element.find(role)
            at = joint.element.span if element is None else value_span(element, "link")
            what = f"its {role} is link {shown(name)}, which does not exist" if name else f"it names no {role} link"
            remedy = alternatives(name, links, "links") if name else f'write <{role} link="..."/>'
            yield Fault(at, what, remedy)


@rule(
    "RD102",
    ERROR,
    good=longer_arm(),
    bad=arm(more=a_link("fore") + a_joint("elbow", "upper", "fore") + a_joint("strut", "base", "fore")),
)
def several_parents(context: Context) -> Faults:
    """No link is the child of two joints.

    A URDF is a tree. Of a closed chain one joint is left out, and made of what the simulator has for it."""
    above = _first_above(context.view)
    for joint in context.view.joints:
        first, element = above.get(joint.child, joint), joint.element.find("child")
        if element is None or first is joint or (joint.name and joint.name == first.name):
            continue
        other = f"joint {shown(first.name)} (line {first.element.line})"
        what = f"its child, link {shown(joint.child)}, is the child of {other} too"
        yield Fault(value_span(element, "link"), what, "a link has one parent: remove one joint, or correct its child")


@rule(
    "RD103",
    ERROR,
    good=arm(more=a_link("a") + a_link("b") + a_joint("to_b", "a", "b") + a_joint("to_a", "upper", "a")),
    bad=('<parent link="upper"/>', '<parent link="b"/>'),
)
def cycle(context: Context) -> Faults:
    """Going from child to parent leads to the root.

    Links in a cycle have no root. Some readers do not notice and recurse until memory ends."""
    above = _first_above(context.view)
    for cycle in cycles({child: joint.parent for child, joint in above.items()}):
        first = min((above[link] for link in cycle), key=lambda joint: joint.element.start)
        element = first.element.find("parent")
        assert element is not None, "the joint names a parent"
        what = f"it is in a cycle of {len(cycle)} links, each the parent of the one before: {listed(cycle)}"
        what = what if len(cycle) > 1 else f"link {shown(cycle[0])} is its parent and its child"
        yield Fault(value_span(element, "link"), what, "a URDF is a tree: correct a parent")


@rule("RD104", ERROR, good=longer_arm(), bad=arm(more=a_link("fore")))
def several_roots(context: Context) -> Faults:
    """Exactly one link has no parent.

    All other links are below it. Readers refuse a second root, or leave out all that is below it. Where another rule of
    the structure (RD101 to RD107) is broken, its repair comes first and this one is silent."""
    view = context.view
    above = _first_above(view)
    orderly = len(view.link) == len(view.links) and len(above) == len(view.joints)
    led = all(joint.parent in view.link and joint.child in view.link for joint in view.joints)
    roots = [link for link in view.links if link.name not in above]
    if orderly and led and len(roots) > 1:
        what = f"{len(roots)} links have no parent: {listed([link.name for link in roots])}"
        yield Fault(roots[1].name_span, what, "join them to one tree", len(roots), 1)


def _first_above(view: View) -> dict[str, JointView]:
    above: dict[str, JointView] = {}
    for joint in view.joints:
        if joint.child:
            above.setdefault(joint.child, joint)
    return above


@rule("RD105", ERROR, good=longer_arm(), bad=arm(more=a_link("upper")))
def duplicate_link(context: Context) -> Faults:
    """No two links have the same name.

    Readers refuse the file, or keep one of the two and lose the other without a word."""
    return _second("link", context.view.links)


def _second(kind: str, parts: Sequence[LinkView | JointView]) -> Faults:
    for again, first in namesakes(part.element for part in parts):
        what = f"a second {kind} of this name; the first is in line {first.line}"
        yield Fault(value_span(again, "name"), what, "rename or remove one of them")


@rule("RD106", ERROR, good=longer_arm(), bad=("elbow", "shoulder"))
def duplicate_joint(context: Context) -> Faults:
    """No two joints have the same name.

    Readers refuse the file, or keep one of the two and lose the other without a word."""
    return _second("joint", context.view.joints)


@rule("RD107", ERROR, good=arm(), bad=('name="shoulder" ', ""))
def unnamed(context: Context) -> Faults:
    """The robot and every link and joint have a name.

    Joints refer to links by name, and programs to joints. urdfdom refuses a robot or a joint without one."""
    view = context.view
    links, joints = (part.element for part in view.links), (part.element for part in view.joints)
    for element in (view.root, *links, *joints):
        if not element.get("name"):
            state = "no name" if element.get("name") is None else "an empty name"
            child = element.find("child")
            to = f" to link {shown(child.values['link'])}" if child is not None and child.get("link") else ""
            what = f"<{element.tag}>{to} has {state}"
            yield Fault(value_span(element, "name"), what, 'write name="..."', subject=None)


@rule("RD108", ERROR, good=arm(), bad=arm(kind="hinge"))
def unknown_joint_type(context: Context) -> Faults:
    """The type of a joint is revolute, continuous, prismatic, fixed, floating or planar.

    Readers refuse other types; some take them for fixed. Types are written in small letters."""
    for joint in context.view.joints:
        if joint.type in JOINT_TYPES or unexpanded(joint.type):
            continue
        what = f"URDF has no joint type {shown(joint.type)}" if joint.type else "it has no type"
        remedy = alternatives(joint.type.lower(), JOINT_TYPES, "types")
        yield Fault(value_span(joint.element, "type"), what, remedy)


@rule("RD109", ERROR, good=one_link(), bad='<robot name="part">\n</robot>\n')
def no_links(context: Context) -> Faults:
    """A robot has one link at least.

    Often a sign of a file that was written by a failed conversion, or of xacro macros that were never called."""
    if not context.view.links:
        what = "the robot has no links"
        yield Fault(context.view.root.span, what, "add a <link>", 0, 1, subject=None)


_REFUSED = {
    r"(?s)(?=__).*__\Z|.*::": "SDF keeps :: and names between __ for itself",
    r"(?s).*/": "USD and MuJoCo's includes take / for a path, tf for a namespace",
    r"\d": "a name in USD, Modelica or Python does not begin with a digit",
    r"(?s)(?!__).*[^A-Za-z0-9_]": "USD takes letters, digits and _ only, and renames it",
}
"""How names begin that another format refuses, and why."""


@rule("RD110", NOTE, good=arm().replace("shoulder", "shoulder_pitch"), bad=('"shoulder_pitch"', '"shoulder/pitch"'))
def name_portability(context: Context) -> Faults:
    """Names of letters, digits and _ survive a conversion to other formats.

    USD (Isaac Sim) takes no other character and renames what has one; SDF keeps some names for itself and requires each
    to be there once among links and joints."""
    view = context.view
    parts: tuple[LinkView | JointView, ...] = (*view.links, *view.joints)
    for part in parts:
        refusal = next((why for pattern, why in _REFUSED.items() if re.match(pattern, part.name)), None)
        if part.subject.kind == "joint" and part.name in view.link:
            refusal = refusal or "SDF requires different names for a link and a joint"
        if refusal:
            remedy = "use letters, digits and _ only, and each name once"
            yield Fault(part.name_span, refusal, remedy)


_NEVER = 20.0  # a gap that no robot has between its parts [m]


@rule(
    "RD111",
    WARNING,
    TREE,
    good=a_tower(),
    bad=('<child link="hand"/><origin xyz="0 0 0.1"/>', '<child link="hand"/><origin xyz="0 0 1.0"/>'),
)
def detached_part(context: Context) -> Faults:
    """The parts on both sides of a joint are next to each other.

    Where the shapes of nine of ten other joints' children touch those of their parents, a child far from its parent has
    the wrong one, or its origin has millimetres in an entry, or a sign or digit too many. The gap is that between the
    boxes around the shapes, each joint at 0 or at its limit next to 0; it is reported where it is more than a tenth of
    the larger part and 1 cm, of parts that are fixed half the larger part and 5 cm. A gap of 20 m is an error."""
    for name, (contact, bound) in context.once(detached).items():
        joint = context.view.joint[name]
        below = f"of link '{joint.child}' and what is fixed to it"
        what = f"its parts do not meet: the shapes {below} are {contact.gap:.3g} m from those of '{contact.above}'"
        remedy = "check the parent link, and the unit and signs of the origin"
        at = joint.name_span if joint.origin.element is None else joint.origin.xyz.span
        severity = ERROR if contact.gap > _NEVER else None
        yield Fault(at, what, remedy, contact.gap, bound, cause=too_large(context, joint), severity=severity)


_SAME_PLACE = 1e-6  # between the joints of namesakes on their parents, each coordinate without its sign [m]


@rule(
    "RD112",
    WARNING,
    TREE,
    good=two_elbows(),
    bad=('parent link="right_arm"', 'parent link="base"'),
    explains=("RD111", "RD405"),
)
def odd_parent(context: Context) -> Faults:
    """A link has the parent that its namesake tells.

    Of links whose names differ in left and right, left_hand and right_hand, FL_calf and FR_calf, each is a child of the
    namesake of the other's parent, or both of one link. Where they are not, although their joints stand at the same
    place on their parents but for signs, one has the wrong parent: by a copied line that was not changed, or changed
    twice. It is the one whose parent's name says the other side; or else the one that left a link whose twin carries
    the other, or else the one on a link whose twin carries others; or both are named. Where a link hangs beside one
    that moves and carries nothing, although names put this between it and their parent, as in link_3, link_4 and link_5
    or upper_arm, forearm and wrist, that one is its parent."""
    yield from _passed_over(context)
    above = context.tree.above
    named = list(named_pairs([link.name for link in context.tree.links]))
    carriers = {joint.parent for joint in above.values()}
    times = Counter(name for names in named for name in names)  # the left finger of a right hand is in two pairs
    left = {right: left for left, right in named if times[left] == times[right] == 1}
    twin = {**left, **{one: other for other, one in left.items()}}
    for right, one in left.items():
        if one not in above or right not in above:
            continue
        split, joints = (one, right), (above[one], above[right])
        parents = [joint.parent for joint in joints]
        alike = twin.get(parents[0], parents[0]) == parents[1]
        places = [np.abs(joint.origin.xyz.or_default(0.0, 0.0, 0.0) or np.nan) for joint in joints]
        if alike or not twin.keys() & {*parents} or max(times[parent] for parent in parents) > 1:
            continue
        if not np.allclose(places[0], places[1], rtol=0.0, atol=_SAME_PLACE):
            continue
        crossed = [
            parent in twin and (parent in left) != (link in left) for link, parent in zip(split, parents, strict=True)
        ]
        if not any(crossed):  # where the twin of the one's parent carries nothing, the other left it
            crossed = [on in twin and twin[on] not in carriers for on in reversed(parents)]
            crossed = crossed if any(crossed) else [parent in twin for parent in parents]
        sure = sum(crossed) == 1
        k = crossed.index(True) if sure else int(joints[1].element.start > joints[0].element.start)
        odd, namesake, on = split[k], split[1 - k], parents[1 - k]
        what = f"it makes {shown(odd)} a child of {shown(parents[k])}, but {shown(namesake)} hangs on {shown(on)}"
        either = "" if sure else f", or {shown(namesake)} is the wrong one"
        parent = next(child for child in joints[k].element.children if child.tag == "parent")
        yield Fault(value_span(parent, "link"), what, f"make {shown(twin.get(on, on))} its parent{either}")


_ORDER = (
    ("shoulder", "hip"),
    ("upper", "thigh", "bicep"),
    ("elbow", "fore", "lower", "knee", "shank", "calf", "shin"),
    ("wrist", "ankle", "ankel"),
    ("hand", "palm", "gripper", "tool", "foot", "flange"),
    ("finger", "thumb", "toe"),
)
"""Words of parts from the body outwards."""
_MOST_BESIDE = 16


def _passed_over(context: Context) -> Faults:
    """Links whose parent names say to be a sibling that carries nothing; two ends in a row of numbers are fingers or
    wheels."""
    for group in context.tree.groups:
        if group.joint is None or group.parent is None or len(group.parent.children) > _MOST_BESIDE:
            continue
        link, over = group.joint.child, group.parent.joint.child if group.parent.joint else ""
        for other in group.parent.children:
            is_part = not other.children and any(each.inertial or each.geometries for each in other.links)
            beside = other.joint.child if other.joint is not None and is_part else link
            numbered = bool(group.children) and _numbered(over, beside, link)
            if beside != link and (numbered or _in_order((over, beside, link))):
                on = shown(group.joint.parent)
                what = f"it makes {shown(link)} a child of {on}, beside {shown(beside)}, which carries nothing"
                parent = next(child for child in group.joint.element.children if child.tag == "parent")
                yield Fault(value_span(parent, "link"), what, f"make {shown(beside)} its parent")


def _numbered(inner: str, middle: str, outer: str) -> bool:
    """Whether links are in a row by their one number, as in link_3, link_4, link_5; a root comes before 0 and 1."""
    parts = [re.split(r"(\d+)", name) for name in (inner, middle, outer)]
    first, second, third = (int(each[1]) if len(each) == 3 else -1 for each in parts)
    row = {(each[0], each[-1]) for each in parts[0 if inner else 1 :]}
    if len(row) != 1 or min(second, third) < 0:
        return False
    return (first + third == 2 * second and abs(third - first) == 2) if inner else third == second + 1 <= 2


def _in_order(names: Sequence[str]) -> bool:
    """Whether links of one side are in a row by their words."""
    ranks = [[k for k, words in enumerate(_ORDER) if any(word in name.lower() for word in words)] for name in names]
    sides = {frozenset(side for side in ("left", "right") if side in name.lower()) for name in names}
    return len(sides) == 1 and all(len(found) == 1 for found in ranks) and ranks[0] < ranks[1] < ranks[2]


@rule(
    "RD113",
    ERROR,
    TREE,
    good=a_tower(),
    bad=a_tower().replace("0.1 0.1 0.1", "100 100 100").replace("0.1 0.1 0.25", "100 100 250"),
)
def drawn_in_millimetres(context: Context) -> Faults:
    """A robot is drawn in metres.

    Where the links' masses over the boxes around their shapes are 1e9 times too small in the median, and 1000 times
    shorter lengths bring them to what published robots have, all lengths are in millimetres; or they were divided by
    1000 that were in metres. At least three links with mass and shapes show it. What follows from it is not reported
    beside it. A mesh in millimetres alone is RD605's, an origin RD111's."""
    unit = context.once(other_unit)
    if unit is None:
        return
    (times, density), large = unit, unit[0] > 1
    what = f"its links weigh {density:.3g} kg/m^3 of the boxes around their shapes (median): lengths are "
    what += f"{'in millimetres' if large else 'a thousandth of metres'}, which makes {density * times**3:.3g}"
    remedy = f"{'divide' if large else 'multiply'} all lengths by 1000, those of meshes by their scale"
    yield Fault(value_span(context.view.root, "name"), what, remedy, times, 1.0, subject=None)
