"""What Gazebo's reader of URDF (sdformat 12.3 with urdfdom 3.0) refuses or drops; each was learnt by running it.

It lumps what is fixed into one link, unless it is fixed to a root called world or <gazebo> asks it not to, and goes
down from the root: a link of no mass is left out with everything behind it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import hypot

from robodyn.checks.bodies.masses import link_poses, principal_moments
from robodyn.checks.consumers.found import Found, joints, part
from robodyn.checks.consumers.mujoco import impossible
from robodyn.checks.consumers.water import declared, joined
from robodyn.checks.context import Context
from robodyn.robot.urdf.parts import WITH_AXIS, WITH_RANGE
from robodyn.robot.urdf.view import JointView, LinkView
from robodyn.solids.inertia.laws import inertia_matrix

_WORLD = "world"
_LEAST, _LEAST_AXIS = 1e-6, 1e-6
"""Mass [kg], and length of an axis."""
_ROUNDING = 2e-15
_PRESERVED = ("preserveFixedJoint", "disableFixedJointLumping")


@dataclass(frozen=True, slots=True)
class Lumps:
    """The links that each of Gazebo's links is made of, by the name of the first; `kept` has the firsts that stay.

    `dropped` are left out with all behind them, `nowhere` have no centre of mass.
    """

    links: Mapping[str, list[LinkView]]
    kept: frozenset[str]
    dropped: tuple[LinkView, ...]
    nowhere: frozenset[str]

    def keeps(self, joint: JointView) -> bool:
        """Return whether a joint stays."""
        return joint.moves and joint.child in self.kept


def lumps(context: Context) -> Lumps:
    """Return what Gazebo makes of the links."""
    tree, stay = context.tree, _preserved(context)
    head: dict[str, str] = {}
    links: dict[str, list[LinkView]] = {}
    onto: dict[str, list[LinkView]] = {}
    for link in tree.links:
        above = tree.above.get(link.name)
        fixed = above is not None and not above.moves and above.parent != _WORLD and above.name not in stay
        if fixed and above is not None:
            onto.setdefault(above.parent, []).append(link)
        head[link.name] = head[above.parent] if fixed and above is not None else link.name
        links.setdefault(head[link.name], []).append(link)
    mass, nowhere = _masses(tree.links, onto)
    there, dropped = set(), []
    for link in tree.links:
        above = tree.above.get(link.name)
        if above is None or above.parent in there:
            if abs(mass[link.name] or 0.0) > _LEAST or (above is None and link.name == _WORLD):
                there.add(link.name)
            else:
                dropped.append(link)
    return Lumps(links, frozenset(there & links.keys()), tuple(dropped), nowhere)


def _preserved(context: Context) -> frozenset[str | None]:
    """Return the names of fixed joints that <gazebo> asks to keep."""
    found = context.view.root.findall("gazebo")
    asked = [(one.get("reference"), one.find(tag)) for one in found for tag in _PRESERVED]
    return frozenset(name for name, tag in asked if tag is not None and tag.text.strip().lower() in ("true", "1"))


def _masses(
    links: Sequence[LinkView], onto: Mapping[str, Sequence[LinkView]]
) -> tuple[Mapping[str, float | None], frozenset[str]]:
    """Return the masses of links with those fixed onto them, None without any <inertial>, and the links of no centre.

    These come of joining two <inertial>s without mass, the second of which may be one that Gazebo makes: 0 / 0.
    """
    mass: dict[str, float | None] = {}
    nowhere = set()
    for link in reversed(links):
        whole = None if link.inertial is None else link.mass or 0.0
        for other in onto.get(link.name, ()):
            more = mass[other.name]
            if more is not None:
                whole = (whole or 0.0) + more
                if whole == 0.0 or other.name in nowhere:
                    nowhere.add(link.name)
        mass[link.name] = whole
    return mass, frozenset(nowhere)


def nothing_left(context: Context) -> list[Found]:
    """Return the root of a robot of which no link stays."""
    return [] if context.once(lumps).kept - {_WORLD} else [part(context.tree.root)]


def dropped(context: Context) -> Iterator[Found]:
    """Yield links that are left out and take joints with them."""
    moving = {joint.child for joint in context.view.joints if joint.moves}
    for link in reversed(context.tree.links):
        above = context.tree.above.get(link.name)
        if above is not None and link.name in moving:
            moving.add(above.parent)
    yield from (part(link) for link in context.once(lumps).dropped if link.name in moving)


def bad_bodies(context: Context) -> Iterator[Found]:
    """Yield links whose mass or inertia, with that of what is fixed to them, no body has."""
    found = context.once(lumps)
    for name in (link.name for link in context.tree.links if link.name in found.kept - {_WORLD}):
        links = found.links[name]
        negative = any((link.mass or 0.0) < 0 for link in links)
        doubtful = negative or not context.once(impossible).isdisjoint(link.name for link in links)
        if doubtful and not _is_a_body(context, links):
            yield part(links[0])


def _is_a_body(context: Context, links: list[LinkView]) -> bool:
    poses, parts = context.once(link_poses), []
    for link in links:
        weight = declared(link) if link.inertial is not None else None
        if weight is not None and link.name in poses:
            parts.append(weight.placed(poses[link.name]))
    I = inertia_matrix(joined(parts).S)
    small, middle, large = principal_moments((I[0, 0], I[0, 1], I[0, 2], I[1, 1], I[1, 2], I[2, 2]))
    positive = sum(link.mass or 0.0 for link in links) > 0
    return positive and small >= -_ROUNDING * large and small + middle >= (1.0 - _ROUNDING) * large


def nowhere(context: Context) -> list[Found]:
    """Return links of no centre of mass."""
    found = context.once(lumps)
    return [part(context.view.link[name]) for name in found.kept if name in found.nowhere]


def unknown_joints(context: Context) -> list[Found]:
    """Return floating and planar joints."""
    found = context.once(lumps)
    return [part(joint) for joint in context.view.joints if joint.type in ("floating", "planar") and found.keeps(joint)]


def no_axis(context: Context) -> Iterator[Found]:
    """Yield joints whose axis is next to nothing, or an <axis> without xyz."""
    for joint in context.view.joints:
        if joint.type in WITH_AXIS and context.once(lumps).keeps(joint):
            blank = joint.axis.element is not None and not joint.axis.given
            if blank or hypot(*(joint.axis.values or (1.0,))) < _LEAST_AXIS:
                yield part(joint)


def _is_malformed(joint: JointView) -> bool:
    """Return whether urdfdom gives up on a joint, and so on the robot."""
    limit = joint.limit
    if (joint.axis.problem and joint.moves) or joint.origin.xyz.problem or joint.origin.rpy.problem:
        return True
    if limit is None:
        return joint.type in WITH_RANGE
    numbers = (limit.lower, limit.upper, limit.effort, limit.velocity)
    return any(one.problem for one in numbers) or not (limit.effort.given and limit.velocity.given)


def _is_turned(joint: JointView) -> bool:
    limit = joint.limit.range if joint.limit is not None and joint.type in WITH_RANGE else None
    return limit is not None and limit[0] > limit[1]


malformed = joints(_is_malformed)
turned = joints(_is_turned)


def taken_names(context: Context) -> Iterator[Found]:
    """Yield joints called as a link, and names that are reserved, __so__."""
    found = context.once(lumps)
    for link in context.tree.links:
        if link.name in found.kept and len(link.name) > 3 and link.name.startswith("__") and link.name.endswith("__"):
            yield part(link)
    yield from (part(joint) for joint in context.view.joints if joint.name in found.kept and found.keeps(joint))
