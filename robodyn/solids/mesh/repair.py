"""Putting a surface right step by step, saying what was done and what it did to the volume; bodies united."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations, repeat
from typing import Any

import numpy as np

from robodyn.errors import MeshError
from robodyn.programs.vectors import IDENTITY, ZERO, rotation_from_rpy
from robodyn.solids.mesh.columns import Quadrature, as_given, by_columns, by_winding_numbers
from robodyn.solids.mesh.holes import Filling, filled, one_sided
from robodyn.solids.mesh.indexed import Edges, Indexed, Mask, Numbers, in_parts, merged
from robodyn.solids.mesh.inside import may_cross, solid, triangle_boxes
from robodyn.solids.mesh.nesting import Nesting, nested
from robodyn.solids.mesh.shells import without_degenerate, without_duplicates, wound
from robodyn.solids.mesh.triangles import MemoryTriangles, Triangles
from robodyn.support.floats import Floats
from robodyn.support.input_file import limits
from robodyn.support.wording import count as many

_SAME = 1e-11
"""Share of its volume by which a body may differ that is measured twice."""
_BY_REGION = ("overlaps", "winding numbers")
"""Steps that leave the surface as it is."""


@dataclass(frozen=True)
class Step:
    """One kind of repair, by name ("degenerate", "duplicate", "winding", "holes", "orientation", "nested", "union", or
    one of `_BY_REGION`) and in words, and of how many faces, gaps, shells or bodies.

    volume_before, volume_after: signed, in units of the file cubed; of an open surface about the middle of its box.
    """

    name: str
    count: int
    what: str
    volume_before: float
    volume_after: float

    @property
    def change(self) -> float:
        """Of the volume."""
        return self.volume_after - self.volume_before


@dataclass(frozen=True, eq=False)
class Repaired:
    """A surface after its repair; the same object if nothing was done.

    closed: whether no boundary is left; doubt: volume that may be missing or too much where holes were filled;
    quadrature: integrals over what it encloses, where they are not those of its triangles; remarks: what was left.
    """

    triangles: Triangles
    steps: tuple[Step, ...]
    closed: bool
    doubt: float
    quadrature: Quadrature | None
    remarks: tuple[str, ...]


def repair(triangles: Triangles, cavities: bool = False) -> Repaired:
    """The surface with bad faces dropped, small holes filled, shells wound as their nesting asks, and bodies united.

    Vertices are merged where they are equal, not where they are near. Shells that are open by more than a small hole,
    and those that overlap but are no manifolds, stay as they are: the region where the winding number is positive is
    integrated by columns.

    Args:
        cavities: shells in others are cavities, however they are wound; else by winding numbers (see `nested`).

    Raises:
        MeshError: no triangle has an area, a part of the surface has one side only, or shells are too many to be placed
            in each other.
    """
    mesh = merged(triangles.array())
    steps = _Steps(mesh.middle)
    given = steps.dropped(mesh, without_degenerate(mesh), "degenerate", "without area")
    single, copies = without_duplicates(given)
    mesh = steps.dropped(given, single, "duplicate", "given more than once")
    if not len(mesh.faces):
        raise MeshError("has no triangle with an area", remedy="give a surface", file=triangles.name)
    shells, turned = wound(mesh)
    twisted = one_sided(shells)
    if twisted:
        raise MeshError(
            f"{twisted} of {many(len(shells.mesh.faces), 'face')} form surfaces with one side only, like a "
            "Moebius strip or a Klein bottle: they cannot be wound and enclose no definite volume",
            remedy="--shell THICKNESS takes the surface as a sheet, --no-repair integrates it as it is",
            file=triangles.name,
        )
    steps.taken(mesh, shells.mesh, turned, "winding", f"{many(turned, 'face')} turned to agree with neighbours")
    filling = filled(shells)
    count = filling.holes + filling.seams
    gaps = " and ".join(many(each, kind) for each, kind in ((filling.holes, "hole"), (filling.seams, "seam")) if each)
    what = f"{gaps} filled by {many(filling.triangles, 'triangle')}"
    steps.taken(shells.mesh, filling.shells.mesh, count, "holes", what)
    nesting = nested(filling.capped, copies, filling.caps, cavities, triangles.name)
    count = nesting.bodies + nesting.cavities
    kinds = (nesting.bodies, "turned outwards"), (nesting.cavities, "turned inwards, being a cavity in another")
    what = ", ".join(f"{many(each, 'shell')} {how}" for each, how in kinds if each)
    steps.taken(filling.capped.mesh, nesting.shells.mesh, count, "orientation", what)
    union = united(nesting, filling.caps)
    whole, spare = nesting.shells.mesh, int(union.spare.sum())
    mesh = whole.keep(~union.spare[nesting.shells.label])
    steps.taken(whole, mesh, spare, "nested", f"{many(spare, 'shell')} in another, wound as it is, counted once")
    what = f"{many(union.bodies, 'overlapping body', 'overlapping bodies')} united"
    steps.taken(mesh, union.mesh, union.bodies, "union", what)
    mesh, region = _region(union, filling, steps)
    # some have no boundary, but edges of so many faces that their sides cannot be told
    tangled = len(np.setdiff1d(np.flatnonzero(~shells.closed), shells.rim[:, 0])) > 0
    if (nesting.uneven or tangled) and not Edges.between(given.faces).balance.any():
        found, volume = as_given(given), mesh.volume(mesh.middle) if region is None else region.volume
        apart = abs(found.volume - volume) / abs(found.volume)
        if apart > _SAME:
            region = replace(found, bar=max(found.bar, apart))
            steps.measured(mesh, region, 1, "overlaps", "bodies that share faces counted once, by columns")
    remarks = []
    if filling.left and region is None:
        share = f"{100 * filling.missing:.2g} % of their surface"
        remarks.append(f"{many(filling.left, 'gap')} too large to be filled: {share} is missing")
    within = int(nesting.within.sum())
    if within:
        is_or_are, cavity = ("is", "it is a cavity") if within == 1 else ("are", "they are cavities")
        remarks.append(
            f"{many(within, 'shell')} in another {is_or_are} wound as it is, and taken as a part of it: "
            f"if {cavity}, say --cavities ({nesting.less * triangles.scale**3:.4g} m^3 less)"
        )
    changed = any(step.name not in _BY_REGION for step in steps.all)
    return Repaired(
        triangles=MemoryTriangles(corners=mesh.corners, **triangles.labels) if changed else triangles,
        steps=tuple(steps.all),
        closed=not filling.left,
        doubt=filling.doubt,
        quadrature=region,
        remarks=tuple(remarks),
    )


def _region(union: United, filling: Filling, steps: _Steps) -> tuple[Indexed, Quadrature | None]:
    """Return the mesh without caps, and the region that it encloses if its winding number has to tell."""
    count = len(union.mesh.faces) - filling.caps
    mesh, caps = replace(union.mesh, faces=union.mesh.faces[:count]), union.mesh.faces[count:]
    if not filling.left:
        region = by_columns(mesh) if union.untested or union.folded else None
        bodies = [f"{union.untested} bodies"] if union.untested else []
        shells = [many(union.folded, "folded shell")] if union.folded else []
        what = f"overlaps of {' and '.join(bodies + shells)} counted once, by columns"
        steps.measured(mesh, region, union.untested + union.folded, "overlaps", what)
        return mesh, region
    region = by_winding_numbers(mesh, caps)
    what = f"{many(filling.left, 'gap')} too large to be filled, left to winding numbers"
    steps.measured(mesh, region, filling.left, "winding numbers", what)
    return mesh, region


class _Steps:
    """The steps so far; their volumes are about one point."""

    def __init__(self, reference: Floats) -> None:
        self.all: list[Step] = []
        self._reference = reference

    def measured(self, before: Indexed, region: Quadrature | None, count: int, name: str, what: str) -> None:
        if region is not None:
            self.all.append(Step(name, count, what, before.volume(self._reference), region.volume))

    def dropped(self, before: Indexed, after: Indexed, name: str, why: str) -> Indexed:
        count = len(before.faces) - len(after.faces)
        return self.taken(before, after, count, name, f"{many(count, 'face')} {why} dropped")

    def taken(self, before: Indexed, after: Indexed, count: int, name: str, what: str) -> Indexed:
        """Return the mesh after a step, which is kept in mind if it was done to anything."""
        if not count:
            return before
        self.all.append(Step(name, count, what, *(mesh.volume(self._reference) for mesh in (before, after))))
        return after


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
    """What became of shells that cross: the mesh with their union, of so many bodies, in their place.

    spare: (k,) shells left out, which lie in a body, are wound as it is, and cross nothing; untested: bodies whose
    boxes overlap that of another, where one is no manifold or has caps; folded: shells with edges of more than two
    faces, which may overlap themselves.
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

    So many `caps`, the last faces, are none of the surface and stay the last.

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
        tried = not capped.intersection(cluster) and pairs <= limits().mesh_overlaps
        region = _united(parts, bodies_of, nesting.copies, least) if tried else None
        if region is None:
            untested += len(bodies_of)
            spare[cluster] = False
        elif abs(volumes[~nesting.within[cluster]].sum() - region.volume(reference)) > least:
            bodies += len(bodies_of)
            spare[cluster], crossing[cluster] = False, True
            regions.append(region)
    kept, own = mesh.keep(~spare[label]), label[~spare[label]]
    _, faces = np.unique(own[:, None] * len(mesh.vertices) + kept.faces, return_inverse=True)
    edges = Edges.between(faces.reshape(-1, 3))
    folded = len(np.unique(own[(edges.count[edges.of] > 2).any(axis=1)]))
    whole = mesh.keep(~(spare | crossing)[label])
    if regions:
        regions.append(whole)
        firsts = np.cumsum([0, *(len(part.vertices) for part in regions)])
        faces = np.concatenate([part.faces + first for part, first in zip(regions, firsts[:-1], strict=True)])
        whole = Indexed(np.concatenate([part.vertices for part in regions]), faces)
    return United(whole, bodies, spare, untested, folded)


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


def _united(
    shells: dict[int, Indexed], cavities: dict[int, list[int]], copies: Numbers, least: float
) -> Indexed | None:
    """Return the union of bodies, each without its cavities; of cavities that cross, where they are less than bodies.
    Where facets nearly coincide a boolean may fail, which shows in its volume when it is done again in another pose:
    None if no two poses agree within `least`, or a shell is no manifold. `cavities`: their names, of each body."""
    from manifold3d import Manifold, OpType

    inner = [name for name in shells if name not in cavities]
    boxes = [triangle_boxes(shells[name].corners) for name in inner]
    cross = any(may_cross(one, other) for one, other in combinations(boxes, 2))
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


def _more_bodies_than_cavities(bodies: list[tuple[Any, int]], cavities: list[tuple[Any, int]]) -> Any:
    """Return all bodies but for where at least n cavities are and at most n bodies, for any n; each so often."""
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
