"""Whether equal positions of twin joints are mirror images, or opposite ones."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.mirror.misplaced import heavy_links
from robodyn.checks.mirror.names import row_of
from robodyn.checks.mirror.pairs import Pair, Symmetry, pairs, symmetry
from robodyn.programs.vectors import length, product

_AXIS = 0.02
"""How far an axis may be from the image of its twin's [rad]."""
_OTHERS = 2
"""Least number of joints of a limb whose axes lie alike, and that are all turned one way but for one.

Of 86 published robots 31 have such limbs, and none of these a joint that is turned otherwise.
"""
_LIMBED = ("revolute", "prismatic")


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


def unlike_the_other_legs(context: Context) -> Mapping[str, Pair]:
    """Return by the name of the right joint the pair of another row of legs that is turned the other way.

    On four legs and more the joints of all rows are turned alike: of 13 published robots none differs. Of rows that do,
    the later ones are returned with the first.
    """
    first: dict[str, tuple[Pair, int]] = {}
    unlike = {}
    for pair in context.once(pairs):
        row = row_of(pair.left.name)
        kinds = {pair.left_joint.type, pair.right_joint.type}
        if row == pair.left.name or not kinds <= {"revolute", "continuous", "prismatic"}:
            continue
        ways = set(directions(pair, context))
        if len(ways) == 1:
            way = ways.pop()
            other, other_way = first.setdefault(row, (pair, way))
            if way != other_way:
                unlike[pair.right_joint.name] = other
    return unlike


def unlike_their_limb(context: Context) -> Mapping[str, tuple[Pair, ...]]:
    """Return by the name of the right joint the other pairs of its limb, where all of them are turned the other way.

    The axes of a limb that lie in the mirror plane are turned alike, and so are those across it: either equal positions
    of all are mirror images, or opposite ones of all are.
    """
    found = context.once(symmetry)
    unlike: dict[str, tuple[Pair, ...]] = {}
    for alike in () if found is None else _lying_alike(found):
        ways = [set(directions(pair, context)) for pair in alike]
        count = Counter(way for each in ways for way in each)
        for k, pair in enumerate(alike):
            others = (*alike[:k], *alike[k + 1 :])
            if len(others) >= _OTHERS and any(count[-way] == len(others) and ways[k] == {way} for way in ways[k]):
                unlike[pair.right_joint.name] = others
    return unlike


def _lying_alike(found: Symmetry) -> list[list[Pair]]:
    """Return the pairs of joints of each limb whose axes lie in the mirror plane, and those whose axes are across it.

    A limb goes as far as each of its links carries one other that has mass: a hand or a gripper is not part of it.
    """
    heavy = heavy_links(found)
    carried = Counter(joint.parent for name, joint in found.above.items() if name in heavy)
    alike: dict[tuple[str, bool], list[Pair]] = defaultdict(list)
    for pair in found.pairs:
        joint = pair.right_joint
        if joint.type not in _LIMBED:
            continue
        axis = product(found.R[joint.child], np.array(joint.axis))
        across = abs(float(product(found.plane.normal, axis))) / length(axis)
        if min(across, abs(1.0 - across)) <= _AXIS:
            alike[_limb(pair, found, carried), across > 0.5].append(pair)
    return list(alike.values())


def _limb(pair: Pair, found: Symmetry, carried: Mapping[str, int]) -> str:
    """Return the name of the right link that a pair's limb begins with."""
    over = found.by_right.get(pair.right_joint.parent)
    while over is not None and carried[over.right.name] == 1:
        pair, over = over, found.by_right.get(over.right_joint.parent)
    return pair.right.name
