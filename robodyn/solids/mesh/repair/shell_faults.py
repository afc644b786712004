"""Shells of a closed surface that are wound the wrong way or reach into each other, without repairing any."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robodyn.solids.mesh.distinct import Numbers, hashed
from robodyn.solids.mesh.indexed import Mask, components, in_parts, triple
from robodyn.solids.mesh.repair.inside import Interior
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.floats import Floats

_PAIRS = 16
"""Pairs of shells that are tried for what they share."""
_BODIES = 16
"""Bodies in which an inward shell may be a cavity; where more are around it, it is not judged."""
_POINTS = 16
"""Points of a shell that are tried."""
_FLAT = 1e-9
"""Volume over that of the box below which a shell has no inside."""
_DEEP = 1e-4
"""How far into another shell's box a point must lie, over its size, to be tried."""


def shell_faults(triangles: Triangles) -> tuple[int, bool]:
    """Return how many shells are wound inwards without being cavities, and whether two wound outwards share volume.

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
    return inverted, any(inside.overlap(one, body, inward) for one, body in _pairs(shells, bodies))


@dataclass(frozen=True, eq=False)
class _Shells:
    """Triangles (m, 3, 3) of each shell, their volumes (k,), and the corners (k, 3) of their boxes."""

    corners: list[Floats]
    volumes: Floats
    lo: Floats
    hi: Floats

    @classmethod
    def of(cls, corners: Floats) -> _Shells:
        parts, lo, hi = in_parts(corners, _labels(corners))
        volumes = np.array([float(triple(part - part[0, 0]).sum()) / 6 for part in parts])
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

    def reaching(self, one: int, body: int) -> Iterator[Floats]:
        """Points (3,) of a shell that lie in a body."""
        for point in _points(self._shells.corners[one], self._shells.lo[body], self._shells.hi[body]):
            if self._has(body, point):
                yield point

    def overlap(self, one: int, body: int, inward: Numbers) -> bool:
        """Return whether a body has points in another, outside the cavities among these shells."""
        cavities = [int(shell) for shell in inward]
        return any(not any(self._has(shell, point) for shell in cavities) for point in self.reaching(one, body))

    def _has(self, shell: int, point: Floats) -> bool:
        if not ((self._shells.lo[shell] < point) & (point < self._shells.hi[shell])).all():
            return False
        if shell not in self._known:
            self._known[shell] = Interior(self._shells.corners[shell])
        return bool(self._known[shell].has(point))


def _may_be_cavity(shells: _Shells, inside: _Interiors, one: int, bodies: Mask) -> bool:
    around = np.flatnonzero(shells.shared(one, bodies))
    if len(around) > _BODIES:
        return True
    return any(True for body in around for _ in inside.reaching(one, int(body)))


def _pairs(shells: _Shells, bodies: Mask) -> list[tuple[int, int]]:
    """Bodies and others whose boxes share volume, those that share most of the first first."""
    size = np.prod(shells.hi - shells.lo, axis=1)
    shares = []
    for body in np.flatnonzero(bodies):
        volume = shells.shared(int(body), bodies)
        shares += [(-volume[one] / size[one], int(one), int(body)) for one in np.flatnonzero(volume)]
    return [(one, body) for _, one, body in sorted(shares)[:_PAIRS]]


def _points(shell: Floats, lo: Floats, hi: Floats) -> Floats:
    """Corners and centres of triangles and of their sides, well within a box, those of the largest triangles."""
    a, b, c = shell.transpose(1, 0, 2)
    margin = _DEEP * (hi - lo)
    points = np.concatenate([(a + b + c) / 3, (a + b) / 2, (b + c) / 2, (c + a) / 2, a, b, c])
    near = np.flatnonzero(((points > lo + margin) & (points < hi - margin)).all(axis=1))
    if len(near) > _POINTS:
        rows = near % len(shell)
        area = (np.cross(b[rows] - a[rows], c[rows] - a[rows]) ** 2).sum(axis=1)
        near = near[np.lexsort((-area, near // len(shell)))[:_POINTS]]
    chosen: Floats = points[near]
    return chosen


def _labels(corners: Floats) -> Numbers:
    """(m,) the shell of each triangle."""
    _, number = np.unique(hashed(corners.transpose(1, 2, 0)), return_inverse=True)
    one, two, three = number.reshape(3, -1)
    return components(int(number.max()) + 1, np.concatenate([one, one]), np.concatenate([two, three]))[one]
