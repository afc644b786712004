"""The tree that the joints make of the links, the rigid groups in it, and what can be asked where it is none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from robodyn.robot.urdf.parts import JOINT_TYPES
from robodyn.robot.urdf.view import InertialView, JointView, LinkView, View


@dataclass(frozen=True, eq=False)
class Group:
    """Links that fixed joints make one body; `links[0]` is the child of `joint`, which moves it against `parent`.

    The root's group has neither. `children` are the groups below this one.
    """

    links: list[LinkView]
    joint: JointView | None
    parent: Group | None
    children: list[Group] = field(default_factory=list)

    @cached_property
    def mass(self) -> float | None:
        """kg, asked for when all links are there; None where a mass cannot be read."""
        masses = [link.mass for link in self.links]
        known = [mass for mass in masses if mass is not None]
        return sum(known) if len(known) == len(masses) else None

    @property
    def heaviest(self) -> tuple[LinkView, InertialView]:
        """The link with the most mass, and its <inertial>, of a group that has mass."""
        link = max(self.links, key=lambda link: link.mass or 0.0)
        assert link.inertial is not None, "it has mass"
        return link, link.inertial


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """`links` and `groups` with parents before children; `above` has the joint above each link but the root."""

    links: tuple[LinkView, ...]
    above: Mapping[str, JointView]
    groups: tuple[Group, ...]
    group: Mapping[str, Group]

    @property
    def root(self) -> LinkView:
        return self.links[0]


def build_tree(view: View) -> Tree | None:
    """Return the tree; None where there is none, or names or types are not in order: RD101 to RD109 say why."""
    above = {joint.child: joint for joint in view.joints}
    unique = len(view.link) == len(view.links) and len(view.joint) == len(view.joints) == len(above)
    led = all(joint.parent in view.link and joint.child in view.link for joint in view.joints)
    typed = all(joint.type in JOINT_TYPES for joint in view.joints)
    roots = [link for link in view.links if link.name not in above]
    if not (unique and led and typed) or len(roots) != 1:
        return None
    below: dict[str, list[str]] = {}
    for joint in view.joints:
        below.setdefault(joint.parent, []).append(joint.child)
    links, waiting = list[LinkView](), [roots[0].name]
    while waiting:
        name = waiting.pop()
        links.append(view.link[name])
        waiting += reversed(below.get(name, ()))
    if len(links) < len(view.links):
        return None
    groups, group = list[Group](), dict[str, Group]()
    for link in links:
        carrier = above.get(link.name)
        parent = None if carrier is None else group[carrier.parent]
        if carrier is not None and parent is not None and not carrier.moves:
            parent.links.append(link)
            group[link.name] = parent
            continue
        group[link.name] = Group([link], carrier, parent)
        groups.append(group[link.name])
        if parent is not None:
            parent.children.append(group[link.name])
    return Tree(tuple(links), above, tuple(groups), group)


def first_above(view: View) -> dict[str, JointView]:
    """Return for each link that is a joint's child, the first such joint."""
    above: dict[str, JointView] = {}
    for joint in view.joints:
        if joint.child:
            above.setdefault(joint.child, joint)
    return above
