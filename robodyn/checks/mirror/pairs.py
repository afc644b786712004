"""Links that are each other's mirror image: by their names, and by where they are at q = 0."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import median

import numpy as np

from robodyn.checks.context import Context
from robodyn.programs.vectors import length, product
from robodyn.robot.load import placement
from robodyn.robot.urdf.parts import Geometry, Inertial, Joint, Link
from robodyn.solids.inertia.laws import symmetric
from robodyn.support.floats import Floats, first_largest

_ALONE = r"(?<![A-Za-z]){}(?![A-Za-z])"
_ENDS = "FBHMR"
"""Front, back, hind, middle, rear."""
_SWAPS = tuple(
    (re.compile(pattern), replacement)
    for pattern, replacement in (
        ("left", "right"),
        ("Left", "Right"),
        ("LEFT", "RIGHT"),
        (_ALONE.format("l"), "r"),
        (_ALONE.format("L"), "R"),
        (_ALONE.format(f"([{_ENDS}])L"), r"\1R"),
        (_ALONE.format(f"([{_ENDS.lower()}])l"), r"\1r"),
        (_ALONE.format(f"L([{_ENDS}])"), r"R\1"),
        (_ALONE.format(f"l([{_ENDS.lower()}])"), r"r\1"),
        (r"(?<![A-Za-z])L(?=[A-Z][a-z])", "R"),
        (r"(?<![A-Za-z])l(?=[A-Z])", "r"),
        (r"(?<=[a-z0-9])L(?![A-Za-z])", "R"),
    )
)


_ROWS = tuple(
    (re.compile(pattern), replacement)
    for pattern, replacement in (
        (r"(?i)front|hind|rear|middle|back", "*"),
        (_ALONE.format(f"[{_ENDS}]L"), "*L"),
        (_ALONE.format(f"[{_ENDS.lower()}]l"), "*l"),
        (_ALONE.format(f"L[{_ENDS}]"), "L*"),
        (_ALONE.format(f"l[{_ENDS.lower()}]"), "l*"),
    )
)


def row_of(name: str) -> str:
    """Return the name of something on the left with `*` for front, hind and so on: FL_hip is of the row *L_hip."""
    for pattern, replacement in _ROWS:
        name = pattern.sub(replacement, name, count=1)
    return name


def named_pairs(names: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield (left, right) of the names that are each other's but for left and right, l and r, two letters such as FL,
    LF, RL or LH, all in lower and upper case, and L as the first letter of LHipYaw and the last of ElbowL."""
    known = frozenset(names)
    for name in names:
        swapped = (pattern.sub(to, name, count=count) for pattern, to in _SWAPS for count in (0, 1))
        other = next((other for other in swapped if other != name and other in known), None)
        if other is not None:
            yield name, other


Names = tuple[str, str]
"""Of a left and a right link."""
_NEAR = 2e-3
"""How far a frame may be from its mirror image, relative to the robot's size."""


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


def planes(named: Sequence[Names], p: Mapping[str, Floats], near: float) -> Iterator[tuple[Plane, list[Names]]]:
    """Yield the planes that may be the mirror, each with those of the named pairs that it has at mirrored places.

    They are across x, y or z of the root, or across the longest line between the two of a pair; amid the pairs, or
    through the root.
    """
    left, right = (np.array([p[names[k]] for names in named]).reshape(-1, 3) for k in (0, 1))
    apart = left - right
    lengths = np.linalg.norm(apart, axis=1)
    if not (lengths > near).any():
        return
    longest = first_largest(lengths)
    for normal in (*np.eye(3), apart[longest] / lengths[longest]):
        for offset in (median(product(left + right, normal).tolist()) / 2.0, 0.0):
            plane = Plane(normal, offset)
            there = (np.linalg.norm(plane.image(left) - right, axis=1) <= near) & (lengths > near)
            if there.any():
                yield plane, [named[k] for k in np.flatnonzero(there).tolist()]


