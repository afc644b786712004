"""Which shells are bodies and which are cavities in them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robodyn.mesh.indexed import Mask, Numbers, triple
from robodyn.mesh.inside import Interior, OpenInterior
from robodyn.mesh.shells import Shells
from robodyn.mesh.triangles import Floats

_NOISE = 1e-13
"""Volume over the sum of the sizes of its terms below which a shell is flat and has no sign."""

_LARGEST = 64
"""Triangles of a shell whose centres are tried."""


@dataclass(frozen=True, eq=False)
class Nesting:
    """Shells with their winding made right.

    Attributes:
        shells: those at an even depth wound outwards, those at an odd depth inwards.
        depth: (k,) how many closed shells each lies in, one within the other; -1 for open ones.
        parent: (k,) the smallest shell around each, -1 if there is none.
        bodies: how many were turned outwards. cavities: how many inwards.
    """

    shells: Shells
    depth: Numbers
    parent: Numbers
    bodies: int
    cavities: int


def nested(shells: Shells, caps: int = 0) -> Nesting:
    """Turn closed shells so that outermost ones are positive, those within them cavities, bodies in cavities positive.

    A shell is in another if its box is and none of a few of its points is outside, but one is inside. Open shells taken
    together count as one, wound outwards by its volume with caps, and around others by its winding number.

    Args:
        caps: so many of the last faces are none of the surface; with them it is closed.
    """
    volumes, flat = _volumes(shells)
    parent, depth = _parents(shells, np.abs(volumes), shells.closed & ~flat, _open(shells, caps))
    inward = shells.closed & (depth % 2 == 1)
    wrong = shells.closed & ~flat & ((volumes < 0) != inward)
    wrong |= ~shells.closed & ((volumes * ~shells.closed).sum() < 0) & ~flat[~shells.closed].all()
    after = replace(shells, mesh=shells.mesh.turned(wrong[shells.label]))
    return Nesting(after, depth, parent, int((wrong & ~inward).sum()), int((wrong & inward).sum()))


def _volumes(shells: Shells) -> tuple[Floats, Mask]:
    """(k,) signed volume of each shell, about a corner of its own; and which vanish but for rounding."""
    corners = shells.mesh.corners
    _, first = np.unique(shells.label, return_index=True)
    terms = triple(corners - corners[first, 0][shells.label][:, None]) / 6
    volumes: Floats = np.bincount(shells.label, terms, shells.count).astype(np.float64)
    flat: Mask = np.abs(volumes) <= _NOISE * np.bincount(shells.label, np.abs(terms), shells.count)
    return volumes, flat


def _open(shells: Shells, caps: int) -> OpenInterior | None:
    """What open shells enclose, if there are some."""
    chosen = ~shells.closed[shells.label]
    chosen[len(chosen) - caps :] = False
    return OpenInterior(shells.mesh.keep(chosen)) if chosen.any() else None


def _parents(shells: Shells, sizes: Floats, proper: Mask, patches: OpenInterior | None) -> tuple[Numbers, Numbers]:
    """The smallest shell around each and how deep each lies, from the largest shell down."""
    order = np.argsort(shells.label, kind="stable")
    starts = np.searchsorted(shells.label[order], np.arange(shells.count))
    corners = shells.mesh.corners[order]
    lo, hi = np.minimum.reduceat(corners.min(axis=1), starts), np.maximum.reduceat(corners.max(axis=1), starts)
    stops = np.append(starts[1:], len(order))
    interiors: dict[int, Interior] = {}
    parent = np.full(shells.count, -1, np.int64)
    depth = np.full(shells.count, -1, np.int64)
    for shell in np.argsort(-sizes, kind="stable"):
        if not proper[shell]:
            continue
        around = proper & (sizes > sizes[shell]) & (lo <= lo[shell]).all(axis=1) & (hi >= hi[shell]).all(axis=1)
        points = _points(corners[starts[shell] : stops[shell]]) if around.any() or patches else []
        for other in sorted(np.flatnonzero(around).tolist(), key=lambda k: depth[k], reverse=True):
            if other not in interiors:
                interiors[other] = Interior(corners[starts[other] : stops[other]])
            if _holds(interiors[other], points):
                parent[shell], depth[shell] = other, depth[other] + 1
                break
        else:
            depth[shell] = int(patches is not None and _holds(patches, points))
    return parent, depth


def _holds(interior: Interior | OpenInterior, points: list[Floats]) -> bool:
    found = False
    for point in points:
        answer = interior.has(point)
        if answer is False:
            return False
        found = found or answer is True
    return found


def _points(corners: Floats) -> list[Floats]:
    """Some points of a shell (n, 3, 3): its extremes along the axes, and the centres of its largest triangles."""
    points = corners.reshape(-1, 3)
    ends = np.concatenate([points.argmin(axis=0), points.argmax(axis=0)])
    a, b, c = corners.transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    largest = np.argsort(area)[-_LARGEST:]
    return [*points[ends], *corners[largest].mean(axis=1)]
