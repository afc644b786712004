"""Twin joints that do not stand where each other's mirror image is, though what carries them does."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.mirror.pairs import Pair, Symmetry, is_square, symmetry
from robodyn.programs.vectors import length, product, rotation_from_rpy
from robodyn.robot.urdf.parts import Joint
from robodyn.support.floats import Floats

_LIGHT = 1e-3
"""Sensors and marks that weigh no more [kg] are put where there is room."""
_AXES = "xyz"
_ANGLES = ("roll", "pitch", "yaw")


@dataclass(frozen=True, eq=False)
class Misplaced:
    """Two joints.

    Attributes:
        left, right: they.
        expected: (3,) where the origin of the right one would mirror the left one's, in the axes of its parent [m];
            None if it is there, but turned.
        off: how far it is from there [m].
        signs: coordinates or angles of the right one, of which the other sign makes it the mirror image; maybe none.
    """

    left: Joint
    right: Joint
    expected: Floats | None
    off: float
    signs: tuple[str, ...]


def misplaced(context: Context) -> Iterator[Misplaced]:
    """Yield the twin joints that hang on one link in the mirror plane or on a confirmed pair, and carry no pair.

    Left out is what neither moves nor carries a mass; what is mounted alike on a part that is itself mounted on both
    sides, as fingers on a gripper; and axes that lie askew, where no sign explains it: frames are chosen freely.
    """
    found = context.once(symmetry)
    if found is None:
        return
    confirmed, heavy = found.by_right, heavy_links(found)
    for left, right in found.named:
        joints = found.above[left], found.above[right]
        over = [joint.parent for joint in joints]
        pair = confirmed.get(over[1])
        if right in confirmed or not all(joint.type != "fixed" or joint.child in heavy for joint in joints):
            continue
        if over[0] == over[1] and _in_plane(found, over[0]):
            pair = None
        elif pair is None or pair.left.name != over[0]:
            continue
        one = _judged(found, *joints, pair)
        if one is not None:
            yield one


def heavy_links(found: Symmetry) -> set[str]:
    """Return the links that have a mass or carry one."""
    heavy: set[str] = set()
    for link in found.links.values():
        name = link.name if link.inertial is not None and link.inertial.mass > _LIGHT else None
        while name is not None and name not in heavy:
            heavy.add(name)
            name = found.above[name].parent if name in found.above else None
    return heavy


def _in_plane(found: Symmetry, link: str) -> bool:
    return length(found.plane.image(found.p[link]) - found.p[link]) <= found.near


def _judged(found: Symmetry, left: Joint, right: Joint, pair: Pair | None) -> Misplaced | None:
    over = right.parent
    p = product(found.R[over].T, found.plane.image(found.p[left.child]) - found.p[over])
    here = np.array(right.origin.xyz)
    off = length(p - here)
    if pair is not None and pair.mounts_alike(left, right, found.near):
        return None
    if off > found.near:
        flips = [signs for signs, flipped in _flips(right.origin.xyz) if length(flipped - p) <= found.near]
        return Misplaced(left, right, p, off, _first(flips, _AXES))
    turned = product(found.R[over].T, found.plane.H, found.R[left.child])
    square = [signs for signs, rpy in _flips(right.origin.rpy) if is_square(product(rotation_from_rpy(*rpy).T, turned))]
    return Misplaced(left, right, None, off, _first(square, _ANGLES)) if square else None


def _flips(values: tuple[float, ...]) -> Iterator[tuple[tuple[int, ...], Floats]]:
    """Yield places of values that are not 0, few first, and the values with the other sign there."""
    places = [k for k in range(3) if values[k]]
    for count in range(1, len(places) + 1):
        for chosen in combinations(places, count):
            flipped = np.array(values)
            flipped[list(chosen)] *= -1.0
            yield chosen, flipped


def _first(found: list[tuple[int, ...]], names: str | tuple[str, ...]) -> tuple[str, ...]:
    return tuple(names[k] for k in found[0]) if found else ()
