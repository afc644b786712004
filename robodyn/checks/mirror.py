"""Links that are each other's mirror image: by their names, and by where they are at q = 0."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import permutations
from itertools import product as product_of
from statistics import median
from typing import NamedTuple

import numpy as np

from robodyn.checks.bodies.bodies import shaped
from robodyn.checks.bodies.masses import behind
from robodyn.checks.context import Context
from robodyn.programs.vectors import length, product
from robodyn.robot.kinematics import Pose
from robodyn.robot.load import placement
from robodyn.robot.urdf.parts import Inertial, Joint, Link
from robodyn.robot.urdf.view import InertialView, LinkView
from robodyn.solids.inertia.laws import symmetric
from robodyn.support.floats import Floats, first_largest
from robodyn.support.wording import shown

MASS, MOMENTS = 0.02, 0.10  # how far twins may differ: their masses, and their moments relative to the largest
_FLOOR = 1e-3  # a shift of the centre of mass that is no more is none [m]
_AXIS = 0.02  # how far an axis may be from the image of its twin's [rad]
_ALONE = r"(?<![A-Za-z]){}(?![A-Za-z])"
_ENDS = "FBHMR"  # front, back, hind, middle, rear
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
Names = tuple[str, str]  # of a left and a right link
_NEAR = 2e-3  # how far a frame may be from its mirror image, relative to the robot's size
_SQUARE = [
    np.eye(3)[list(order)] * signs for order in permutations(range(3)) for signs in product_of((1, -1), repeat=3)
]
"""Rotations and reflections that carry axes to axes."""


def named_pairs(names: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield (left, right) of the names that are each other's but for left and right, l and r, two letters such as FL or
    LH, all in lower and upper case, and L as the first letter of LHipYaw and the last of ElbowL."""
    known = frozenset(names)
    for name in names:
        swapped = (pattern.sub(to, name, count=count) for pattern, to in _SWAPS for count in (0, 1))
        other = next((other for other in swapped if other != name and other in known), None)
        if other is not None:
            yield name, other


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


_SAME_PART = 1e-4  # how far a primitive may be from the place of its mirror image, to tell nothing [m]
_DIGITS, _LEAST_PRODUCT = 1e-9, 1e-3
"""Of the largest entry: how far numbers are the same, and what products are more than rounding."""
_FARTHER, _LITTLE = 1.25, 0.1
_TELL = 2  # things that two links have, and that show their frames turned
_EQUAL = 1e-12  # inertias by mass that differ by no more are the same [m^2]


