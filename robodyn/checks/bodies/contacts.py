"""Shapes at rest: how far they are from each other on both sides of a joint, and where parts reach into each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from robodyn.checks.bodies.bodies import gap, link_boxes, real_shapes, size_of, solids
from robodyn.checks.bodies.collision_fit import misfits
from robodyn.checks.bodies.masses import STILL, behind, pose, relative
from robodyn.checks.context import Context, Group
from robodyn.checks.meshes.files import all_facts, extremes, mesh_names, spread_out
from robodyn.checks.srdf import own_srdf
from robodyn.programs.vectors import length, product, rotation_about
from robodyn.robot.kinematics import Pose
from robodyn.robot.urdf.parts import WITH_RANGE
from robodyn.robot.urdf.view import GeometryView, JointView, LinkView
from robodyn.solids.inertia.validity import Box
from robodyn.support.floats import Floats

_TOUCH = 0.02
_MOVED, _LEAST_MOVED = 0.1, 0.01
_FIXED, _LEAST_FIXED = 0.5, 0.05  # of the larger part, and in metres; a sensor may stand off what it is fixed to
_OTHERS, _MOST = 2, 0.9
"""Least number of other joints, which show how this robot is drawn, and the share of those that have parts which touch.
Of 86 published robots, iCub's two oldest descriptions have less."""
_LARGE = 60  # links that fixed joints join: more than any of 86 published robots has
_MILLIMETRES = 1.0  # entries of an origin [m] from which on they may be in mm
_TOO_LARGE = (10.0, "10 times too large"), (100.0, "in centimetres"), (1000.0, "in millimetres")
_ALL_ROUND = spread_out(120)
_NARROW = (0.3, 0.15, 0.08, 0.04, 0.02, 0.01)
"""Radians by which directions are varied around the best one, time after time."""
_LEAST_DEPTH, _SHARE = 0.01, 0.1  # metres, and share of the smaller shape's size, that two shapes overlap at least
_MOST_PAIRS = 2000  # of shapes of two links that are compared


def rest_poses(context: Context) -> Mapping[str, Pose]:
    """Poses of links in the root's frame; without those that hang on what cannot be read. From stage TREE on."""
    poses = {context.tree.root.name: STILL}
    for link in context.tree.links[1:]:
        joint = context.tree.above[link.name]
        inner, outer = joint_pose(joint), poses.get(joint.parent)
        if inner is not None and outer is not None:
            poses[link.name] = behind(outer, inner)
    return poses


def joint_pose(joint: JointView) -> Pose | None:
    """The pose of the child in the parent's frame at rest; None where it cannot be read."""
    fixed, axis, q = pose(joint.origin), joint.axis.or_default(1.0, 0.0, 0.0), rest(joint)
    if fixed is None or axis is None or not q or not any(axis):
        return fixed
    unit = np.array(axis) / length(np.array(axis))
    if joint.type == "prismatic":
        return Pose(fixed.R, fixed.p + product(fixed.R, unit) * q)
    return Pose(product(fixed.R, rotation_about(unit, q).astype(float)), fixed.p)


def rest(joint: JointView) -> float:
    ends = joint.limit.range if joint.limit is not None and joint.type in WITH_RANGE else None
    return min(max(0.0, ends[0]), ends[1]) if ends is not None and ends[0] <= ends[1] else 0.0


class Contact(NamedTuple):
    """Of the links next to each other on both sides of a joint."""

    gap: float  # the least between the boxes around their shapes [m]
    size: float  # of the larger of the two [m]
    above: str  # the link on the parent's side

    @property
    def touches(self) -> bool:
        return self.gap <= _TOUCH * self.size


def detached(context: Context) -> Mapping[str, tuple[Contact, float]]:
    """By joint the contacts with a gap, and the most that it may be, where nearly all others have none [m]: between
    what is fixed to its child and to its parent, or to the next body that has shapes. From stage TREE on."""
    sides = context.once(Sides)
    each = ((joint.name, sides.contact(joint, sides.poses.get(joint.child))) for joint in context.view.joints)
    known = {name: contact for name, contact in each if contact is not None}
    apart = [name for name, contact in known.items() if not contact.touches]
    others, found = len(known) - 1, {}
    for name in apart:
        share, least = (_MOVED, _LEAST_MOVED) if context.view.joint[name].moves else (_FIXED, _LEAST_FIXED)
        bound = max(share * known[name].size, least)
        if known[name].gap > bound and others >= _OTHERS and others - len(apart) + 1 >= _MOST * others:
            found[name] = known[name], bound
    return found


