"""Whether equal positions of twin joints are mirror images, or opposite ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.mirror.names import row_of
from robodyn.checks.mirror.pairs import Pair, pairs, symmetry
from robodyn.programs.vectors import length, product

_AXIS = 0.02
"""How far an axis may be from the image of its twin's [rad]."""


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
