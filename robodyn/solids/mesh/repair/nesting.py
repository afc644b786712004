"""Which shells are bodies, which are cavities in them, and which bound nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robodyn.solids.mesh.distinct import Numbers
from robodyn.solids.mesh.indexed import Indexed, Mask, areas, in_parts, triple
from robodyn.solids.mesh.repair.inside import Interior, OpenInterior
from robodyn.solids.mesh.repair.shells import Shells
from robodyn.support.floats import Floats

_NOISE = 1e-13
"""Volume over the sum of the sizes of its terms below which a shell is flat and has no sign."""

NOWHERE, IN_PATCHES = -1, -2
"""What lies in no closed shell: in none at all, or in what open shells enclose."""

_LARGEST = 64
"""Triangles of a shell whose centres are tried."""


@dataclass(frozen=True, eq=False)
class Nesting:
    """Shells with their winding made right, without those inside a body that are wound as it is.

    Attributes:
        shells: bodies wound outwards, cavities inwards. whole: the mesh with those that are left out.
        body: (k,) the shell of the body that each is, or is a cavity in; -1 for open and for flat ones.
        bodies: how many were turned outwards. cavities: how many inwards.
        within: shells left out, since they bound nothing: they lie in a body and are wound as it is.
        less: by how much the volume is smaller where such shells are cavities.
    """

    shells: Shells
    whole: Indexed
    body: Numbers
    bodies: int
    cavities: int
    within: int
    less: float


def nested(shells: Shells, caps: int = 0, cavities: bool = False) -> Nesting:
    """Decide by winding numbers which closed shells are bodies and which cavities.

    A shell that lies in no body is one, and turned outwards if need be, with all that is in it. In a body, one wound
    against it takes one off the winding number, which is 1 there; where none is left is a cavity. One wound as the body
    is adds one, and so bounds nothing: two bodies of which one lies in the other are as much as their union.

    A shell is in another if its box is and none of a few of its points is outside, but one is inside. Open shells taken
    together count as one, wound outwards by its volume with caps, and around others by its winding number.

    Args:
        caps: so many of the last faces are none of the surface; with them it is closed.
        cavities: a shell in a body is a cavity, however it is wound.
    """
    volumes, flat = _volumes(shells)
    parent, order = _parents(shells, np.abs(volumes), shells.closed & ~flat, _open(shells, caps))
    patches = volumes[~shells.closed].sum()
    inside_out = bool(patches < 0 and not flat[~shells.closed].all())
    ways = np.where(volumes < 0, -1, 1)
    state, other = (_States(parent, order, ways, -1 if inside_out else 1, each) for each in (cavities, True))
    wrong = np.where(shells.closed, state.turned, inside_out)
    keeps = ~state.within[shells.label]
    whole = shells.mesh.turned(wrong[shells.label])
    return Nesting(
        shells=replace(shells, mesh=whole.keep(keeps), label=shells.label[keeps]),
        whole=whole,
        body=state.body,
        bodies=int((wrong & ~state.inward).sum()),
        cavities=int((wrong & state.inward).sum()),
        within=int(state.within.sum()),
        less=float((np.abs(volumes) * (state.adds - other.adds)).sum()),
    )


class _States:
    """What shells are, decided from the outermost ones inwards.

    Attributes:
        body: (k,) see `Nesting`. turned, inward, within: (k,) whether each has to be turned, is wound inwards then, and
            bounds nothing.
    """

    def __init__(self, parent: Numbers, order: list[int], ways: Numbers, patches: int, cavities: bool) -> None:
        """
        Args:
            parent: (k,) the shell around each, `NOWHERE` or `IN_PATCHES`. order: of closed shells, outer ones first.
            ways: (k,) 1 for a positive volume, otherwise -1. patches: the same of open shells together.
            cavities: see `nested`.
        """
        self.body = np.full(len(parent), -1, np.int64)
        self.turned, self.inward, self.within = np.zeros((3, len(parent)), np.bool_)
        winding, sense, home = {NOWHERE: 0, IN_PATCHES: 1}, {IN_PATCHES: patches}, {IN_PATCHES: -1}
        for shell in order:
            outer, way = int(parent[shell]), int(ways[shell])
            around = winding[outer]
            sense[shell] = sense[outer] if around else way
            inward = around > 0 and (cavities or way != sense[shell])
            winding[shell] = around - 1 if inward else around + 1
            self.body[shell] = home[shell] = home[outer] if around else shell
            self.inward[shell] = inward
            self.within[shell] = around > 0 and not (around == 1 and inward)
            self.turned[shell] = way != (-1 if inward else 1)

    @property
    def adds(self) -> Numbers:
        """(k,) what each closed shell does to the volume with its own: adds it, takes it off, or nothing."""
        ways: Numbers = np.where(self.within | (self.body < 0) & ~self.inward, 0, np.where(self.inward, -1, 1))
        return ways


def _volumes(shells: Shells) -> tuple[Floats, Mask]:
    """(k,) signed volume of each shell, about a corner of its own; and which vanish but for rounding."""
    corners = shells.mesh.corners
    _, first = np.unique(shells.label, return_index=True)
    terms = triple(corners - corners[first, 0][shells.label][:, None]) / 6
    volumes: Floats = np.bincount(shells.label, terms, shells.count).astype(np.float64)
    flat: Mask = np.abs(volumes) <= _NOISE * np.bincount(shells.label, np.abs(terms), shells.count)
    return volumes, flat


def _open(shells: Shells, caps: int) -> OpenInterior | None:
    """Return what open shells enclose, if there are some."""
    chosen = ~shells.closed[shells.label]
    chosen[len(chosen) - caps :] = False
    return OpenInterior(shells.mesh.keep(chosen)) if chosen.any() else None


def _parents(shells: Shells, sizes: Floats, proper: Mask, patches: OpenInterior | None) -> tuple[Numbers, list[int]]:
    """Return the smallest shell around each, and closed shells from the largest down."""
    corners, lo, hi = in_parts(shells.mesh.corners, shells.label)
    interiors: dict[int, Interior] = {}
    parent = np.full(shells.count, NOWHERE, np.int64)
    down = [shell for shell in np.argsort(-sizes, kind="stable").tolist() if proper[shell]]
    for shell in down:
        around = proper & (sizes > sizes[shell]) & (lo <= lo[shell]).all(axis=1) & (hi >= hi[shell]).all(axis=1)
        points = _points(corners[shell]) if around.any() or patches else []
        for other in sorted(np.flatnonzero(around).tolist(), key=sizes.__getitem__):
            if other not in interiors:
                interiors[other] = Interior(corners[other])
            if _holds(interiors[other], points):
                parent[shell] = other
                break
        else:
            parent[shell] = IN_PATCHES if patches is not None and _holds(patches, points) else NOWHERE
    return parent, down


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
    largest = np.argsort(areas(corners), kind="stable")[-_LARGEST:]
    return [*points[ends], *corners[largest].mean(axis=1)]