@dataclass(frozen=True, eq=False)
class Pair:
    """Two links, left and right as their names have it, and what carries the left one to the right one, each in its own
    axes: x -> D x + t. Where one stands at the other's mirror image, det D = -1, and t is along the axis of the joint;
    where both are one part, mounted alike, det D = 1."""

    left: Link
    right: Link
    left_joint: Joint
    right_joint: Joint
    D: Floats
    t: Floats = field(default_factory=lambda: np.zeros(3))

    @property
    def is_alike(self) -> bool:
        return float(np.linalg.det(self.D)) > 0

    @cached_property
    def part(self) -> Pose | None:
        """The isometry from the axes of the left link to those of the right that carries the shapes of one part, which
        both are, onto each other; det R = -1 if a scale is negative on one side. None unless the first meshes of both
        are one, of one size: <visual> ones, since others are simplified, or <collision> ones where there are no others.
        Links without meshes are one part if their primitives stand at the same places, and these are not each other's
        images, or both links are fixed, as a sensor that was bought twice."""
        if self.is_alike:
            return Pose(self.D, self.t)
        for kind in ("visual", "collision"):
            one, other = ([each for each in link.geometries if each.kind == kind] for link in (self.left, self.right))
            meshes = [[shape for shape in shapes if shape.shape == "mesh"] for shapes in (one, other)]
            if any(meshes):
                first, its = (shapes[0] if shapes else None for shapes in meshes)
                names = [[shape.filename for shape in shapes] for shapes in meshes]
                if first is None or its is None or names[0] != names[1]:
                    return None
                if not np.allclose(np.abs(first.scale), np.abs(its.scale), rtol=1e-6, atol=0.0) or 0.0 in first.scale:
                    return None
                (R, x), (R_its, x_its) = placement(first.origin), placement(its.origin)
                G = product(R_its, np.diag(np.sign(its.scale) * np.sign(first.scale)), R.T)
                return Pose(G, x_its - product(G, x))
            if one or other:
                made_of = [[(shape.shape, shape.size, shape.origin) for shape in shapes] for shapes in (one, other)]
                places = [np.array(shape.origin.xyz) for shape in one]
                mirrored = all(length(product(self.D, place) - place) <= _SAME_PART for place in places)
                still = self.left_joint.type == self.right_joint.type == "fixed"
                return None if made_of[0] != made_of[1] or (mirrored and not still) else Pose(np.eye(3), np.zeros(3))
        return None

    def agrees(self, has: Sequence[_Content]) -> bool:
        """Whether the right link has the image of all that the left one has."""
        return all(each.agrees(self.D, self.t) for each in has)

    @property
    def turned(self) -> Pair:
        """The right link as the image of which the left one is held to be."""
        back = -product(self.D.T, self.t)
        return Pair(self.right, self.left, self.right_joint, self.left_joint, self.D.T, back)

    def mounts_alike(self, left: Joint, right: Joint, near: float) -> bool:
        """Whether two joints on the links stand where the part on both sides, turned with it, has one."""
        if self.part is None:
            return False
        there, (R_right, p_right) = behind(self.part, Pose(*placement(left.origin))), placement(right.origin)
        return length(there.p - p_right) <= near and float(np.abs(there.R - R_right).max()) <= _AXIS

    def reflected(self, inertial: Inertial) -> tuple[Floats, Floats]:
        """The centre of mass [m] and inertia about it [kg m^2] of the left link's mirror image, in the right link's
        axes; or of the part that is mounted on both sides, if the right link is nearer to that."""
        c, I = link_inertia(inertial)
        image, right = (product(self.D, c) + self.t, product(self.D, I, self.D.T)), self.right.inertial
        if right is None or not (right.mass > 0 and inertial.mass > 0):
            return image
        c_right, I_right = link_inertia(right)

        def apart(one: tuple[Floats, Floats]) -> float:
            """Of the centres, squared, or of the inertias by mass, whichever is more [m^2]."""
            shift = length(one[0] - c_right)
            return max(shift * shift, float(np.abs(one[1] / inertial.mass - I_right / right.mass).max()))

        part = self.part if apart(image) > _EQUAL else None
        if part is None:
            return image
        return min(image, (product(part.R, c) + part.p, product(part.R, I, part.R.T)), key=apart)


@dataclass(frozen=True, eq=False)
class Symmetry:
    """How far a robot is its own mirror image."""

    plane: Plane
    R: Mapping[str, Floats]  # of every link in the root's axes at q = 0
    p: Mapping[str, Floats]  # its origin there [m]
    near: float  # how far a frame may be from its mirror image [m]
    above: Mapping[str, Joint]  # that each link hangs on
    named: Sequence[Names]  # the pairs that names propose
    pairs: Mapping[str, Pair]  # those that are confirmed, by their right links, in the order of these in the file
    turned: Mapping[str, Floats]  # by link of pairs whose frames are turned, the rotation that its joint would have

    def directions(self, pair: Pair) -> Iterator[int]:
        """Yield 1 where equal positions of both joints are mirror images, -1 where opposite ones are; else nothing. A
        reflection D carries a translation a to D a, and a rotation about a to one about -D a. On a part that is mounted
        on both sides equal positions are alike."""
        left, right = (np.array(joint.axis) for joint in (pair.left_joint, pair.right_joint))
        left, right = left / length(left), right / length(right)
        D = product(self.R[pair.right.name].T, self.plane.H, self.R[pair.left.name])
        images = [product(D, left) * (1.0 if pair.left_joint.type == "prismatic" else -1.0)]
        if pair.is_alike:
            images.append(product(pair.D, left))
        over = self.pairs.get(pair.right_joint.parent)
        if over is not None and over.mounts_alike(pair.left_joint, pair.right_joint, self.near):
            images.append(left)
        for image in images:
            along = float(product(image, right))
            if abs(along) >= 1.0 - _AXIS**2:
                yield 1 if along > 0 else -1


def pairs(context: Context) -> tuple[Pair, ...]:
    """The confirmed pairs, in the order of the right links in the file."""
    found = context.once(symmetry)
    return () if found is None else tuple(found.pairs.values())


def both_ways(context: Context) -> Iterator[Pair]:
    """Yield the pairs, and after each the same turned round: which of two is wrong is not known."""
    return (way for pair in context.once(pairs) for way in (pair, pair.turned))