_SAME_PART = 1e-4
"""How far the meshes of one part may be carried differently: entries of G, and of p [m]."""


@dataclass(frozen=True, eq=False)
class Carried:
    """The isometry x -> G x + p from the axes of the left link to those of the right; det G = -1 if a scale is negative
    on one side."""

    G: Floats
    p: Floats

    def point(self, x: Floats) -> Floats:
        moved: Floats = product(self.G, x) + self.p
        return moved


_IN_PLACE = Carried(np.eye(3), np.zeros(3))


def carried(left: Link, right: Link, D: Floats, still: bool = False) -> Carried | None:
    """Return what carries the meshes of one link onto those of the other; None unless they are the same files, placed
    alike to each other.

    The <visual> ones count, since collision meshes are simplified, to something symmetric even; or the <collision> ones
    where there are no others. Links without meshes are one part if their primitives stand at the same places, and these
    are not each other's images, or both links are fixed: then it is most often a sensor that was bought twice.

    D (3, 3) is the reflection from the axes of the left link to those of the right; `still` says whether both links are
    fixed to what carries them.
    """
    for kind in ("visual", "collision"):
        one, other = ([shape for shape in link.geometries if shape.kind == kind] for link in (left, right))
        meshes = [[shape for shape in shapes if shape.shape == "mesh"] for shapes in (one, other)]
        if any(meshes):
            return _common(*meshes)
        if one or other:
            made_of = [[(shape.shape, shape.size, shape.origin) for shape in shapes] for shapes in (one, other)]
            places = [np.array(shape.origin.xyz) for shape in one]
            mirrored = all(length(product(D, place) - place) <= _SAME_PART for place in places)
            return None if made_of[0] != made_of[1] or (mirrored and not still) else _IN_PLACE
    return None


def _common(one: list[Geometry], other: list[Geometry]) -> Carried | None:
    if [mesh.filename for mesh in one] != [mesh.filename for mesh in other]:
        return None
    first, *others = (_move(*meshes) for meshes in zip(one, other, strict=True))
    for move in others:
        if first is None or move is None or np.abs(first.G - move.G).max() > _SAME_PART:
            return None
        if length(first.p - move.p) > _SAME_PART:
            return None
    return first


def _move(one: Geometry, other: Geometry) -> Carried | None:
    """Return G = R' diag(s' / s) R^T and p = x' - G x; None where the scales differ in more than signs."""
    scales = zip(one.scale, other.scale, strict=True)
    if not all(s and abs(abs(s) - abs(s_other)) <= 1e-6 * abs(s) for s, s_other in scales):
        return None
    if (one.origin, one.scale) == (other.origin, other.scale):
        return _IN_PLACE
    (R, x), (R_other, x_other) = placement(one.origin), placement(other.origin)
    G = product(R_other, np.diag(np.sign(other.scale) * np.sign(one.scale)), R.T)
    return Carried(G, x_other - product(G, x))


_EQUAL = 1e-12
"""Inertias by mass that differ by no more are the same [m^2]."""
_SQUARE = 0.02
"""How far an axis may be from the mirror image of one [rad]."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Two links, left and right as their names have it, that are where each other's mirror image is; D (3, 3) is the
    reflection from the axes of the left link to those of the right: x -> D x, det D = -1."""

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
        R, p: rotation and origin of every link in the root's axes at q = 0 [m].
        near: how far a frame may be from its mirror image [m].
        above: the joint that each link hangs on.
        named: the pairs that names propose, left and right; pairs: those that are confirmed, in the order of the right
            links in the file.
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
    R, p = {description.root: np.eye(3)}, {description.root: np.zeros(3)}
    for link in context.tree.links[1:]:
        joint = above[link.name]
        turn, shift = placement(joint.origin)
        R[link.name], p[link.name] = product(R[joint.parent], turn), p[joint.parent] + product(R[joint.parent], shift)
    near = _NEAR * float(np.ptp(np.array(list(p.values())), axis=0).max())
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
    for plane, there in planes(named, p, near):
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
