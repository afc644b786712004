"""Where parts stand: detached, on the wrong parent, drawn in millimetres."""

from __future__ import annotations

from robodyn.checks.bodies.contacts import detached, too_large
from robodyn.checks.bodies.shapes import other_unit
from robodyn.checks.examples import a_joint, a_link, a_tower, arm
from robodyn.checks.mirror.namesakes import odd_parents
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.numbers import value_span
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

    Where the shapes of nearly all joints' children touch those of their parents, a child far from its parent has
    the wrong one, or its origin is wrong: it has millimetres in an entry, or a sign or digit too many. The gap
    is that between the boxes around the shapes, each joint at 0 or at its limit next to 0; it is reported where it
    is more than a tenth of the larger part and 1 cm, of parts that are fixed half the larger part and 5 cm, and
    nine of ten of the other joints have none.
    """
    for name, (contact, bound) in context.once(detached).items():
        joint = context.view.joint[name]
        below = f"of link '{joint.child}' and what is fixed to it"
        what = f"its parts do not meet: the shapes {below} are {contact.gap:.3g} m from those of '{contact.above}'"
        remedy = "check the parent link, and the unit and signs of the origin"
        at = joint.name_span if joint.origin.element is None else joint.origin.xyz.span
        yield Fault(at, what, remedy, contact.gap, bound, cause=too_large(context, joint))


_SEGMENTS = [f"segment_{k}" for k in range(1, 7)]
_CHAIN = zip(("upper", *_SEGMENTS), _SEGMENTS, strict=False)
_LONG_ARM = arm(more="".join(a_link(child) + a_joint(f"on_{parent}", parent, child) for parent, child in _CHAIN))


@rule(
    "RD112",
    Severity.WARNING,
    Stage.TREE,
    good=_LONG_ARM,
    bad=('<parent link="segment_4"/>', '<parent link="segment_2"/>'),
    explains=("RD111",),
)
def odd_parent(context: Context) -> Faults:
    """A link has the parent that its namesakes tell.

    Of links whose names differ in left and right, left_hand and right_hand, FL_calf and FR_calf, each is a child of
    the namesake of the other's parent, and link_5 is a child of link_4. Where others do so, and all but one in ten,
    one that does not has the wrong parent: by a copied line that was not changed, or changed twice. Which one of
    two is wrong is told by the links in front of them and behind them, by the side that a name and its parent's name
    say, and by shapes that do not touch those of the parent; where nothing tells, both are named.
    """
    for odd in context.once(odd_parents):
        joint = context.tree.above[odd.link]
        what = f"it makes {shown(odd.link)} a child of {shown(joint.parent)}, but {odd.why}"
        either = "" if odd.other is None else f", or the other pairs show that {shown(odd.other)} is the wrong one"
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
    shorter lengths bring them to what published robots have, all lengths are in millimetres; or they were divided
    by 1000 that were in metres. At least three links with mass and shapes show it. What follows from it, for
    densities, inertias, centres of mass and torques, is not reported beside it. A mesh in millimetres alone is
    RD605's, an origin RD111's.
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
