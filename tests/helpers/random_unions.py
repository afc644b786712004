"""Random bodies in one mesh: hollow, filled exactly, flush, overlapping, given twice, inverted; and their true union.

The truth is by `manifold3d` from primitives whose role is known: the union of all bodies, each without its cavities.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from manifold3d import Manifold, Mesh64, OpType

from helpers.mesh_samples import Floats, box, cone, cylinder, flipped, moved, uv_sphere

Generator = np.random.Generator


@dataclass
class Body:
    """A shell (m, 3, 3) wound outwards, and those of its cavities, wound outwards as well."""

    outer: Floats
    cavities: list[Floats] = field(default_factory=list)

    def shells(self) -> Floats:
        """As a file has it."""
        return np.concatenate([self.outer, *map(flipped, self.cavities)])


@dataclass
class Union:
    """What is in a file, (m, 3, 3), and what it encloses: volume, centre (3,) and inertia (3, 3) about it."""

    soup: Floats
    kinds: tuple[str, ...]
    volume: float
    com: Floats
    inertia: Floats


def random_union(seed: int) -> Union:
    """Bodies in one another, beside, across and upon each other, moved together, their triangles in any order."""
    rng = np.random.default_rng(seed)
    bodies, kinds = [Body(_primitive(rng, 2.0))], []
    for _ in range(rng.integers(1, 5)):
        kind = str(rng.choice(list(_STEPS)))
        if _STEPS[kind](rng, bodies):
            kinds.append(kind)
    parts = [body.shells() for body in bodies]
    if rng.random() < 0.2:
        _apart(rng, bodies)
        parts.append(flipped(bodies[-1].shells()))
        kinds.append("inverted")
    truth = _union(bodies)
    for _ in range(int(rng.integers(0, 2))):
        parts.append(parts[rng.integers(len(parts))].copy())
        kinds.append("twice")
    soup = rng.permutation(np.concatenate(parts))
    turns = (rng.integers(3, size=len(soup))[:, None] + np.arange(3)) % 3
    soup = np.take_along_axis(soup, turns[:, :, None], axis=1)
    if rng.random() < 0.15:
        soup, _ = flipped(soup), kinds.append("inside out")
    R, shift = _rotation(rng), rng.uniform(-5, 5, 3)
    volume, com, inertia = _moments(truth)
    return Union(moved(soup, shift, R), tuple(kinds), volume, R @ com + shift, R @ inertia @ R.T)


def _primitive(rng: Generator, size: float) -> Floats:
    """About the origin, about so large, with some coordinates that others share."""
    round_to = 0.25 * size
    a, b, c = round_to * rng.integers(2, 6, 3)
    which = rng.integers(5)
    if which == 0:
        return uv_sphere(a, rings=int(rng.integers(4, 12)), sectors=int(rng.integers(5, 20)))
    if which == 1:
        return cylinder(a, 2 * b, sectors=int(rng.integers(5, 24)))
    if which == 2:
        return moved(cone(a, 2 * b, sectors=int(rng.integers(5, 24))), (0, 0, -b))
    return box((2 * a, 2 * b, 2 * c))


def _rotation(rng: Generator) -> Floats:
    if rng.random() < 0.3:
        return np.eye(3)
    Q, R = np.linalg.qr(rng.normal(size=(3, 3)))
    Q = Q * np.sign(np.diag(R))
    return Q * np.sign(np.linalg.det(Q))


def _within(rng: Generator, shell: Floats) -> Floats:
    """A shell that lies in a convex one: it made smaller, or another primitive amid it."""
    centre = np.unique(shell.reshape(-1, 3), axis=0).mean(axis=0)
    if rng.random() < 0.6:
        return (shell - centre) * rng.uniform(0.4, 0.9) + centre
    primitive = _primitive(rng, 1.0)
    reach = np.linalg.norm(primitive, axis=2).max()
    a, b, c = shell.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    room = np.abs(((a - centre) * normal).sum(axis=1) / np.linalg.norm(normal, axis=1)).min()
    return primitive * (rng.uniform(0.3, 0.9) * room / reach) @ _rotation(rng).T + centre


def _hollow(rng: Generator, bodies: list[Body]) -> bool:
    solid = [body for body in bodies if not body.cavities]
    if not solid:
        return False
    body = solid[rng.integers(len(solid))]
    body.cavities.append(_within(rng, body.outer))
    return True


def _cavity(rng: Generator, bodies: list[Body]) -> Floats | None:
    every = [cavity for body in bodies for cavity in body.cavities]
    return every[rng.integers(len(every))] if every else None


def _insert(rng: Generator, bodies: list[Body]) -> bool:
    """The cavity's very facets, wound outwards; perhaps hollow itself, and so on."""
    cavity = _cavity(rng, bodies)
    if cavity is None and _hollow(rng, bodies):
        cavity = _cavity(rng, bodies)
    if cavity is None:
        return False
    bodies.append(Body(cavity.copy()))
    if rng.random() < 0.4:
        bodies[-1].cavities.append(_within(rng, cavity))
        if rng.random() < 0.5:
            bodies.append(Body(bodies[-1].cavities[0].copy()))
    return True


