"""Bodies that overlap, made one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from robodyn.solids.mesh.distinct import Numbers
from robodyn.solids.mesh.indexed import Edges, Indexed, Mask, components, in_parts
from robodyn.solids.mesh.repair.nesting import Nesting
from robodyn.support.floats import Floats

_TOUCH = 1e-11
"""Volume that bodies may share, of the sum of their volumes, and still only touch."""


@dataclass(frozen=True, eq=False)
class United:
    """What became of bodies that overlap.

    Attributes:
        mesh: with the union in their place.
        bodies: that were united, none if no two share any volume.
        untested: bodies whose boxes overlap that of another, where one is no manifold or has caps: they may overlap.
        folded: shells with edges of more than two faces: they may overlap themselves.
    """

    mesh: Indexed
    bodies: int = 0
    untested: int = 0
    folded: int = 0


def united(nesting: Nesting, caps: int = 0) -> United:
    """Return the union of bodies that share volume, by `manifold3d` (a robust boolean of triangle meshes).

    A body is a shell with the cavities right within it. Only bodies with boxes that overlap are tried.

    Args:
        caps: so many of the last faces are none of the surface; they stay the last.

    Accuracy: volume and second moments of two convex bodies with curved faces within 1e-15 of those of their union in
        exact rationals, and within 1e-12 where they are a thousand of their sizes away from the origin.
    """
    body = nesting.body[nesting.shells.label]
    clusters = _clusters(nesting.shells.mesh.corners, body)
    mesh = nesting.shells.mesh
    found = United(mesh, folded=_folded(mesh, nesting.shells.label))
    stays, extra = np.ones(len(mesh.faces), np.bool_), []
    capped = set(body[len(body) - caps :].tolist())
    for cluster in clusters:
        parts = [] if capped.intersection(cluster) else [body == name for name in cluster]
        solids = [manifold(*_apart(mesh, nesting.shells.label, part)) for part in parts]
        if not solids or None in solids:
            found = replace(found, untested=found.untested + len(cluster))
            continue
        union = _union(solids)
        if union is not None:
            found = replace(found, bodies=found.bodies + len(cluster))
            stays &= ~np.isin(body, cluster)
            extra.append(union)
    return replace(found, mesh=_joined([*extra, mesh.keep(stays)])) if extra else found


def _clusters(corners: Floats, body: Numbers) -> list[list[int]]:
    """Bodies that are connected by overlapping boxes, two or more at a time."""
    solid = body >= 0
    names = np.unique(body[solid])
    if len(names) < 2:
        return []
    _, lo, hi = in_parts(corners[solid], body[solid])
    links = [np.flatnonzero(((lo < hi[k]) & (lo[k] < hi)).all(axis=1)) for k in range(len(names))]
    from_body = np.repeat(np.arange(len(names)), [len(link) for link in links])
    label = components(len(names), from_body, np.concatenate(links))
    return [names[label == k].tolist() for k in np.flatnonzero(np.bincount(label) > 1)]


def _folded(mesh: Indexed, label: Numbers) -> int:
    edges = Edges.between(_apart(mesh, label, np.ones(len(label), np.bool_))[1])
    return len(np.unique(label[(edges.count[edges.of] > 2).any(axis=1)]))


def _apart(mesh: Indexed, label: Numbers, chosen: Mask) -> tuple[Floats, Numbers]:
    """Vertices and faces of the chosen faces, with no vertex in more than one shell."""
    own = label[chosen, None] * len(mesh.vertices) + mesh.faces[chosen]
    keys, faces = np.unique(own, return_inverse=True)
    return mesh.vertices[keys % len(mesh.vertices)], faces.reshape(-1, 3)


def manifold(vertices: Floats, faces: Numbers) -> Any:
    """Return a body for manifold3d, None if it is no manifold."""
    from manifold3d import Error, Manifold, Mesh64

    solid = Manifold(Mesh64(vertices, faces.astype(np.uint64)))
    return solid if solid.status() == Error.NoError else None


def _union(solids: list[Any]) -> Indexed | None:
    """None if the solids share no volume."""
    from manifold3d import Manifold, OpType

    total = sum(solid.volume() for solid in solids)
    union = Manifold.batch_boolean(solids, OpType.Add)
    if total - union.volume() <= _TOUCH * total:
        return None
    mesh = union.to_mesh64()
    return Indexed(np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, np.int64))


def _joined(parts: list[Indexed]) -> Indexed:
    firsts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + first for part, first in zip(parts, firsts[:-1], strict=True)]
    return Indexed(np.concatenate([part.vertices for part in parts]), np.concatenate(faces))
