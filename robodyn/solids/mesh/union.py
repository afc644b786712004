"""Bodies that overlap, made one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import repeat
from typing import Any

import numpy as np

from robodyn.programs.vectors import IDENTITY, ZERO, rotation_from_rpy
from robodyn.solids.mesh.indexed import Edges, Indexed, Mask, Numbers, in_parts
from robodyn.solids.mesh.inside import may_cross, solid, triangle_boxes
from robodyn.solids.mesh.nesting import Nesting
from robodyn.support.floats import Floats
from robodyn.support.input_file import limits

_TOUCH = 1e-11
"""Volume that shells may share, of the sum of their volumes, and still only touch."""

_MOST_PAIRS = 10_000
"""Pairs of shells whose triangles' boxes are compared; of more some may cross."""

_MOST_COPIES = 16
"""Of a shell that are told apart."""

_TURNS = (IDENTITY, *(rotation_from_rpy(*angles) for angles in ((0.7, -0.4, 1.9), (-1.1, 0.8, 0.3), (2.3, 0.5, -0.6))))
"""Poses in which bodies are united until two agree."""


@dataclass(frozen=True, eq=False)
class United:
    """What became of shells that cross.

    Attributes:
        mesh: with the union in their place, and without those that bound nothing.
        bodies: that were united, 0 if no shells cross.
        spare: (k,) shells left out because they lie in a body, are wound as it is, and cross nothing.
        untested: bodies whose boxes overlap that of another, where one is no manifold or has caps: they may overlap.
        folded: shells with edges of more than two faces: they may overlap themselves.
    """

    mesh: Indexed
    bodies: int
    spare: Mask
    untested: int
    folded: int


def united(nesting: Nesting, caps: int = 0) -> United:
    """Return the union of bodies, each without its cavities, where shells cross.

    It is found by `manifold3d` (a robust boolean of triangle meshes) for shells that are connected by overlapping
    boxes, if any two of them may cross. Where its volume is what nesting says, none do, and they stay as they are.

    Args:
        caps: so many of the last faces are none of the surface; they stay the last.

    Accuracy: volume and second moments of two convex bodies with curved faces within 1e-15 of those of their union in
        exact rationals, and within 1e-12 where they are a thousand of their sizes away from the origin.
    """
    mesh, label, count = nesting.shells.mesh, nesting.shells.label, nesting.shells.count
    rows = np.split(np.argsort(label, kind="stable"), np.cumsum(np.bincount(label, minlength=count))[:-1])
    capped = set(label[len(label) - caps :].tolist())
    spare, crossing = nesting.within.copy(), np.zeros(count, np.bool_)
    regions: list[Indexed] = []
    bodies = untested = 0
    for cluster, pairs in _clusters(mesh.corners, label, nesting.proper):
        parts = {shell: mesh.keep(rows[shell]) for shell in cluster}
        bodies_of = {shell: nesting.cuts.get(shell, []) for shell in cluster if not nesting.inward[shell]}
        reference = parts[cluster[0]].corners[0, 0]
        volumes = np.array([part.volume(reference) for part in parts.values()])
        least = _TOUCH * float(np.abs(volumes).sum())
        whole = not capped.intersection(cluster) and pairs <= limits().mesh_overlaps
        region = _region(parts, bodies_of, nesting.copies, least) if whole else None
        if region is None:
            untested += len(bodies_of)
            spare[cluster] = False
        elif abs(volumes[~nesting.within[cluster]].sum() - region.volume(reference)) > least:
            bodies += len(bodies_of)
            spare[cluster], crossing[cluster] = False, True
            regions.append(region)
    rest = mesh.keep(~(spare | crossing)[label])
    folded = _folded(mesh.keep(~spare[label]), label[~spare[label]])
    return United(_joined([*regions, rest]) if regions else rest, bodies, spare, untested, folded)


def _clusters(corners: Floats, label: Numbers, proper: Mask) -> list[tuple[list[int], int]]:
    """Shells that are connected by overlapping boxes, where two may cross, and how many pairs of boxes overlap."""
    chosen = proper[label]
    names = np.flatnonzero(proper)
    if len(names) < 2:
        return []
    parts, lo, hi = in_parts(corners[chosen], label[chosen])
    boxes = cache(lambda k: triangle_boxes(parts[k]))
    free, found = np.ones(len(names), np.bool_), []
    for first in range(len(names)):
        cluster, pairs, count = [first] if free[first] else [], list[tuple[int, int]](), 0
        free[first] = False
        for k in cluster:
            near = np.flatnonzero(((lo < hi[k]) & (lo[k] < hi)).all(axis=1))
            later = near[near > k]
            count += len(later)
            pairs += [] if count > _MOST_PAIRS else [(k, n) for n in later.tolist()]
            cluster += near[free[near]].tolist()
            free[near] = False
        if count > _MOST_PAIRS or any(may_cross(boxes(k), boxes(n)) for k, n in pairs):
            found.append((names[np.sort(cluster)].tolist(), count))
    return found