def _across(rng: Generator, bodies: list[Body]) -> bool:
    """A body that overlaps the wall of a cavity, turned any way."""
    cavity = _cavity(rng, bodies)
    if cavity is None and _hollow(rng, bodies):
        cavity = _cavity(rng, bodies)
    if cavity is None:
        return False
    corner = cavity[rng.integers(len(cavity)), rng.integers(3)]
    small = _primitive(rng, rng.uniform(0.1, 0.8)) @ _rotation(rng).T
    bodies.append(Body(moved(small, corner + rng.normal(size=3) * 0.05)))
    return True


def _loose(rng: Generator, bodies: list[Body]) -> bool:
    """A body free in a cavity."""
    cavity = _cavity(rng, bodies)
    if cavity is None:
        return False
    bodies.append(Body(_within(rng, cavity)))
    return True


def _solid_within(rng: Generator, bodies: list[Body]) -> bool:
    body = bodies[rng.integers(len(bodies))]
    bodies.append(Body(_within(rng, body.outer)))
    return True


def _overlapping(rng: Generator, bodies: list[Body]) -> bool:
    body = bodies[rng.integers(len(bodies))]
    corner = body.outer[rng.integers(len(body.outer)), rng.integers(3)]
    other = _primitive(rng, rng.uniform(0.3, 1.5)) @ _rotation(rng).T
    bodies.append(Body(moved(other, corner + rng.normal(size=3) * 0.1)))
    if rng.random() < 0.3:
        bodies[-1].cavities.append(_within(rng, bodies[-1].outer))
    return True


def _touching(rng: Generator, bodies: list[Body]) -> bool:
    """A body that stands beside another, with a side in the plane of its box; or a copy of it, moved by its length."""
    body = bodies[rng.integers(len(bodies))]
    lo, hi = body.outer.min(axis=(0, 1)), body.outer.max(axis=(0, 1))
    axis = int(rng.integers(3))
    other = body.outer.copy() if rng.random() < 0.5 else moved(_primitive(rng, 1.0), (lo + hi) / 2)
    shift = np.zeros(3)
    shift[axis] = hi[axis] - other.min(axis=(0, 1))[axis]
    bodies.append(Body(other + shift))
    return True


def _apart(rng: Generator, bodies: list[Body]) -> bool:
    far = max(np.abs(body.outer).max() for body in bodies) + 8
    bodies.append(Body(moved(_primitive(rng, 1.0), (far, 0, 0))))
    return True


_STEPS: dict[str, Callable[[Generator, list[Body]], bool]] = {
    "hollow": _hollow,
    "insert": _insert,
    "across": _across,
    "loose": _loose,
    "within": _solid_within,
    "overlapping": _overlapping,
    "touching": _touching,
    "apart": _apart,
}


def _solid(shell: Floats) -> Manifold:
    points, faces = np.unique(shell.reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
    found = Manifold(Mesh64(points, faces.reshape(-1, 3).astype(np.uint64)))
    assert found.volume() > 0
    return found


def _union(bodies: list[Body]) -> Manifold:
    solids = []
    for body in bodies:
        solid = _solid(body.outer)
        for cavity in body.cavities:
            solid = solid - _solid(cavity)
        solids.append(solid)
    return Manifold.batch_boolean(solids, OpType.Add)


def _moments(solid: Manifold) -> tuple[float, Floats, Floats]:
    """Volume, centre, and inertia about it."""
    mesh = solid.to_mesh64()
    corners = np.array(mesh.vert_properties)[:, :3][np.array(mesh.tri_verts, np.int64)]
    a, b, c = corners.transpose(1, 0, 2)
    V = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    total = a + b + c
    volume, first = V.sum(), (V[:, None] * total).sum(axis=0) / 4
    S = sum(np.einsum("m,mi,mj->ij", V, x, x) for x in (total, a, b, c)) / 20
    com = first / volume
    S = S - volume * np.outer(com, com)
    return float(volume), com, np.trace(S) * np.eye(3) - S


def boxes_volume(sizes: Floats, places: Floats) -> float:
    """Volume of the union of boxes along the axes about these places, by the cells between all their sides."""
    lo, hi = places - sizes / 2, places + sizes / 2
    cuts = [np.unique(np.concatenate([lo[:, k], hi[:, k]])) for k in range(3)]
    middles = np.meshgrid(*[(cut[1:] + cut[:-1]) / 2 for cut in cuts], indexing="ij")
    cells = np.prod(np.meshgrid(*[np.diff(cut) for cut in cuts], indexing="ij"), axis=0)
    x = np.stack(middles, axis=-1)[..., None, :]
    inside = ((x > lo) & (x < hi)).all(axis=-1).any(axis=-1)
    return float(cells[inside].sum())
