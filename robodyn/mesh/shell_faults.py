"""Shells of a closed surface that are wound the wrong way or reach into each other, without repairing any."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robodyn.mesh.indexed import Mask, Numbers, components, triple
from robodyn.mesh.inside import Interior
from robodyn.mesh.triangles import Floats, Triangles

_PAIRS = 16
"""Pairs of shells that are tried for what they share."""
_BODIES = 16
"""Bodies in which an inward shell may be a cavity; where more are around it, it is not judged."""
_POINTS = 6
"""Points of a shell that are tried: centres of its largest triangles."""
_FLAT = 1e-9
"""Volume over that of the box below which a shell has no inside."""
_DEEP = 1e-4
"""How far into another shell's box a point must lie, over its size, to be tried."""
_ODD = np.uint64(0x9E3779B97F4A7C15)
_HALF = np.uint64(29)


def shell_faults(triangles: Triangles) -> tuple[int, bool]:
    """How many shells are wound inwards without being cavities, and whether two wound outwards share volume.

    Shells are the components of triangles that share corners. One that is wound inwards is a cavity if it lies in one
    wound outwards; two wound outwards of which one has points within the other count what they share twice. A few
    points of each shell are tried, and of many shells only the pairs that share most of their boxes: what is found is
    there, but shells that hardly meet may be missed.

    Args:
        triangles: a closed surface.
    """
    shells = _Shells.of(triangles.array())
    solid = np.abs(shells.volumes) > _FLAT * np.prod(shells.hi - shells.lo, axis=1)
    bodies, inward = solid & (shells.volumes > 0), np.flatnonzero(solid & (shells.volumes < 0))
    inside = _Interiors(shells)
    inverted = sum(not _may_be_cavity(shells, inside, int(one), bodies) for one in inward)
    return inverted, any(inside.reaches(one, body) for one, body in _pairs(shells, bodies))


@dataclass(frozen=True, eq=False)
class _Shells:
    """Triangles (m, 3, 3) of each shell, their volumes (k,), and the corners (k, 3) of their boxes."""

    corners: list[Floats]
    volumes: Floats
    lo: Floats
    hi: Floats

    @classmethod
    def of(cls, corners: Floats) -> _Shells:
        parts = _apart(corners)
        volumes = np.array([float(triple(part - part[0, 0]).sum()) / 6 for part in parts])
        lo, hi = (np.array([find(part, axis=(0, 1)) for part in parts]) for find in (np.min, np.max))
        return cls(parts, volumes, lo, hi)

    def shared(self, body: int, others: Mask) -> Floats:
        """(k,) volume that the boxes of other shells share with that of a body."""
        common = np.minimum(self.hi, self.hi[body]) - np.maximum(self.lo, self.lo[body])
        volume: Floats = np.where((common > 0).all(axis=1) & others, np.prod(common, axis=1), 0.0)
        volume[body] = 0.0
        return volume


class _Interiors:
    """The insides of bodies, each made when it is first asked for."""

    def __init__(self, shells: _Shells) -> None:
        self._shells = shells
        self._known: dict[int, Interior] = {}

    def found(self, one: int, body: int) -> Iterator[bool | None]:
        """Whether points of a shell that lie well within the box of a body lie in the body; None is on its surface."""
        points = _points(self._shells.corners[one], self._shells.lo[body], self._shells.hi[body])
        if len(points) and body not in self._known:
            self._known[body] = Interior(self._shells.corners[body])
        for point in points:
            yield self._known[body].has(point)

    def reaches(self, one: int, body: int) -> bool:
        return any(self.found(one, body))


def _may_be_cavity(shells: _Shells, inside: _Interiors, one: int, bodies: Mask) -> bool:
    around = np.flatnonzero(shells.shared(one, bodies))
    if len(around) > _BODIES:
        return True
    return any(inside.reaches(one, int(body)) for body in around)


def _pairs(shells: _Shells, bodies: Mask) -> list[tuple[int, int]]:
    """Bodies and others whose boxes share volume, those that share most of the first first."""
    size = np.prod(shells.hi - shells.lo, axis=1)
    shares = []
    for body in np.flatnonzero(bodies):
        volume = shells.shared(int(body), bodies)
        shares += [(-volume[one] / size[one], int(one), int(body)) for one in np.flatnonzero(volume)]
    return [(one, body) for _, one, body in sorted(shares)[:_PAIRS]]


def _points(shell: Floats, lo: Floats, hi: Floats) -> Floats:
    """Centres of the largest triangles that lie well within a box."""
    centres: Floats = (shell[:, 0] + shell[:, 1] + shell[:, 2]) / 3
    margin = _DEEP * (hi - lo)
    near = np.flatnonzero(((centres > lo + margin) & (centres < hi - margin)).all(axis=1))
    if len(near) > _POINTS:
        a, b, c = shell[near].transpose(1, 0, 2)
        area = (np.cross(b - a, c - a) ** 2).sum(axis=1)
        near = near[np.argpartition(-area, _POINTS)[:_POINTS]]
    return centres[near]


def _apart(corners: Floats) -> list[Floats]:
    """The triangles of each shell."""
    number = _numbers(corners.reshape(-1, 3)).reshape(-1, 3)
    a, b = np.concatenate([number[:, 0], number[:, 0]]), np.concatenate([number[:, 1], number[:, 2]])
    label = components(int(number.max()) + 1, a, b)[number[:, 0]]
    order = np.argsort(label, kind="stable")
    firsts = np.flatnonzero(np.diff(label[order], prepend=-1))
    return [corners[rows] for rows in np.split(order, firsts[1:])]


def _numbers(points: Floats) -> Numbers:
    """(n,) numbers of points, equal where they are, by 64 bits of their hashes."""
    bits = (points + 0.0).view(np.uint64).reshape(-1, 3)
    words = bits[:, 0] * _ODD
    for k in (1, 2):
        words = ((words ^ (words >> _HALF)) + bits[:, k]) * _ODD
    _, number = np.unique(words ^ (words >> _HALF), return_inverse=True)
    return number.reshape(-1)