def symmetry(context: Context) -> Symmetry | None:
    """What is symmetric about a robot; None where the description cannot be read, or nothing is. Names propose pairs. A
    pair is confirmed if at q = 0 each frame's origin is at the mirror image of the other's, within 2e-3 of the robot's
    size or, where what hangs on it is, along the axis of its joint; and if the axes of one are the images of the
    other's but for their names and signs, or all that the links have is the image. So is one that hangs alike on a part
    which is mounted on both sides. Where centre, shapes and joints of a link are the image for other axes, its frame is
    turned, and what hangs on it is turned back."""
    description = None if context.tree_or_none is None else context.description_or_none
    if description is None:
        return None
    above = {joint.child: joint for joint in description.joints}
    links = {link.name: link for link in description.links}
    outward = [link.name for link in context.tree.links]
    named = [names for names in named_pairs(outward) if names[0] in above and names[1] in above]
    if not named:
        return None
    R, p = {description.root: np.eye(3)}, {description.root: np.zeros(3)}
    for name in outward[1:]:
        joint = above[name]
        turn, shift = placement(joint.origin)
        R[name], p[name] = product(R[joint.parent], turn), p[joint.parent] + product(R[joint.parent], shift)
    near = _NEAR * float(np.ptp(np.array(list(p.values())), axis=0).max())
    plane = _mirror(named, p, above, near)
    if plane is None:
        return None
    found, turned, carried = dict[str, Pair](), dict[str, Floats](), dict[Names, list[Names]]()
    for names in named:
        carried.setdefault((above[names[0]].parent, above[names[1]].parent), []).append(names)
    for left, right in named:
        joints = above[left], above[right]
        below = carried.get((left, right), [])
        D, t = product(R[right].T, plane.H, R[left]), product(R[right].T, plane.image(p[left]) - p[right])
        pair, over = Pair(links[left], links[right], *joints, D), found.get(joints[1].parent)
        has = _contents(context, pair, [(above[one], above[its]) for one, its in below], near)
        on_pair = over is not None and over.left.name == joints[0].parent
        apart = length(p[left] - p[right]) > near or abs(product(plane.normal, p[left]) - plane.offset) <= near
        there, axis = length(t) <= near, np.array(joints[1].axis)
        if not there and below and joints[1].type in ("revolute", "continuous"):
            pair = replace(pair, t=t)
            there = length(np.cross(t, axis)) <= near * length(axis) and pair.agrees(has)
        if apart and there:
            odd = sum(not each.agrees(D, pair.t) for each in has) >= _TELL
            if odd and (on_pair or joints[0].parent == joints[1].parent):
                hung = _hung_on(right, outward, above)
                inside = [names for names in named if names[1] in hung and names[1] != right]
                pair, back = _by_contents(pair, has, inside, plane, near, R, p)
                if back is not None:
                    turned[right] = product(R[joints[1].parent].T, back, R[right])
                    turned[left] = product(R[joints[0].parent].T, plane.H, R[right], pair.D)
                    p |= {name: p[right] + product(back, p[name] - p[right]) for name in hung}
                    R |= {name: product(back, R[name]) for name in hung}
            if is_square(pair.D) or (len(has) >= _TELL and pair.agrees(has)):
                found[right] = pair
        elif over is not None and on_pair and over.mounts_alike(*joints, near) and over.part is not None:
            turns = [placement(joint.origin)[0] for joint in joints]
            found[right] = replace(pair, D=product(turns[1].T, over.part.R, turns[0]), t=np.zeros(3))
    confirmed = sorted(found.values(), key=lambda pair: pair.right.line)
    return Symmetry(plane, R, p, near, above, named, {pair.right.name: pair for pair in confirmed}, turned)


def _hung_on(name: str, outward: Sequence[str], above: Mapping[str, Joint]) -> set[str]:
    """A link and all that hangs on it."""
    hung = {name}
    for each in outward[1:]:
        if above[each].parent in hung:
            hung.add(each)
    return hung


class _Content(NamedTuple):
    """A point of two twins and how near they must be [m]; and second moments about it, of bodies."""

    left: Floats
    right: Floats
    near: float
    S: Floats | None = None
    S_right: Floats | None = None

    def agrees(self, D: Floats, t: Floats) -> bool:
        moments = self.S is None or self.S_right is None or apart(product(D, self.S, D.T), self.S_right) <= MOMENTS
        return moments and length(product(D, self.left) + t - self.right) <= self.near


