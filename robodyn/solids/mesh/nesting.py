"""Which shells are bodies, which are cavities in them, and which bound nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from robodyn.errors import MeshError
from robodyn.solids.mesh.indexed import Indexed, Mask, Numbers, areas, in_parts, merged, triple
from robodyn.solids.mesh.inside import Interior, may_cross, solid, triangle_boxes, winding_numbers
from robodyn.solids.mesh.shells import Shells
from robodyn.support.floats import Floats
from robodyn.support.input_file import beyond, limits

_NOISE = 1e-13
"""Volume over the sum of the sizes of its terms below which a shell is flat and has no sign."""
IN_PATCHES = -1
"""Stands for open shells taken together."""
_TOUCH = 1e-11
"""Share of its volume that a shell may have outside another, and still lie in it."""
_LARGEST = 16
"""Triangles of a shell whose centres are tried."""


@dataclass(frozen=True, eq=False)
class Nesting:
    """Shells with bodies wound outwards and cavities inwards, and how many were turned so; the rest: see `_States`.

    uneven: whether faces of one shell were given more often than others, where there are cavities; cuts: the cavities
    that are cut out of each body, by its shell, where these do not cross; proper: (k,) which are closed, not flat, and
    in no open ones; less: by how much the volume is smaller where those within are cavities.
    """

    shells: Shells
    uneven: bool
    copies: Numbers
    cuts: dict[int, list[int]]
    inward: Mask
    within: Mask
    proper: Mask
    bodies: int
    cavities: int
    less: float


def nested(
    shells: Shells, copies: Numbers | None = None, caps: int = 0, cavities: bool = False, name: str | None = None
) -> Nesting:
    """Decide by winding numbers which closed shells are bodies and which cavities.

    A shell that lies in no body is one, and turned outwards if need be, with all that is in it. In a body, one wound
    against it takes one off the winding number, which is 1 there; where none is left is a cavity. One wound as the body
    is adds one, and so bounds nothing: two bodies of which one lies in the other are as much as their union. A shell
    counts as often as it was given: a body given as a solid and once more with a cavity is solid.

    A shell is in another if its box is, none of a few of its points is outside, but one is inside, and it has no volume
    outside. Open shells taken together count as one, wound outwards by its volume with caps, and around others by its
    winding number.

    Raises MeshError, with the name of the mesh, where shells are too many to be placed.

    Args:
        copies: (m,) how often each of the first faces was given.
        caps: so many of the last faces are none of the surface; with them it is closed.
        cavities: a shell in a body is a cavity, however it is wound and however often it was given.
    """
    often = np.ones(len(shells.label), np.int64)
    if copies is not None:
        often[: len(copies)] = copies
    least, most = np.full(shells.count, often.max(initial=1)), np.ones(shells.count, np.int64)
    np.minimum.at(least, shells.label, often)
    np.maximum.at(most, shells.label, often)
    corners = shells.mesh.corners
    _, first = np.unique(shells.label, return_index=True)
    terms = triple(corners - corners[first, 0][shells.label][:, None]) / 6  # about a corner of each shell
    volumes: Floats = np.bincount(shells.label, terms, shells.count).astype(np.float64)
    flat: Mask = np.abs(volumes) <= _NOISE * np.bincount(shells.label, np.abs(terms), shells.count)
    closed = shells.closed & ~flat
    gaping = ~shells.closed[shells.label]
    gaping[len(gaping) - caps :] = False
    around, order = _containers(shells, volumes, closed, shells.mesh.keep(gaping) if gaping.any() else None, name)
    patches = volumes[~shells.closed].sum()
    inside_out = bool(patches < 0 and not flat[~shells.closed].all())
    ways = np.where(volumes < 0, -1, 1)
    state, other = (_States(around, order, ways, least, -1 if inside_out else 1, each) for each in (cavities, True))
    wrong = np.where(shells.closed, state.turned, inside_out)
    return Nesting(
        shells=replace(shells, mesh=shells.mesh.turned(wrong[shells.label])),
        copies=state.copies,
        cuts=state.cuts,
        uneven=bool((least < most).any() and state.inward.any()),
        inward=state.inward,
        within=state.within,
        proper=closed & ~state.patched,
        bodies=int((wrong & ~state.inward).sum()),
        cavities=int((wrong & state.inward).sum()),
        less=float((np.abs(volumes) * closed * (state.adds - other.adds)).sum()),
    )


class _States:
    """What shells are, decided from the outermost ones inwards; copies, cuts: see `Nesting`. turned, inward, within,
    patched: (k,) whether each has to be turned, is wound inwards then, bounds nothing, and lies in what open shells
    enclose."""

    def __init__(
        self, around: list[list[int]], order: list[int], ways: Numbers, copies: Numbers, patches: int, cavities: bool
    ) -> None:
        """`around`: shells around each, the smallest first, and `IN_PATCHES`; `order`: of closed ones, from outside;
        `ways`: (k,) 1 for a positive volume, otherwise -1; `patches`: the same of open shells; `copies`: (k,)."""
        self.turned, self.inward, self.within, self.patched = np.zeros((4, len(ways)), np.bool_)
        self.cuts: dict[int, list[int]] = {}
        self.copies = np.ones_like(copies) if cavities else copies.copy()
        taken: dict[tuple[int, int], int] = {}
        winding, sense = {IN_PATCHES: 1}, {IN_PATCHES: patches}
        for shell in order:
            before, way = sum(winding[outer] for outer in around[shell]), int(ways[shell])
            sense[shell] = sense[around[shell][0]] if before > 0 else way
            inward = before > 0 and (cavities or way != sense[shell])
            if inward:
                self.copies[shell] = min(self.copies[shell], before)
            often = int(self.copies[shell])
            winding[shell] = -often if inward else often
            for body in (each for each in around[shell] if inward and each >= 0 and not self.inward[each]):
                room = int(self.copies[body]) - sum(taken.get((outer, body), 0) for outer in around[shell])
                taken[shell, body] = min(often, room)
                often -= taken[shell, body]
                if taken[shell, body] == room > 0:
                    self.cuts.setdefault(body, []).append(shell)
            self.patched[shell] = IN_PATCHES in around[shell]
            self.inward[shell] = inward
            self.within[shell] = before > 0 and before + winding[shell] > 0
            self.turned[shell] = way != (-1 if inward else 1)

    @property
    def adds(self) -> Numbers:
        """(k,) what each closed shell does to the volume with its own: adds it, takes it off, or nothing."""
        ways: Numbers = np.where(self.within, 0, np.where(self.inward, -1, 1))
        return ways


def _containers(
    shells: Shells, volumes: Floats, proper: Mask, patches: Indexed | None, name: str | None
) -> tuple[list[list[int]], list[int]]:
    """Return the shells around each, the smallest first, and closed shells from the largest down."""
    corners, lo, hi = in_parts(shells.mesh.corners, shells.label)
    sizes = np.abs(volumes)
    interiors: dict[int, Interior] = {}
    boxes = cache(lambda shell: triangle_boxes(corners[shell]))
    found: list[list[int]] = [[] for _ in sizes]
    tried, most = 0, limits().mesh_nesting
    down = [shell for shell in np.argsort(-sizes, kind="stable").tolist() if proper[shell]]
    for shell in down:
        around = proper & (sizes > sizes[shell]) & (lo <= lo[shell]).all(axis=1) & (hi >= hi[shell]).all(axis=1)
        points: list[Floats] = []  # its extremes along the axes, and the centres of its largest triangles
        if around.any() or patches is not None:
            every = corners[shell].reshape(-1, 3)
            largest = np.argsort(areas(corners[shell]), kind="stable")[-_LARGEST:]
            extremes = np.concatenate([every.argmin(axis=0), every.argmax(axis=0)])
            points = [*every[extremes], *corners[shell][largest].mean(axis=1)]
        for other in sorted(np.flatnonzero(around).tolist(), key=sizes.__getitem__):
            if other not in interiors:
                interiors[other] = Interior(corners[other])
            near = may_cross(boxes(shell), boxes(other))
            tried += len(points) if near else 1
            if tried > most:
                what = f"{len(sizes)} shells to be placed in each other by {tried} points"
                raise beyond("mesh_nesting", what, MeshError, file=name)
            if not _holds(interiors[other], points, all_of_them=near):
                continue
            if near:  # it may have volume outside the other, which is told where both are manifolds
                one, two = (solid(merged(corners[each])) for each in (shell, other))
                if None not in (one, two) and (one - two).volume() > _TOUCH * one.volume():
                    continue
            found[shell].append(other)
        if patches is not None and all(abs(winding_numbers(point[None], patches)[0]) > 0.5 for point in points):
            found[shell].append(IN_PATCHES)
    return found, down


def _holds(interior: Interior, points: list[Floats], all_of_them: bool) -> bool:
    """Return whether points lie in a shell, as far as that can be told; or whether the first does for which it can."""
    found = False
    for point in points:
        answer = interior.has(point)
        if answer is False:
            return False
        found = found or answer is True
        if found and not all_of_them:
            break
    return found
