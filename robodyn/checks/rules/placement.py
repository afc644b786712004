"""Where parts stand: detached, on the wrong parent, drawn in millimetres."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from robodyn.checks.bodies.contacts import detached, too_large
from robodyn.checks.bodies.shapes import other_unit
from robodyn.checks.examples import a_tower, two_elbows
from robodyn.checks.mirror import named_pairs
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.view import value_span
from robodyn.support.wording import shown


@rule(
    "RD111",
    Severity.WARNING,
    Stage.TREE,
    good=a_tower(),
    bad=('<child link="hand"/><origin xyz="0 0 0.1"/>', '<child link="hand"/><origin xyz="0 0 1.0"/>'),
)
def detached_part(context: Context) -> Faults:
    """The parts on both sides of a joint are next to each other.

    Where the shapes of nine of ten other joints' children touch those of their parents, a child far from its parent has
    the wrong one, or its origin has millimetres in an entry, or a sign or digit too many. The gap is that between the
    boxes around the shapes, each joint at 0 or at its limit next to 0; it is reported where it is more than a tenth of
    the larger part and 1 cm, of parts that are fixed half the larger part and 5 cm.
    """
    for name, (contact, bound) in context.once(detached).items():
        joint = context.view.joint[name]
        below = f"of link '{joint.child}' and what is fixed to it"
        what = f"its parts do not meet: the shapes {below} are {contact.gap:.3g} m from those of '{contact.above}'"
        remedy = "check the parent link, and the unit and signs of the origin"
        at = joint.name_span if joint.origin.element is None else joint.origin.xyz.span
        yield Fault(at, what, remedy, contact.gap, bound, cause=too_large(context, joint))


_SAME_PLACE = 1e-6
"""Between the joints of namesakes on their parents, each coordinate without its sign [m]."""


class Odd(NamedTuple):
    """A link (or the one of two that stands later in the file) that hangs on another parent than the `expected` one,
    which its namesake says; and the `other` namesake that may be the wrong one instead."""

    link: str
    expected: str
    other: str | None
    namesake: str


def odd_parents(context: Context) -> Iterator[Odd]:
    """Yield the links on other parents than those whose names differ in left and right, joined at each other's mirror
    image. From stage TREE on."""
    above = context.tree.above
    named = list(named_pairs([link.name for link in context.tree.links]))
    times = Counter(name for names in named for name in names)  # the left finger of a right hand is in two pairs
    left = {right: left for left, right in named if times[left] == times[right] == 1}
    twin = {**left, **{one: other for other, one in left.items()}}
    for right, one in left.items():
        split = one, right
        if one not in above or right not in above:
            continue
        joints, parents = [above[link] for link in split], [above[link].parent for link in split]
        alike = twin.get(parents[0], parents[0]) == parents[1]
        places = [np.abs(joint.origin.xyz.or_default(0.0, 0.0, 0.0) or np.nan) for joint in joints]
        if alike or not twin.keys() & {*parents} or max(times[parent] for parent in parents) > 1:
            continue
        if not np.allclose(places[0], places[1], rtol=0.0, atol=_SAME_PLACE):
            continue
        crossed = [
            parent in twin and (parent in left) != (link in left) for link, parent in zip(split, parents, strict=True)
        ]
        k = crossed.index(True) if sum(crossed) == 1 else int(joints[1].element.start > joints[0].element.start)
        other, on = split[1 - k], parents[1 - k]
        yield Odd(split[k], twin.get(on, on), None if sum(crossed) == 1 else other, other)


@rule(
    "RD112",
    Severity.WARNING,
    Stage.TREE,
    good=two_elbows(),
    bad=('parent link="right_arm"', 'parent link="base"'),
    explains=("RD111",),
)
def odd_parent(context: Context) -> Faults:
    """A link has the parent that its namesake tells.

    Of links whose names differ in left and right, left_hand and right_hand, FL_calf and FR_calf, each is a child of
    the namesake of the other's parent, or both of one link. Where they are not, although their joints stand at the
    same place on their parents but for signs, one has the wrong parent: by a copied line that was not changed, or
    changed twice. It is the one whose parent's name says the other side; where none does, both are named.
    """
    for odd in odd_parents(context):
        joint = context.tree.above[odd.link]
        what = (
            f"it makes {shown(odd.link)} a child of {shown(joint.parent)}, but {shown(odd.namesake)} hangs on "
            f"{shown(context.tree.above[odd.namesake].parent)}"
        )
        either = "" if odd.other is None else f", or {shown(odd.other)} is the wrong one"
        parent = next(child for child in joint.element.children if child.tag == "parent")
        yield Fault(value_span(parent, "link"), what, f"make {shown(odd.expected)} its parent{either}")


@rule(
    "RD113",
    Severity.ERROR,
    Stage.TREE,
    good=a_tower(),
    bad=a_tower().replace("0.1 0.1 0.1", "100 100 100").replace("0.1 0.1 0.25", "100 100 250"),
)
def drawn_in_millimetres(context: Context) -> Faults:
    """A robot is drawn in metres.

    Where the links' masses over the boxes around their shapes are 1e9 times too small in the median, and 1000 times
    shorter lengths bring them to what published robots have, all lengths are in millimetres; or they were divided by
    1000 that were in metres. At least three links with mass and shapes show it. What follows from it is not reported
    beside it. A mesh in millimetres alone is RD605's, an origin RD111's.
    """
    unit = context.once(other_unit)
    if unit is None:
        return
    large = unit.times > 1
    what = (
        f"its links weigh {unit.density:.3g} kg/m^3 of the boxes around their shapes (median): lengths are "
        f"{'in millimetres' if large else 'a thousandth of metres'}, which makes {unit.density * unit.times**3:.3g}"
    )
    remedy = f"{'divide' if large else 'multiply'} all lengths by 1000, those of meshes by their scale"
    yield Fault(value_span(context.view.root, "name"), what, remedy, unit.times, 1.0, subject=None)