def _contents(context: Context, pair: Pair, joints: Sequence[tuple[Joint, Joint]], near: float) -> list[_Content]:
    """What two links have: mass, the solid of their shapes, and joints that hang on them."""
    both = pair.left, pair.right
    found = [_Content(np.array(one.origin.xyz), np.array(its.origin.xyz), near) for one, its in joints]
    one, other = (each.inertial for each in both)
    if one is not None and other is not None and one.mass > 0 and other.mass > 0:
        (c, I), (c_right, I_right) = link_inertia(one), link_inertia(other)
        found.append(_Content(c, c_right, _shift(I / one.mass), I / one.mass, I_right / other.mass))
    solids = [context.once(shaped).get(each.name) for each in both]
    if solids[0] is not None and solids[1] is not None:
        solid, its = solids[0].solid, solids[1].solid
        found.append(_Content(solid.c, its.c, MOMENTS * solid.spread**0.5 + _FLOOR, solid.S, its.S))
    return found


def _by_contents(
    pair: Pair,
    has: Sequence[_Content],
    inside: Sequence[Names],
    plane: Plane,
    near: float,
    R: Mapping[str, Floats],
    p: Mapping[str, Floats],
) -> tuple[Pair, Floats | None]:
    """The pair as what its links have tells: as it is, one part mounted on both sides, or with the right frame turned
    back by the rotation given: then more of what it carries is the image, or all if it may be one part. What links have
    is carried by the isometry that is nearest to the one that is there."""
    left, right = pair.left.name, pair.right.name
    fit = [D for D in _SQUARE if replace(pair, D=D).agrees(has)]
    S, rotation = (
        max((D for D in fit if np.linalg.det(D) * sign > 0), key=lambda D: float((D * pair.D).sum()), default=None)
        for sign in (-1, 1)
    )
    rotation = rotation if is_square(pair.D) else None
    if S is not None:
        back = product(plane.H, R[left], S.T, R[right].T)
        steps = [(plane.image(p[one]) - p[right], p[its] - p[right]) for one, its in inside]
        now, then = (sum(length(to - product(Q, step)) <= near for to, step in steps) for Q in (np.eye(3), back))
        if now < then if inside and rotation is None else then == len(inside) and (inside or rotation is None):
            return replace(pair, D=S), back
    return (pair if rotation is None else replace(pair, D=rotation)), None


def _mirror(named: Sequence[Names], p: Mapping[str, Floats], above: Mapping[str, Joint], near: float) -> Plane | None:
    """The plane that has most of the pairs on branches from links in it, and of these the one that has most: across x,
    y or z of the root, or the longest line between the two of a pair; amid the pairs, through the root, or through the
    first link that carries both sides. A pair on another one is mirrored if its steps from there are, so that a limb
    which begins at the wrong place tells as much as the others."""
    over, known = [(above[left].parent, above[right].parent) for left, right in named], frozenset(named)
    on_pair = np.array([each in known for each in over])[:, None]
    left, right = (np.array([p[names[k]] for names in named]) for k in (0, 1))
    left_step, right_step = (
        ends - np.where(on_pair, np.array([p[names[k]] for names in over]), 0.0) for k, ends in enumerate((left, right))
    )
    lengths = np.linalg.norm(left - right, axis=1)
    longest, carriers = first_largest(lengths), dict.fromkeys(one for one, other in over if one == other)
    if lengths[longest] <= near:
        return None
    best, most = None, (0, 0)
    for normal in (*np.eye(3), (left - right)[longest] / lengths[longest]):
        first = [float(product(normal, p[carrier])) for carrier in list(carriers)[:1]]
        for offset in (median(product(left + right, normal).tolist()) / 2.0, 0.0, *first):
            plane = Plane(normal, offset)
            images = np.where(on_pair, product(left_step, plane.H), plane.image(left))
            there = np.linalg.norm(images - right_step, axis=1) <= near
            there &= np.abs(product(left_step - right_step, normal)) > near
            within = {link for link in carriers if length(plane.image(p[link]) - p[link]) <= near}
            rooted = set[Names]()  # those whose joints hang on one link within, or on the two of another such pair
            for names, (one, other) in zip(named, over, strict=True):
                rooted |= {names} if (one, other) in rooted or (one == other and one in within) else set()
            count = sum(yes and names in rooted for names, yes in zip(named, there.tolist(), strict=True)), there.sum()
            if count > most:
                best, most = plane, count
    return best


def is_square(D: Floats) -> bool:
    """Whether a reflection carries axes to axes, but for their names and signs."""
    return bool(np.abs(D - np.round(D)).max() <= _AXIS)