def too_large(context: Context, joint: JointView) -> str | None:
    """Which entry of a joint's origin, or all of it, makes the parts meet when it is divided by 10, 100 or 1000."""
    xyz, sides, placed = joint.origin.xyz.values, context.once(Sides), joint_pose(joint)
    if xyz is None or placed is None or joint.parent not in sides.poses:
        return None
    large = [k for k in range(3) if abs(xyz[k]) >= _MILLIMETRES]
    tried = [(f"entry {'xyz'[k]}", {k}) for k in large] + [("all", set(range(3)))] * (len(large) > 1)
    for which, changed in tried:
        found = []
        for factor, said in _TOO_LARGE:
            shift = np.array([xyz[k] * (1.0 / factor - 1.0) if k in changed else 0.0 for k in range(3)])
            contact = sides.contact(joint, behind(sides.poses[joint.parent], Pose(placed.R, placed.p + shift)))
            if contact is not None and contact.touches:
                found.append(said)
        if found:
            return f"{which} of its origin is {' or '.join(found)}"
    return None


class Sides:
    """The links on the sides of joints, their boxes and poses."""

    def __init__(self, context: Context) -> None:
        self._tree = context.tree
        self.shaped = context.once(link_boxes)
        self.boxes = {name: box for name, box in self.shaped.items() if box is not None}
        self.poses = context.once(rest_poses)
        self._fixed: dict[str, list[str]] = {}
        for joint in context.view.joints:
            if not joint.moves:
                self._fixed.setdefault(joint.parent, []).append(joint.child)
        self._next_shaped: dict[Group, Group] = {}
        for group in context.tree.groups:
            shaped = group.parent is None or any(link.name in self.shaped for link in group.links)
            self._next_shaped[group] = group if shaped or group.parent is None else self._next_shaped[group.parent]

    def contact(self, joint: JointView, child: Pose | None) -> Contact | None:
        """The contact of a joint, the child standing at this pose in the root's frame, if it is known."""
        below, above = self._sides(joint)
        if child is None or not all(name in self.boxes and name in self.poses for name in (*below, *above)):
            return None
        best: Contact | None = None
        for name in below:
            inner = behind(child, relative(self.poses[joint.child], self.poses[name]))
            for other in above:
                first, second = self.boxes[name], self.boxes[other]
                there = relative(self.poses[other], inner)
                # the larger of the distances along the axes of either: the shapes in the boxes are no nearer
                far = max(gap(first.placed(*there), second), gap(first, second.placed(*relative(there, STILL))))
                if best is None or far < best.gap:
                    best = Contact(far, max(size_of(first), size_of(second)), other)
                if not far:
                    return best
        return best

    def _sides(self, joint: JointView) -> tuple[list[str], list[str]]:
        """Links with shapes that are fixed to the child, and to the parent or to the next group above that has such; of
        large groups those that the joint joins alone, for the sake of time."""
        branch, above = [joint.child], [joint.parent]
        group: Group | None = self._tree.group[joint.parent]
        if group is not None and max(len(group.links), len(self._tree.group[joint.child].links)) <= _LARGE:
            for name in branch:
                branch += self._fixed.get(name, ())
            inside = set(branch)
            above = []
            while group is not None and not above:
                group = self._next_shaped[group]
                above = [link.name for link in group.links if link.name in self.shaped and link.name not in inside]
                group = group.parent
        return [name for name in branch if name in self.shaped], [name for name in above if name in self.shaped]


@dataclass(frozen=True, eq=False)
class Hull:
    """The convex hull of a shape at a pose in the root's frame: a box, cylinder, sphere or capsule of `half` (3,) the
    sides of the box around it, or a mesh of `points` (k, 3), in its own axes [m]."""

    kind: str
    half: Floats
    points: Floats | None
    pose: Pose

    def reach(self, directions: Floats) -> Floats:
        """(n,) how far it reaches in unit directions (n, 3) of the root's frame, max d . x over its points [m]: a box
        |d| . half; a cylinder r sqrt(dx^2 + dy^2) + |dz| l / 2; a ball r; a capsule r + |dz| l / 2."""
        own: Floats = product(directions, self.pose.R)
        radius, up = float(self.half[0]), np.abs(own[:, 2])
        if self.points is not None:
            reach = product(own, self.points.T).max(axis=1)
        elif self.kind == "box":
            reach = product(np.abs(own), self.half)
        elif self.kind == "cylinder":
            reach = radius * np.hypot(own[:, 0], own[:, 1]) + up * self.half[2]
        else:
            reach = radius + up * (self.half[2] - radius)
        there: Floats = product(directions, self.pose.p) + reach
        return there


