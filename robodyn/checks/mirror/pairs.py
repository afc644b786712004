"""Links that are each other's mirror image: by their names, and by where they are at q = 0."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.mirror.names import named_pairs
from robodyn.checks.mirror.parts import Carried, carried
from robodyn.checks.mirror.plane import Plane, link_poses, near_of, planes
from robodyn.programs.vectors import length, product
from robodyn.robot.load import placement
from robodyn.robot.urdf.parts import Inertial, Joint, Link
from robodyn.solids.inertia.laws import symmetric
from robodyn.support.floats import Floats

Names = tuple[str, str]
"""Of a left and a right link."""
_EQUAL = 1e-12
"""Inertias by mass that differ by no more are the same [m^2]."""
_SQUARE = 0.02
"""How far an axis may be from the mirror image of one [rad]."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Two links that are where each other's mirror image is.

    Attributes:
        left, right: the links, as their names have it.
        left_joint, right_joint: the joints they hang on.
        D: (3, 3) the reflection from the axes of the left link to those of the right: x -> D x, det D = -1.
    """

    left: Link
    right: Link
    left_joint: Joint
    right_joint: Joint
    D: Floats

    @cached_property
    def part(self) -> Carried | None:
        """What carries the left link's shapes onto the right link's, where both are made of the same."""
        still = self.left_joint.type == self.right_joint.type == "fixed"
        return carried(self.left, self.right, self.D, still)

    @property
    def turned(self) -> Pair:
        """The right link as the image of which the left one is held to be."""
        return Pair(self.right, self.left, self.right_joint, self.left_joint, self.D.T)

    def mounts_alike(self, left: Joint, right: Joint, near: float) -> bool:
        """Return whether two joints on the links stand where the part on both sides, turned with it, has one."""
        if self.part is None:
            return False
        (R, p), (R_right, p_right) = placement(left.origin), placement(right.origin)
        turned = float(np.abs(product(self.part.G, R) - R_right).max())
        return length(self.part.point(p) - p_right) <= near and turned <= _SQUARE


@dataclass(frozen=True, eq=False)
class Symmetry:
    """How far a robot is its own mirror image.

    Attributes:
        plane: the mirror.
        R, p: rotation and origin of every link in the root's axes at q = 0 [m].
        near: how far a frame may be from its mirror image [m].
        above: the joint that each link hangs on.
        links: by name.
        named: the pairs that names propose, left and right.
        pairs: those that are confirmed, in the order of the right links in the file.
    """

    plane: Plane
    R: Mapping[str, Floats]
    p: Mapping[str, Floats]
    near: float
    above: Mapping[str, Joint]
    links: Mapping[str, Link]
    named: tuple[Names, ...]
    pairs: tuple[Pair, ...]

    @cached_property
    def by_right(self) -> Mapping[str, Pair]:
        """The pairs by the names of their right links."""
        return {pair.right.name: pair for pair in self.pairs}


def pairs(context: Context) -> tuple[Pair, ...]:
    """Return the confirmed pairs, in the order of the right links in the file; none where the description cannot be
    read."""
    found = context.once(symmetry)
    return () if found is None else found.pairs


def symmetry(context: Context) -> Symmetry | None:
    """Return what is symmetric about a robot; None where the description cannot be read, or nothing is.

    Names propose pairs (`named_pairs`), and the plane is the one of `planes` that suits most of them. A pair is
    confirmed if at q = 0 each frame's origin is at the mirror image of the other's, within 2e-3 of the robot's size,
    and the axes of one are the images of the other's but for their names and signs. Whatever hangs on a pair that is
    not confirmed is not confirmed either, since from there on the poses differ.
    """
    description = None if context.tree_or_none is None else context.description_or_none
    if description is None:
        return None
    above = {joint.child: joint for joint in description.joints}
    links = {link.name: link for link in description.links}
    named = tuple(names for names in named_pairs(links) if names[0] in above and names[1] in above)
    if not named:
        return None
    R, p = link_poses(description)
    near = near_of(p)
    plane = _mirror(named, p, above, near)
    if plane is None:
        return None
    found = {}
    for left, right in named:
        D = product(R[right].T, plane.H, R[left])
        there = length(plane.image(p[left]) - p[right]) <= near
        apart = length(p[left] - p[right]) > near or abs(product(plane.normal, p[left]) - plane.offset) <= near
        if there and apart and is_square(D):
            found[left, right] = Pair(links[left], links[right], above[left], above[right], D)
    confirmed = sorted((found[names] for names in _rooted(found, above)), key=lambda pair: pair.right.line)
    return Symmetry(plane, R, p, near, above, links, named, tuple(confirmed))


def _mirror(named: Sequence[Names], p: Mapping[str, Floats], above: Mapping[str, Joint], near: float) -> Plane | None:
    """Return the plane that has most of the pairs on branches from links in it, and of these the one that has most.

    A limb that stands on the wrong side is the mirror image of the other in a plane between the two, but not the link
    that carries both. Where no such link lies in any of them, limbs that are each other's image but for where they
    begin have the plane through what carries them.
    """
    best, most = None, (0, 0)
    for plane, there in planes(named, p):
        carriers = {above[left].parent for left, right in there if above[left].parent == above[right].parent}
        within = {link for link in carriers if length(plane.image(p[link]) - p[link]) <= near}
        count = len(_rooted(there, above, within)), len(there)
        if count > most:
            best, most = plane, count
    return best if most[0] else _through_carrier(named, p, above, near) or best


def _through_carrier(
    named: Sequence[Names], p: Mapping[str, Floats], above: Mapping[str, Joint], near: float
) -> Plane | None:
    """Return the plane through a link that carries both sides, across that axis of the root along which its first pair
    is most apart, if two pairs farther out and all the others are mirrored in it but for where the limbs begin."""
    first = next((names for names in named if above[names[0]].parent == above[names[1]].parent), None)
    over = [(above[left].parent, above[right].parent) for left, right in named]
    steps = [
        (p[left] - p[one], p[right] - p[other])
        for (left, right), (one, other) in zip(named, over, strict=True)
        if (one, other) in named
    ]
    if first is None or len(steps) < 2:
        return None
    apart = np.abs(p[first[0]] - p[first[1]])
    normal = np.eye(3)[int(np.argmax(apart))]
    plane = Plane(normal, float(product(normal, p[above[first[0]].parent])))
    alike = all(length(product(left, plane.H) - right) <= near for left, right in steps)
    return plane if alike and float(apart.max()) > near else None


def is_square(D: Floats) -> bool:
    """Return whether a reflection carries axes to axes, but for their names and signs."""
    return bool(np.abs(D - np.round(D)).max() <= _SQUARE)


def reflected(pair: Pair, inertial: Inertial) -> tuple[Floats, Floats]:
    """Return the centre of mass [m] and inertia about it [kg m^2] of the left link's mirror image, in the right link's
    axes.

    A part that is mounted on both sides is no mirror image of itself: where the same meshes are on both links, what
    goes with them is returned if the right link is nearer to that.
    """
    c, I = link_inertia(inertial)
    image, right = (product(pair.D, c), product(pair.D, I, pair.D.T)), pair.right.inertial
    if right is None or not (right.mass > 0 and inertial.mass > 0):
        return image
    c_right, I_right = link_inertia(right)

    def apart(one: tuple[Floats, Floats]) -> float:
        """Of the centres, squared, or of the inertias by mass, whichever is more [m^2]."""
        shift = length(one[0] - c_right)
        return max(shift * shift, float(np.abs(one[1] / inertial.mass - I_right / right.mass).max()))

    part = pair.part if apart(image) > _EQUAL else None
    return image if part is None else min(image, (part.point(c), product(part.G, I, part.G.T)), key=apart)


def link_inertia(inertial: Inertial) -> tuple[Floats, Floats]:
    """Return the centre of mass [m] and inertia about it [kg m^2], in the axes of the link."""
    R, c = placement(inertial.origin)
    return c, product(R, symmetric(inertial.inertia), R.T)


def _rooted(found: Collection[Names], above: Mapping[str, Joint], within: Collection[str] | None = None) -> list[Names]:
    """Return the pairs whose joints hang on one link, if given one of those within; or on the two of another such
    pair."""
    known, verdicts = frozenset(found), dict[Names, bool]()
    for names in found:
        chain, one = [], names
        while one not in verdicts:
            chain.append(one)
            over = above[one[0]].parent, above[one[1]].parent
            if over in known and over[0] != over[1]:
                one = over
            else:
                verdicts[one] = over[0] == over[1] and (within is None or over[0] in within)
        verdicts.update((link, verdicts[one]) for link in chain)
    return [names for names in found if verdicts[names]]