def link_inertia(inertial: Inertial) -> tuple[Floats, Floats]:
    """The centre of mass [m] and inertia about it [kg m^2], in the axes of the link."""
    R, c = placement(inertial.origin)
    return c, product(R, symmetric(inertial.inertia), R.T)


@dataclass(frozen=True, eq=False)
class Twins:
    """A pair of which both links have mass: the right link in the file, the masses of left and right [kg], centre of
    mass [m] and inertia by mass [m^2] of the left link's mirror image and of the right link in its axes."""

    pair: Pair
    link: LinkView
    inertial: InertialView
    masses: tuple[float, float]
    c: Floats
    I: Floats
    c_right: Floats
    I_right: Floats

    @property
    def other(self) -> str:
        """The left link, as messages name it."""
        return f"{shown(self.pair.left.name)} (line {self.pair.left.line})"

    @property
    def moments(self) -> tuple[Floats, Floats]:
        """(3,) principal moments by mass of the left and the right link, ascending [m^2]."""
        left, right = np.linalg.eigvalsh(np.stack((self.I, self.I_right)))
        return left, right

    def apart(self, left: Floats, right: Floats) -> float:
        """Relative distance of moments by mass, or as they stand, so that a wrong mass alone sets none apart."""
        mass, mass_right = self.masses
        return min(apart(left, right), apart(mass * left, mass_right * right))

    @property
    def tensors_apart(self) -> float:
        return self.apart(self.I, self.I_right)

    @property
    def shift(self) -> float:
        """How far the centre of mass is from its mirror image [m]."""
        return length(self.c_right - self.c)

    @property
    def most_shift(self) -> float:
        """A tenth of the radius of gyration, and 1 mm at least [m]."""
        return max(_shift(self.I), _shift(self.I_right))

    @property
    def wrong_signs(self) -> list[str]:
        """The products that have the other sign, where all else is the image to the last digits."""
        size = float(np.abs(self.I_right).max())
        if self.shift > _SAME_PART or np.abs(np.abs(self.I) - np.abs(self.I_right)).max() > _DIGITS * size:
            return []
        places = {"ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
        least = -((_LEAST_PRODUCT * size) ** 2)
        return [name for name, at in places.items() if float(self.I[at] * self.I_right[at]) < least]

    @property
    def centre_is_copied(self) -> bool:
        """Whether the centre of mass is where the left link's is in its own axes, and ought not to be."""
        left = self.pair.left.inertial
        copy = np.zeros(3) if left is None else link_inertia(left)[0]
        return self.shift > self.most_shift and length(self.c_right - copy) <= self.most_shift


def twins(context: Context) -> tuple[Twins, ...]:
    """Return the pairs of which both links have mass, and each turned round: the left link stands for the right one;
    but one alone where the inertial of the one link is farther from the solid of its shapes. From stage MODEL on."""
    found = []
    for pair in both_ways(context):
        one, its, link = pair.left.inertial, pair.right.inertial, context.view.link[pair.right.name]
        near, far = (_from_shapes(context, each) for each in (pair.left, pair.right))
        if near is not None and far is not None and near > _FARTHER * far + _LITTLE:
            continue
        if one is not None and its is not None and link.inertial is not None and one.mass > 0 and its.mass > 0:
            (c, I), (c_right, I_right), masses = pair.reflected(one), link_inertia(its), (one.mass, its.mass)
            found.append(Twins(pair, link, link.inertial, masses, c, I / one.mass, c_right, I_right / its.mass))
    return tuple(found)


def _from_shapes(context: Context, link: Link) -> float | None:
    """How far centre and inertia of a link are from those of the solid of its shapes, relative to its size."""
    shape = context.once(shaped).get(link.name)
    if shape is None or link.inertial is None or not link.inertial.mass > 0:
        return None
    c, I = link_inertia(link.inertial)
    return length(c - shape.solid.c) / float(np.sqrt(shape.solid.spread)) + shape.solid.apart(I, link.inertial.mass)


def _shift(I: Floats) -> float:
    return MOMENTS * float(np.sqrt(max(np.trace(I), 0.0) / 2.0)) + _FLOOR


def apart(one: Floats, other: Floats) -> float:
    """The largest difference of two tensors, relative to the largest of their entries."""
    largest = max(np.abs(one).max(), np.abs(other).max())
    return float(np.abs(one - other).max() / largest) if largest else 0.0
