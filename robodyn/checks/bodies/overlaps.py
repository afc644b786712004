"""Parts whose collision shapes overlap at rest though no joint is between them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from robodyn.checks.bodies.collision_fit import misfits
from robodyn.checks.bodies.hulls import Hull, depth
from robodyn.checks.bodies.rest import behind, rest_poses
from robodyn.checks.bodies.shapes import real_shapes, size_of, solids
from robodyn.checks.context import Context
from robodyn.checks.meshes.extremes import extremes
from robodyn.checks.meshes.files import all_facts, mesh_names
from robodyn.checks.srdf import srdf
from robodyn.checks.tree import Group
from robodyn.robot.urdf.view import GeometryView, LinkView
from robodyn.solids.inertia.validity import Box

_LEAST, _SHARE = 0.01, 0.1
"""Metres, and share of the smaller shape's size, that two shapes overlap at least."""
_MOST_PAIRS = 2000
"""Of shapes of two links that are compared."""


class Overlap(NamedTuple):
    """Two links, in the order of the file, the collision shape of the second, and how deep they overlap [m]."""

    first: LinkView
    second: LinkView
    shape: GeometryView
    depth: float


def overlaps(context: Context) -> list[Overlap]:
    """Return the pairs of links that overlap at rest, the deepest first.

    Left out are links that one joint or fixed joints connect, those for which the SRDF disables collisions, and shapes
    that are not where they should be. From stage TREE on.
    """
    misplaced = {misfit.geometry for misfit in context.once(misfits)}
    shapes = [each for each in _shapes(context) if each[1] not in misplaced]
    disabled = _disabled(context)
    hull, neighbours = cache(partial(_hull, context)), cache(partial(_neighbours, context))
    found: dict[tuple[str, str], Overlap] = {}
    tried = Counter[tuple[str, str]]()
    for k, n, shared in _meeting([box for *_, box in shapes], [link.name for link, *_ in shapes]):
        (link, shape, box), (other, its, its_box) = shapes[k], shapes[n]
        bound = max(_LEAST, _SHARE * min(size_of(box), size_of(its_box)))
        if shared <= bound or neighbours(link, other) or frozenset((link.name, other.name)) in disabled:
            continue
        tried[link.name, other.name] += 1
        if tried[link.name, other.name] > _MOST_PAIRS:
            continue
        one, two, known = hull(link, shape), hull(other, its), found.get((link.name, other.name))
        bound = bound if known is None else max(bound, known.depth)
        deep = 0.0 if one is None or two is None else depth(one, two, bound)
        if deep:
            found[link.name, other.name] = Overlap(link, other, its, deep)
    return sorted(found.values(), key=lambda overlap: -overlap.depth)


def _disabled(context: Context) -> frozenset[frozenset[str | None]]:
    """Return the pairs of links for which the SRDF disables collisions."""
    found = context.once(srdf)
    pairs = [] if found is None or found.is_of_another else found.root.findall("disable_collisions")
    return frozenset(frozenset((pair.get("link1"), pair.get("link2"))) for pair in pairs)


def _shapes(context: Context) -> Iterator[tuple[LinkView, GeometryView, Box]]:
    """Yield the collision shapes that are known, and the boxes around them along the root's axes."""
    known, poses = context.once(solids), context.once(rest_poses)
    for link in context.view.links:
        for shape in real_shapes(link):
            if shape.kind == "collision" and shape in known and link.name in poses:
                yield link, shape, known[shape].placed(poses[link.name])


def _neighbours(context: Context, link: LinkView, other: LinkView) -> bool:
    """Return whether the links are fixed to each other, or one joint is between what they are fixed to."""
    first, second = context.tree.group[link.name], context.tree.group[other.name]
    return first is second or _hangs_on(first, second) or _hangs_on(second, first)


def _hangs_on(group: Group, other: Group) -> bool:
    """Return whether the next body with shapes above a group is the other one."""
    above = group.parent
    while above is not None and above is not other and not any(map(real_shapes, above.links)):
        above = above.parent
    return above is other


def _hull(context: Context, link: LinkView, shape: GeometryView) -> Hull | None:
    """Return the hull of a collision shape at rest."""
    solid = context.once(solids)[shape]
    at = behind(context.once(rest_poses)[link.name], solid.pose)
    half, points = (solid.box.hi - solid.box.lo) / 2, None
    assert shape.shape is not None, "it is known"
    if shape.shape.tag == "mesh":
        uri = shape.shape.get("filename") or ""
        path, facts = context.once(mesh_names)[uri].path, context.once(all_facts)[uri]
        points = None if path is None else extremes(path, facts.digest)
        scale = shape.scale.or_default(1.0, 1.0, 1.0)
        if points is None or scale is None:
            return None
        points = points * np.array(scale)
    return Hull(shape.shape.tag, half, points, at, solid.box.placed(*at))


def _meeting(boxes: Sequence[Box], links: Sequence[str]) -> Iterator[tuple[int, int, float]]:
    """Yield the pairs of boxes of different links that share more than a layer, and the least side of that [m]."""
    if not boxes:
        return
    lo, hi, names = np.array([box.lo for box in boxes]), np.array([box.hi for box in boxes]), np.array(links)
    for k in range(len(boxes)):
        shared = (np.minimum(hi[k], hi[k + 1 :]) - np.maximum(lo[k], lo[k + 1 :])).min(axis=1)
        for n in np.flatnonzero((shared > _LEAST) & (names[k + 1 :] != names[k])).tolist():
            yield k, k + 1 + n, float(shared[n])
