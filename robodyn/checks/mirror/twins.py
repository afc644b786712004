"""Mirror twins side by side: masses and moments, and how the axes of their joints are turned to each other."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.mirror.pairs import Pair, Symmetry, link_inertia, pairs, reflected, row_of, symmetry
from robodyn.programs.vectors import length, product
from robodyn.robot.urdf.view import InertialView, LinkView
from robodyn.support.floats import Floats
from robodyn.support.wording import shown

MASS = 0.02
"""How far the masses of twins may differ."""
MOMENTS = 0.10
"""How far their moments may differ, each divided by its mass, relative to the largest."""
_FLOOR = 1e-3
"""A shift of the centre of mass that is no more is none [m]."""
_LIGHT = 1e-3
"""Sensors and marks that weigh no more [kg] are put where there is room."""
_AXIS = 0.02
"""How far an axis may be from the image of its twin's [rad]."""
_OTHERS = 2
"""Least number of joints of a limb whose axes lie alike, and that are all turned one way but for one.

Of 86 published robots 31 have such limbs, and none of these a joint that is turned otherwise.
"""


@dataclass(frozen=True, eq=False)
class Twins:
    """A pair of which both links have mass: the right link in the file, the masses of left and right [kg], centre of
    mass [m] and inertia by mass [m^2] of the left link's mirror image (see `reflected`) and of the right link, in the
    right link's axes."""

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
        """Relative distance of moments by mass, or of the moments as they stand, so that a wrong mass alone sets none
        apart."""
        mass, mass_right = self.masses
        return min(_apart(left, right), _apart(mass * left, mass_right * right))

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
        return MOMENTS * float(np.sqrt(max(np.trace(self.I_right), np.trace(self.I), 0.0) / 2.0)) + _FLOOR

    @property
    def centre_is_copied(self) -> bool:
        """Whether the centre of mass is not where it ought to be, but where the left link's is in its own axes."""
        left = self.pair.left.inertial
        copy = np.zeros(3) if left is None else link_inertia(left)[0]
        return self.shift > self.most_shift and length(self.c_right - copy) <= self.most_shift


def twins(context: Context) -> tuple[Twins, ...]:
    """Return the pairs of which both links have mass. From stage MODEL on."""
    found = []
    for pair in context.once(pairs):
        left, right = pair.left.inertial, pair.right.inertial
        link = context.view.link[pair.right.name]
        if left is not None and right is not None and link.inertial is not None and left.mass > 0 and right.mass > 0:
            (c, I), (c_right, I_right), masses = reflected(pair, left), link_inertia(right), (left.mass, right.mass)
            found.append(Twins(pair, link, link.inertial, masses, c, I / left.mass, c_right, I_right / right.mass))
    return tuple(found)


def _apart(one: Floats, other: Floats) -> float:
    largest = max(np.abs(one).max(), np.abs(other).max())
    return float(np.abs(one - other).max() / largest) if largest else 0.0


def heavy_links(found: Symmetry) -> set[str]:
    heavy: set[str] = set()
    for link in found.links.values():
        name = link.name if link.inertial is not None and link.inertial.mass > _LIGHT else None
        while name is not None and name not in heavy:
            heavy.add(name)
            name = found.above[name].parent if name in found.above else None
    return heavy


def directions(pair: Pair, context: Context) -> Iterator[int]:
    """Yield 1 where equal positions of both joints are mirror images, -1 where opposite ones are; else nothing.

    A reflection D carries a translation a to D a, and a rotation about a to one about -D a. On a part that is mounted
    on both sides equal positions are alike.
    """
    left, right = (np.array(joint.axis) for joint in (pair.left_joint, pair.right_joint))
    left, right = left / length(left), right / length(right)
    images = [product(pair.D, left) * (1.0 if pair.left_joint.type == "prismatic" else -1.0)]
    found = context.once(symmetry)
    over = None if found is None else found.by_right.get(pair.right_joint.parent)
    if found is not None and over is not None and over.mounts_alike(pair.left_joint, pair.right_joint, found.near):
        images.append(left)
    for image in images:
        along = float(product(image, right))
        if abs(along) >= 1.0 - _AXIS**2:
            yield 1 if along > 0 else -1


def reversed_axes(context: Context) -> Mapping[str, Sequence[tuple[Pair, ...]]]:
    """Return by the name of the right joint the pairs that show that its axis is reversed.

    On four legs and more the joints of all rows are turned alike: of 13 published robots none differs. Of a row that
    is turned the other way it is the first pair of the kind. And the axes of a limb that lie in the mirror plane are
    turned alike, and so are those across it: either equal positions of all are mirror images, or opposite ones of all
    are. Of a joint for which all others of its limb say otherwise it is these, `_OTHERS` at least. Those of the other
    row come first.
    """
    found, reversed_by = context.once(symmetry), defaultdict[str, list[tuple[Pair, ...]]](list)
    if found is None:
        return reversed_by
    for alike in _lying_alike(found):
        ways = [set(directions(pair, context)) for pair in alike]
        count = Counter(way for each in ways for way in each)
        for k, pair in enumerate(alike):
            others = (*alike[:k], *alike[k + 1 :])
            if len(others) >= _OTHERS and any(count[-way] == len(others) and ways[k] == {way} for way in ways[k]):
                reversed_by[pair.right_joint.name].append(others)
    first: dict[str, tuple[Pair, set[int]]] = {}
    for pair in found.pairs:
        row, kinds = row_of(pair.left.name), {pair.left_joint.type, pair.right_joint.type}
        if row != pair.left.name and kinds <= {"revolute", "continuous", "prismatic"}:
            way = set(directions(pair, context))
            other, other_way = first.setdefault(row, (pair, way)) if len(way) == 1 else (pair, way)
            if way != other_way:
                reversed_by[pair.right_joint.name].insert(0, (other,))
    return reversed_by


def _lying_alike(found: Symmetry) -> list[list[Pair]]:
    """Return the pairs of joints of each limb whose axes lie in the mirror plane, and those whose axes are across it; a
    limb is a chain of twins, as far as each of them carries one other link that has mass: no hand is part of an arm."""
    heavy = heavy_links(found)
    carried = Counter(joint.parent for name, joint in found.above.items() if name in heavy)
    alike: dict[tuple[str, bool], list[Pair]] = defaultdict(list)
    for pair in found.pairs:
        joint, first = pair.right_joint, pair
        if joint.type in ("revolute", "prismatic"):
            axis = product(found.R[joint.child], np.array(joint.axis))
            across = abs(float(product(found.plane.normal, axis))) / length(axis)
            while (over := found.by_right.get(first.right_joint.parent)) is not None and carried[over.right.name] == 1:
                first = over
            if min(across, abs(1.0 - across)) <= _AXIS:
                alike[first.right.name, across > 0.5].append(pair)
    return list(alike.values())
