"""Links that are each other's mirror image: by their names, and by where they are at q = 0."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import median

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.mirror.names import named_pairs
from robodyn.checks.mirror.parts import Carried, carried
from robodyn.programs.vectors import length, product
from robodyn.robot.joints import placement
from robodyn.robot.urdf.parts import Description, Inertial, Joint, Link
from robodyn.solids.inertia.laws import symmetric
from robodyn.support.floats import Floats, first_largest

_NEAR = 2e-3
"""How far a frame may be from its mirror image, relative to the robot's size."""
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
        """What carries the left link's meshes onto the right link's, where both are made of the same."""
        return carried(self.left, self.right)


@dataclass(frozen=True, eq=False)
class Plane:
    """The plane n . x = offset in the root's axes."""

    normal: Floats
    offset: float

    @property
    def H(self) -> Floats:
        """The reflection 1 - 2 n n^T."""
        return np.eye(3) - 2.0 * np.outer(self.normal, self.normal)

    def image(self, p: Floats) -> Floats:
        """Return (..., 3) the mirror images of points."""
        moved: Floats = product(p, self.H) + 2.0 * self.offset * self.normal
        return moved


def pairs(context: Context) -> tuple[Pair, ...]:
    """Return the confirmed pairs, in the order of the right links in the file; none where the description cannot be
    read.

    Names propose pairs (`named_pairs`). The plane is, among those across x, y or z of the root or across the line
    between the two of a pair, the one that confirms most. A pair is confirmed if at q = 0 each frame's origin is at the
    mirror image of the other's, within 2e-3 of the robot's size, and the axes of one are the images of the other's but
    for their names and signs. Whatever hangs on a pair that is not confirmed is not confirmed either, since from there
    on the poses differ.
    """
    description = None if context.tree_or_none is None else context.description_or_none
    if description is None:
        return ()
    above = {joint.child: joint for joint in description.joints}
    links = {link.name: link for link in description.links}
    proposed = [names for names in named_pairs(links) if names[0] in above and names[1] in above]
    if not proposed:
        return ()
    R, p = link_poses(description)
    plane = _plane(proposed, p)
    if plane is None:
        return ()
    near = _NEAR * _size(p)
    found = []
    for left, right in proposed:
        D = product(R[right].T, plane.H, R[left])
        there = length(plane.image(p[left]) - p[right]) <= near
        apart = length(p[left] - p[right]) > near or abs(product(plane.normal, p[left]) - plane.offset) <= near
        if there and apart and np.abs(D - np.round(D)).max() <= _SQUARE:
            found.append(Pair(links[left], links[right], above[left], above[right], D))
    return tuple(sorted(_rooted(found), key=lambda pair: pair.right.line))


def link_poses(description: Description) -> tuple[Mapping[str, Floats], Mapping[str, Floats]]:
    """Return the rotation and origin of every link in the root's axes at q = 0 [m]."""
    below: dict[str, list[Joint]] = {}
    for joint in description.joints:
        below.setdefault(joint.parent, []).append(joint)
    R, p = {description.root: np.eye(3)}, {description.root: np.zeros(3)}
    waiting = [description.root]
    while waiting:
        link = waiting.pop()
        for joint in below.get(link, ()):
            turn, shift = placement(joint.origin)
            R[joint.child], p[joint.child] = product(R[link], turn), p[link] + product(R[link], shift)
            waiting.append(joint.child)
    return R, p


def reflected(pair: Pair, inertial: Inertial) -> tuple[Floats, Floats]:
    """Return the centre of mass [m] and inertia about it [kg m^2] of the left link's mirror image, in the right link's
    axes.

    A part that is mounted on both sides is no mirror image of itself: where the same meshes are on both links, what
    goes with them is returned if the right link is nearer to that.
    """
    c, I = link_inertia(inertial)
    image = product(pair.D, c), product(pair.D, I, pair.D.T)
    right, part = pair.right.inertial, pair.part
    if part is None or right is None or not (right.mass > 0 and inertial.mass > 0):
        return image
    mounted = part.point(c), product(part.G, I, part.G.T)
    c_right, I_right = link_inertia(right)

    def apart(one: tuple[Floats, Floats]) -> float:
        """Of the centres, squared, or of the inertias by mass, whichever is more [m^2]."""
        shift = length(one[0] - c_right)
        return max(shift * shift, float(np.abs(one[1] / inertial.mass - I_right / right.mass).max()))

    return min(image, mounted, key=apart)


def link_inertia(inertial: Inertial) -> tuple[Floats, Floats]:
    """Return the centre of mass [m] and inertia about it [kg m^2], in the axes of the link."""
    R, c = placement(inertial.origin)
    return c, product(R, symmetric(inertial.inertia), R.T)


def _size(p: Mapping[str, Floats]) -> float:
    places = np.array(list(p.values()))
    return float(np.ptp(places, axis=0).max())


def _plane(proposed: Sequence[tuple[str, str]], p: Mapping[str, Floats]) -> Plane | None:
    """Return the plane that confirms most of the proposed pairs."""
    left, right = (np.array([p[names[k]] for names in proposed]) for k in (0, 1))
    near = _NEAR * _size(p)
    apart = left - right
    lengths = np.linalg.norm(apart, axis=1)
    if not (lengths > near).any():
        return None
    longest = first_largest(lengths)
    widest = apart[longest] / lengths[longest]
    planes = []
    for normal in (*np.eye(3), widest):
        offset = median(product(left + right, normal).tolist()) / 2.0
        planes.append(Plane(normal, offset))
    counts = [int((np.linalg.norm(one.image(left) - right, axis=1)[lengths > near] <= near).sum()) for one in planes]
    best = int(np.argmax(counts))
    return planes[best] if counts[best] else None


def _rooted(found: Sequence[Pair]) -> list[Pair]:
    """Return the pairs whose joints hang on one link, or on the two links of another such pair."""
    kept: dict[str, Pair] = {}
    of_left = {pair.left.name: pair for pair in found}
    verdicts: dict[str, bool] = {}
    for pair in found:
        chain, one = [], pair
        while one.left.name not in verdicts:
            chain.append(one)
            over_left, over_right = one.left_joint.parent, one.right_joint.parent
            if over_left == over_right:
                verdicts[one.left.name] = True
            elif over_left in of_left and of_left[over_left].right.name == over_right:
                one = of_left[over_left]
            else:
                verdicts[one.left.name] = False
        verdicts.update((link.left.name, verdicts[one.left.name]) for link in chain)
        if verdicts[pair.left.name]:
            kept[pair.left.name] = pair
    return list(kept.values())
