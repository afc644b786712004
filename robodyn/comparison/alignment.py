"""Which body of one robot is which of another, and how its frame stands there.

Bodies are matched by the names of their joints, then of their links, then by where their joints are in the tree. The
frames of a pair need not agree: two formats may put them elsewhere. So the frame is taken that leaves the fewest parts
of a body (its mass centre, its tensor, the joints of its children, its own joint) elsewhere: these are differences.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import atan2

import numpy as np

from robodyn.programs.vectors import length, rotation_about
from robodyn.robot.kinematics import Pose
from robodyn.robot.model import Joint, Model
from robodyn.solids.inertia.laws import Inertia, inertia_of
from robodyn.support.floats import Floats

_EPS = 1e-12
_FITS = 1e-4
"""Relative difference, or angle, that is none when frames are chosen."""


def moments_in(pose: Pose, of: Inertia) -> Inertia:
    """Return the moments of a body in a frame at this pose, about the origin and in the axes of the outer frame."""
    return inertia_of(of.m, of.centre_of_mass, of.about_centre, pose.R, pose.p)


HERE = Pose(np.eye(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class Pair:
    """A body of A and the same of B.

    Attributes:
        a, b: their numbers.
        frame: of b in the axes of a.
        place: of b's joint in the axes of the body that carries a.
        sign, offset: q_b = sign q_a + offset [rad or m].
        turned: angle between the joint's axes [rad].
        moved, rotated: how far the body stands from where it does in A, beside what the joint does [m, rad].
        same_parent: whether the bodies that carry them are a pair.
    """

    a: int
    b: int
    frame: Pose
    place: Pose = HERE
    sign: float = 1.0
    offset: float = 0.0
    turned: float = 0.0
    moved: float = 0.0
    rotated: float = 0.0
    same_parent: bool = True


def placed(joint: Joint) -> Pose:
    return Pose(np.asarray(joint.R, dtype=float), np.asarray(joint.p, dtype=float))


def aligned(a: Model, b: Model) -> tuple[Pair, ...]:
    """Return the pairs of bodies, parents first; bodies that only one robot has are in none."""
    partner = _matched(a, b)
    pairs: dict[int, Pair] = {}
    for i in range(len(a.bodies)):
        if i not in partner:
            continue
        j = partner[i]
        parent = pairs.get(a.bodies[i].parent)
        if i == 0 or j == 0:
            pairs[i] = Pair(i, j, HERE)
            continue
        if parent is None or parent.b != b.bodies[j].parent:
            pairs[i] = Pair(i, j, HERE, same_parent=False)
        else:
            content = _content(a, b, i, j, partner)
            pairs[i] = _joined(a.bodies[i].joint, b.bodies[j].joint, parent, content, i, j)
    return tuple(pairs.values())


def _matched(a: Model, b: Model) -> dict[int, int]:
    """Return which body of B each of A is."""
    partner, taken = {0: 0}, {0}
    for names in ([[body.joint.name for body in each.bodies] for each in (a, b)], _link_names(a, b)):
        there = {name: j for j, name in enumerate(names[1]) if j not in taken}
        for i, name in enumerate(names[0]):
            j = there.get(name)
            if i not in partner and j is not None and j not in taken:
                partner[i] = j
                taken.add(j)
    for i, body in enumerate(a.bodies):  # parents come first
        if i in partner or body.parent not in partner:
            continue
        others = [j for j, each in enumerate(b.bodies) if each.parent == partner[body.parent] and j not in taken]
        alike = [j for j in others if b.bodies[j].joint.kind == body.joint.kind]
        if alike:
            j = min(alike, key=lambda j: (_unlike(a, i, b, j), j))
            partner[i] = j
            taken.add(j)
    return partner


def _link_names(a: Model, b: Model) -> list[list[str]]:
    return [[body.name for body in each.bodies] for each in (a, b)]


def _unlike(a: Model, i: int, b: Model, j: int) -> float:
    """How far two joints and what they carry are from each other [m, and relative mass]."""
    one, other = a.bodies[i], b.bodies[j]
    masses = [_carried(model, k) for model, k in ((a, i), (b, j))]
    return length(one.joint.p - other.joint.p) + abs(masses[0] - masses[1]) / (max(masses) or 1.0)


def _carried(model: Model, i: int) -> float:
    within = {i}
    for k, body in enumerate(model.bodies):
        if body.parent in within:
            within.add(k)
    return float(sum(model.bodies[k].inertia.m for k in within))


@dataclass(frozen=True, eq=False)
class _Content:
    """What a body holds, in its own axes, of A and of B: moments, origins and axes of its children."""

    moments: tuple[Inertia, Inertia]
    origins: tuple[tuple[Floats, Floats], ...]
    axes: tuple[tuple[Floats, Floats], ...]

    def misfit(self, frame: Pose) -> float:
        """Return how many parts do not fit if b stands so in a, and of those that do how badly."""
        mine, theirs = self.moments[0], moments_in(frame, self.moments[1])
        size = _size(mine)
        parts = []
        if mine.m > 0.0 and theirs.m > 0.0:
            parts.append(length(mine.centre_of_mass - theirs.centre_of_mass) / size)
            tensors = mine.about_centre, theirs.about_centre
            parts.append(float(np.abs(tensors[0] - tensors[1]).max() / (np.abs(tensors[0]).max() or 1.0)))
        parts += [length(one - (frame.R @ other + frame.p)) / max(length(one), size) for one, other in self.origins]
        parts += [length(np.cross(one, frame.R @ other)) for one, other in self.axes]
        return sum(1.0 if part > _FITS else part for part in parts)


def _size(moments: Inertia) -> float:
    """Return the radius of gyration about its origin [m], at least a millimetre."""
    return max(float(np.trace(moments.I) / (2.0 * moments.m)) ** 0.5 if moments.m > 0.0 else 0.0, 1e-3)


def _content(a: Model, b: Model, i: int, j: int, partner: dict[int, int]) -> _Content:
    origins, axes = [], []
    for child, body in enumerate(a.bodies):
        other = partner.get(child)
        if body.parent == i and other is not None and b.bodies[other].parent == j:
            mine, theirs = placed(body.joint), placed(b.bodies[other].joint)
            origins.append((mine.p, theirs.p))
            axes.append((mine.R @ body.joint.axis, theirs.R @ b.bodies[other].joint.axis))
    return _Content((a.bodies[i].inertia, b.bodies[j].inertia), tuple(origins), tuple(axes))


def _joined(mine: Joint, theirs: Joint, parent: Pair, content: _Content, i: int, j: int) -> Pair:
    """Return the pair that two joints carry on bodies that are a pair."""
    here, there = placed(mine), parent.frame.after(placed(theirs))
    u, v = here.R @ mine.axis, there.R @ theirs.axis
    sign = -1.0 if float(u @ v) < 0.0 else 1.0
    turned = atan2(length(np.cross(u, v)), abs(float(u @ v)))
    at_zero = here.inverse.after(there)
    best: tuple[float, Pose, tuple[float, float, float]] | None = None
    for frame in (HERE, at_zero, *_shifted(mine, at_zero, content)):
        left = there.after(here.after(frame).inverse)  # what moves A's body at its zero to B's at its own
        beside = _along(left, u, here.p, mine.kind)
        cost = content.misfit(frame) + (max(map(abs, beside)) > _FITS)  # the joint itself is a part
        if best is None or cost < best[0] - _FITS:
            best = cost, frame, beside
    assert best is not None
    _, frame, (offset, moved, rotated) = best
    return Pair(i, j, frame, there, sign, -sign * offset, turned, moved, rotated)


def _shifted(joint: Joint, at_zero: Pose, content: _Content) -> Iterator[Pose]:
    """Yield the frame of B as the joint would move it to where it fits what the body holds."""
    pairs = [(one, at_zero.R @ other + at_zero.p) for one, other in content.origins]
    if content.moments[0].m > 0.0 and content.moments[1].m > 0.0:
        centre = at_zero.R @ content.moments[1].centre_of_mass + at_zero.p
        pairs.append((content.moments[0].centre_of_mass, centre))
    axis = joint.axis
    if joint.kind == "prismatic":
        shifts = [float((one - other) @ axis) for one, other in pairs]
        yield from (Pose(at_zero.R, at_zero.p + shift * axis) for shift in shifts)
        return
    if joint.kind != "revolute":
        return
    pairs += [(one, at_zero.R @ other) for one, other in content.axes]
    for one, other in pairs:
        flat, turned = one - axis * (axis @ one), other - axis * (axis @ other)
        if length(flat) > _EPS and length(turned) > _EPS:
            angle = atan2(float(axis @ np.cross(turned, flat)), float(turned @ flat))
            yield Pose(np.asarray(rotation_about(axis, angle), dtype=float), np.zeros(3)).after(at_zero)


def _along(left: Pose, axis: Floats, origin: Floats, kind: str) -> tuple[float, float, float]:
    """Return how far a rigid motion is one of the joint [rad or m], and what is beside it: [m] and [rad]."""
    from scipy.spatial.transform import Rotation

    vector = Rotation.from_matrix(left.R).as_rotvec()
    if kind == "prismatic":
        shift = float(left.p @ axis)
        return shift, length(left.p - shift * axis), length(vector)
    angle = float(vector @ axis) if kind == "revolute" else 0.0
    if length(vector - angle * axis) > _FITS:  # no turn of the joint: all of it is its place
        angle = 0.0
    return angle, length(left.R @ origin + left.p - origin), length(vector - angle * axis)
