"""The SRDF lets neighbours touch.

A joint's two links touch where they are joined. A planner that has not been told so by
<disable_collisions> finds a collision in every pose, and no path. Reported, in one finding, are the neighbours with
collision shapes whose boxes overlap at rest, where the SRDF lists pairs at all. Two links that it lists with a link
that is not there, between them perhaps, are RD701's alone. The examples are SRDFs of an
arm.
"""

import numpy as np

from robodyn.checks import examples
from robodyn.checks.bodies.masses import pose
from robodyn.checks.bodies.shapes import box_of, solids
from robodyn.checks.ros.srdf import srdf
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.kinematics import Pose
from robodyn.robot.urdf.view import GeometryView, JointView, LinkView
from robodyn.support.wording import count, shown

_MOST = 4
"""Pairs that are named."""


@rule(Severity.WARNING, good=examples.srdf(), bad=('link1="base" link2="upper"', 'link1="base" link2="tool"'))
def check(context: Context) -> Faults:
    """Silent without an SRDF."""
    found = context.once(srdf)
    pairs = [] if found is None or found.is_of_another else found.root.findall("disable_collisions")
    if found is None or not pairs or not found.is_namesake:
        return
    allowed = {frozenset((pair.get("link1"), pair.get("link2"))) for pair in pairs}
    told = {name for pair in allowed if any(name not in context.view.link for name in pair) for name in pair}
    free = {element.get("link") for element in found.root.findall("disable_default_collisions")}
    open_pairs = [
        joint
        for joint in context.view.joints
        if frozenset((joint.parent, joint.child)) not in allowed
        and not free & {joint.parent, joint.child}
        and not told >= {joint.parent, joint.child}
        and _touch(context, joint)
    ]
    if open_pairs:
        named = ", ".join(f"{shown(joint.parent)} and {shown(joint.child)}" for joint in open_pairs[:_MOST])
        more = f" and {len(open_pairs) - _MOST} more" if open_pairs[_MOST:] else ""
        what = f"{count(len(open_pairs), 'pair')} of neighbours touch and may not: {named}{more}"
        remedy = '<disable_collisions link1="..." link2="..." reason="Adjacent"/> for each'
        yield Fault(pairs[0].span, what, remedy, len(open_pairs), 0.0, None, document=found.document)


def _touch(context: Context, joint: JointView) -> bool:
    """Return whether the boxes around the collision shapes of a joint's links overlap at rest."""
    parent, child, placed = context.view.link.get(joint.parent), context.view.link.get(joint.child), pose(joint.origin)
    if parent is None or child is None or placed is None or joint.parent == joint.child:
        return False
    known = context.once(solids)
    one = box_of(_collisions(parent), known, Pose(np.eye(3), np.zeros(3)))
    other = box_of(_collisions(child), known, placed)
    return one is not None and other is not None and bool((one.lo <= other.hi).all() and (other.lo <= one.hi).all())


def _collisions(link: LinkView) -> list[GeometryView]:
    return [geometry for geometry in link.geometries if geometry.kind == "collision" and geometry.shape is not None]
