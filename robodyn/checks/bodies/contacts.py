"""How far the shapes on both sides of a joint are from each other at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robodyn.checks.bodies.masses import STILL
from robodyn.checks.bodies.rest import behind, joint_pose, relative, rest_poses
from robodyn.checks.bodies.shapes import link_boxes, size_of
from robodyn.checks.context import Context
from robodyn.checks.tree import Group
from robodyn.programs.vectors import length
from robodyn.robot.kinematics import Pose
from robodyn.robot.urdf.view import JointView
from robodyn.solids.inertia.validity import Box


@dataclass(frozen=True, slots=True)
class Contact:
    """The links on both sides of a joint that are next to each other.

    Attributes:
        gap: at least as far are their shapes from each other [m]; 0 where the boxes around them meet.
        size: of the larger of the two [m].
        above: that of the two on the parent's side.
    """

    gap: float
    size: float
    above: str

    @property
    def touches(self) -> bool:
        """Whether they are as near to each other as parts are."""
        return self.gap <= _TOUCH * self.size


_TOUCH = 0.02
_MOVED, _LEAST = 0.1, 0.01
_FIXED, _LEAST_FIXED = 0.5, 0.05
"""Of the larger part, and in metres; a sensor may stand off what it is fixed to."""
_OTHERS, _MOST = 2, 0.9
"""Least number of other joints, which show how this robot is drawn, and the share of those that have parts which touch.
Of 86 published robots, iCub's two oldest descriptions have less."""
_LARGE = 60
"""Links that fixed joints join: more than any of 86 published robots has."""
_MILLIMETRES = 1.0
"""Entries of an origin [m] from which on they may be in mm."""
_TOO_LARGE = (10.0, "10 times too large"), (100.0, "in centimetres"), (1000.0, "in millimetres")


def contacts(context: Context) -> Mapping[str, Contact]:
    """Return by joint the gap between what is fixed to its child and what is fixed to its parent, or to the next body
    that has shapes. Joints with a shape of unknown size on a side are left out. From stage TREE on."""
    sides = context.once(Sides)
    found = {joint.name: sides.contact(joint, sides.poses.get(joint.child)) for joint in context.view.joints}
    return {name: contact for name, contact in found.items() if contact is not None}


def detached(context: Context) -> Mapping[str, tuple[Contact, float]]:
    """Return by joint the contacts with a gap, and the most that it may be, where nearly all others have none [m]."""
    known = context.once(contacts)
    apart = [name for name, contact in known.items() if not contact.touches]
    others, found = len(known) - 1, {}
    for name in apart:
        share, least = (_MOVED, _LEAST) if context.view.joint[name].moves else (_FIXED, _LEAST_FIXED)
        bound = max(share * known[name].size, least)
        if known[name].gap > bound and others >= _OTHERS and others - len(apart) + 1 >= _MOST * others:
            found[name] = known[name], bound
    return found


def too_large(context: Context, joint: JointView) -> str | None:
    """Return which entry of a joint's origin, or all of it, makes the parts meet when it is divided by 10, 100 or 1000,
    and in which unit that says it is; None if none does."""
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
        self._next_shaped: dict[int, Group] = {}
        for joint in context.view.joints:
            if not joint.moves:
                self._fixed.setdefault(joint.parent, []).append(joint.child)

    def contact(self, joint: JointView, child: Pose | None) -> Contact | None:
        """Return the contact of a joint, the child standing at this pose in the root's frame; None where a pose or a
        shape is not known."""
        below, above = self._sides(joint)
        if child is None or not all(name in self.boxes and name in self.poses for name in (*below, *above)):
            return None
        return self._nearest(joint, below, above, child)

    def _sides(self, joint: JointView) -> tuple[list[str], list[str]]:
        """Return the links with shapes below and above; of large groups those that the joint joins, if they have any,
        so that time grows with the links and not with their square."""
        if max(len(self._tree.group[name].links) for name in (joint.parent, joint.child)) > _LARGE:
            below, above = [joint.child], [joint.parent]
            return [name for name in below if name in self.shaped], [name for name in above if name in self.shaped]
        return [name for name in self._branch(joint) if name in self.shaped], self._above(joint)

    def _branch(self, joint: JointView) -> list[str]:
        names = [joint.child]
        for name in names:
            names += self._fixed.get(name, ())
        return names

    def _above(self, joint: JointView) -> list[str]:
        """Return the links with shapes that are fixed to the parent, or to the next group above that has such."""
        branch, group = set(self._branch(joint)), self._shaped_from(self._tree.group[joint.parent])
        while True:
            names = [link.name for link in group.links if link.name in self.shaped and link.name not in branch]
            if names or group.parent is None:
                return names
            group = self._shaped_from(group.parent)

    def _shaped_from(self, group: Group) -> Group:
        """Return the group, or the next one above, in which a link has a shape; without one the root's."""
        passed = []
        while (above := group.parent) is not None and not any(link.name in self.shaped for link in group.links):
            passed.append(group)
            group = self._next_shaped.get(id(group), above)
        self._next_shaped.update((id(below), group) for below in passed)
        return group

    def _nearest(self, joint: JointView, below: Sequence[str], above: Sequence[str], child: Pose) -> Contact | None:
        """Return the contact with the least gap, the child standing at this pose in the root's frame."""
        best: Contact | None = None
        for name in below:
            inner = behind(child, relative(self.poses[joint.child], self.poses[name]))
            for other in above:
                size = max(size_of(self.boxes[name]), size_of(self.boxes[other]))
                far = _gap(self.boxes[name], self.boxes[other], relative(self.poses[other], inner))
                if best is None or far < best.gap:
                    best = Contact(far, size, other)
                if not far:
                    return best
        return best


def _gap(first: Box, second: Box, between: Pose) -> float:
    """Return the larger of the distances of the boxes along either's axes, the first standing at a pose in the
    second's frame: the shapes in them are no nearer."""
    back = relative(between, STILL)
    return max(_apart(first.placed(*between), second), _apart(first, second.placed(*back)))


def _apart(first: Box, second: Box) -> float:
    return length(np.maximum(np.maximum(first.lo - second.hi, second.lo - first.hi), 0.0))