def _folded(mesh: Indexed, label: Numbers) -> int:
    """Return how many shells have edges of more than two faces."""
    own = label[:, None] * len(mesh.vertices) + mesh.faces
    _, faces = np.unique(own, return_inverse=True)
    edges = Edges.between(faces.reshape(-1, 3))
    return len(np.unique(label[(edges.count[edges.of] > 2).any(axis=1)]))


def _region(
    shells: dict[int, Indexed], cavities: dict[int, list[int]], copies: Numbers, least: float
) -> Indexed | None:
    """Return the union of bodies, each without its cavities; of cavities that cross, where they are less than bodies.

    Where facets nearly coincide a boolean may fail, which shows in its volume when it is done again in another pose.

    Args:
        shells: of bodies and cavities, by their names. cavities: names of those of each body.
        copies: how often each counts.
        least: by which volumes may differ.

    Returns:
        None if a shell is no manifold, or no two poses agree.
    """
    from manifold3d import Manifold, OpType

    inner = [name for name in shells if name not in cavities]
    cross = _any_cross([triangle_boxes(shells[name].corners) for name in inner])
    solids = {name: solid(shell) for name, shell in shells.items()}
    if None in solids.values():
        return None
    reference, found = next(iter(shells.values())).corners[0, 0], list[Indexed]()
    for turn in _TURNS:
        turned = {name: body.transform(np.column_stack([turn, ZERO])) for name, body in solids.items()}
        if cross:
            outer, holes = ([(turned[name], int(copies[name])) for name in names] for names in (cavities, inner))
            whole = _more_bodies_than_cavities(outer, holes)
        else:
            each = [[turned[body], *(turned[name] for name in inside)] for body, inside in cavities.items()]
            whole = Manifold.batch_boolean([Manifold.batch_boolean(some, OpType.Subtract) for some in each], OpType.Add)
        mesh = whole.transform(np.column_stack([turn.T, ZERO])).to_mesh64()
        region = Indexed(np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, np.int64))
        for other in found:
            if abs(other.volume(reference) - region.volume(reference)) <= least:
                return other
        found.append(region)
    return None


def _any_cross(boxes: list[Floats]) -> bool:
    """Return whether two shells, given by the boxes (2, n, 3) of their triangles, may cross."""
    lo, hi = np.array([each[0].min(axis=0) for each in boxes]), np.array([each[1].max(axis=0) for each in boxes])
    for k, each in enumerate(boxes[1:], start=1):
        near = np.flatnonzero(((lo[:k] < hi[k]) & (lo[k] < hi[:k])).all(axis=1))
        if any(may_cross(boxes[n], each) for n in near.tolist()):
            return True
    return False


def _more_bodies_than_cavities(bodies: list[tuple[Any, int]], cavities: list[tuple[Any, int]]) -> Any:
    """Return all bodies but for where at least n cavities are and at most n bodies, for any n.

    Args:
        bodies, cavities: solids, and how often each counts.
    """
    from manifold3d import Manifold, OpType

    region = Manifold.batch_boolean([body for body, _ in bodies], OpType.Add)
    holes = _layers(cavities)
    around = _layers([(body ^ holes[0], often) for body, often in bodies])
    for n, hole in enumerate(holes, start=1):
        region -= hole - around[n] if n < len(around) else hole
    return region


def _layers(solids: list[tuple[Any, int]]) -> list[Any]:
    """Return where at least one of the solids is, at least two of them, and so on."""
    layers: list[Any] = []
    for body, often in solids:
        for rest in repeat(body, min(often, _MOST_COPIES)):
            for n, layer in enumerate(layers):
                layers[n], rest = layer + rest, layer ^ rest  # noqa: PLW2901
            if not rest.is_empty():
                layers.append(rest)
    return layers


def _joined(parts: list[Indexed]) -> Indexed:
    firsts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + first for part, first in zip(parts, firsts[:-1], strict=True)]
    return Indexed(np.concatenate([part.vertices for part in parts]), np.concatenate(faces))