def depth(first: Hull, second: Hull, bound: float) -> float:
    """Return the least distance by which the one has to move for the two to be apart [m]; 0 where it is within a bound:
    min over directions d of h1(d) + h2(-d), h being the reach; over the axes of both and the line between them, over
    120 directions all round, and then ever nearer to the best. Accuracy: above the hulls' true depth, by less than 1 %
    of their size."""
    axes = np.concatenate((first.pose.R.T, second.pose.R.T))
    between = second.pose.p - first.pose.p
    line = between[None] / (length(between) or 1.0)
    least, best = _least_depth(first, second, np.concatenate((axes, -axes, line)) if between.any() else axes)
    for angle in (None, *_NARROW):
        if least <= bound:
            return 0.0
        tried = _ALL_ROUND if angle is None else best + angle * _ALL_ROUND[::5]
        found, direction = _least_depth(first, second, tried / np.sqrt((tried * tried).sum(axis=1))[:, None])
        if found < least:
            least, best = found, direction
    return least if least > bound else 0.0


def _least_depth(first: Hull, second: Hull, directions: Floats) -> tuple[float, Floats]:
    shared = first.reach(directions) + second.reach(-directions)
    k = int(shared.argmin())
    return float(shared[k]), directions[k]


def overlaps(context: Context) -> list[tuple[float, LinkView, LinkView, GeometryView]]:
    """Return the pairs of links that overlap at rest, the deepest first: how deep [m], the links in the order of the
    file, and the collision shape of the second; but for links that one joint or fixed joints connect, those for which
    the SRDF disables collisions, and shapes that are misfits. From stage TREE on."""
    misplaced, srdf = {misfit.geometry for misfit in context.once(misfits)}, own_srdf(context)
    known, poses = context.once(solids), context.once(rest_poses)
    shapes = [
        (link, shape, known[shape].placed(poses[link.name]))
        for link in context.view.links
        for shape in real_shapes(link, "collision")
        if shape in known and link.name in poses and shape not in misplaced
    ]
    pairs = [] if srdf is None else srdf.root.findall("disable_collisions")
    disabled = {frozenset((pair.get("link1"), pair.get("link2"))) for pair in pairs}
    hull, group = cache(partial(_hull, context)), context.tree.group
    neighbours = cache(lambda one, other: one is other or _hangs_on(one, other) or _hangs_on(other, one))
    found: dict[tuple[str, str], tuple[float, LinkView, LinkView, GeometryView]] = {}
    tried = Counter[tuple[str, str]]()
    for k, n, shared in _meeting([box for *_, box in shapes], [link.name for link, *_ in shapes]):
        (link, shape, box), (other, its, its_box) = shapes[k], shapes[n]
        bound, names = max(_LEAST_DEPTH, _SHARE * min(size_of(box), size_of(its_box))), (link.name, other.name)
        if shared <= bound or neighbours(group[link.name], group[other.name]) or frozenset(names) in disabled:
            continue
        tried[names] += 1
        if tried[names] > _MOST_PAIRS:
            continue
        one, two, before = hull(link, shape), hull(other, its), found.get(names)
        bound = bound if before is None else max(bound, before[0])
        deep = 0.0 if one is None or two is None else depth(one, two, bound)
        if deep:
            found[names] = deep, link, other, its
    return sorted(found.values(), key=lambda overlap: -overlap[0])


def _hangs_on(group: Group, other: Group) -> bool:
    """Whether the next body with shapes above a group is the other one."""
    above = group.parent
    while above is not None and above is not other and not any(map(real_shapes, above.links)):
        above = above.parent
    return above is other


def _hull(context: Context, link: LinkView, shape: GeometryView) -> Hull | None:
    solid = context.once(solids)[shape]
    at = behind(context.once(rest_poses)[link.name], solid.pose)
    half, points = (solid.box.hi - solid.box.lo) / 2, None
    if shape.tag == "mesh":
        path, facts = context.once(mesh_names)[shape.uri].path, context.once(all_facts)[shape.uri]
        points = None if path is None else extremes(path, facts.digest)
        scale = shape.scale.or_default(1.0, 1.0, 1.0)
        if points is None or scale is None:
            return None
        points = points * np.array(scale)
    return Hull(shape.tag, half, points, at)


def _meeting(boxes: Sequence[Box], links: Sequence[str]) -> Iterator[tuple[int, int, float]]:
    """Yield the pairs of boxes of different links that share more than a layer, and the least side of that [m]."""
    lo, hi, names = np.array([box.lo for box in boxes]), np.array([box.hi for box in boxes]), np.array(links)
    for k in range(len(boxes)):
        shared = (np.minimum(hi[k], hi[k + 1 :]) - np.maximum(lo[k], lo[k + 1 :])).min(axis=1)
        for n in np.flatnonzero((shared > _LEAST_DEPTH) & (names[k + 1 :] != names[k])).tolist():
            yield k, k + 1 + n, float(shared[n])
