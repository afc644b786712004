"""What a surface encloses that overlaps itself, or is open: moments by columns in three directions, with error bars."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import length, product
from robodyn.solids.mesh.distinct import Numbers
from robodyn.solids.mesh.indexed import Indexed, Mask
from robodyn.solids.mesh.integrate.exact import VolumeIntegrals
from robodyn.solids.mesh.integrate.integrals import Integrals, integrate
from robodyn.solids.mesh.region.columns import Hits, Integers, Lattice, in_order
from robodyn.solids.mesh.repair.inside import winding_numbers
from robodyn.solids.mesh.triangles import MemoryTriangles
from robodyn.support.floats import Floats

COLUMNS = 16384
"""In each direction, through surfaces that are closed."""

LARGEST_BAR = 0.15
"""Above which an open surface has no definite volume: a sphere without a seventh has one, a box without a side not."""

_DIRECTIONS = np.array([(0.8203, -0.4115, 0.3971), (0.2391, 0.8770, 0.4168), (-0.5198, -0.2469, 0.8178)])
"""Nearly at right angles, and along nothing that a part has."""

_TOUCH = 1e-11
"""Volume that bodies may share, of the volume of all, and still only touch."""

_HITS = 5e5
"""Of columns with a surface, at most, about: each takes some 600 bytes."""

_ANGLES = 4e6
"""Solid angles of caps that are taken in each direction, about."""

_FEWEST, _MOST = 64, 4096
"""Columns in each direction through an open surface."""

_TOO_MANY = 10
"""Times as many are not taken; nothing definite is said then."""

_LEVELS = 1 / 2, 1 / 3, 2 / 3

_BRACKET = 2.0
"""Error bar of an open region over the volume between the winding numbers 1/3 and 1/2, or 1/2 and 2/3."""


@dataclass(frozen=True, eq=False)
class Quadrature(VolumeIntegrals):
    """Integrals over a region that are known to an error bar.

    Attributes:
        bar: of the error of the volume relative to it, and of the error of the second moments about the centre relative
            to the largest of them.
        method: "columns" or "winding numbers".
    """

    bar: float
    method: str


def by_columns(mesh: Indexed) -> Quadrature | None:
    """Moments of the region where the winding number of a closed surface is positive; None if it is 0 or 1 everywhere.

    The signed integral counts every point as often as its winding number says. What it counts too often is integrated
    over columns and taken off: an overlap that is a tenth of the body is needed to a tenth of the digits only. Overlaps
    that lie between columns are not seen.

    Accuracy: `bar` covers the error in 95 of 100 cases of random overlapping bodies.
    """
    signed = integrate(MemoryTriangles("bodies", mesh.corners))
    too_often = _excess(mesh.corners - signed.reference)
    if np.abs(too_often[:, 3, 3]).max() <= _TOUCH * abs(signed.volume):
        return None
    totals = _moments(signed) - too_often
    return _quadrature(totals.mean(axis=0), _spread(totals), signed.reference, "columns")


def as_given(mesh: Indexed) -> Quadrature:
    """Moments of the region where the winding number of a closed surface is positive, or if turned inside out."""
    if mesh.volume(mesh.middle) < 0:
        mesh = replace(mesh, faces=mesh.faces[:, ::-1])
    signed = integrate(MemoryTriangles("bodies", mesh.corners))
    return by_columns(mesh) or _quadrature(_moments(signed), np.zeros((4, 4)), signed.reference, "columns")


def by_winding_numbers(mesh: Indexed, caps: Numbers) -> Quadrature | None:
    """Moments of the region where the winding number of an open surface is above 1/2; None if that is not definite.

    With caps (n, 3) on its gaps the surface is closed, its winding number a whole number that columns count, and what
    it encloses done as in `by_columns`. How the region differs from that is seen by the winding number of the caps,
    which is taken off (Jacobson 2013), along fewer columns. Where a gap is plane its cap is where the winding number is
    1/2, and there is no difference.

    How definite the region is shows in those above 1/3 and above 2/3, between which a surface that goes on across a
    round gap as it does around it lies.

    Accuracy: `bar` covers the error of spheres, tori and cylinders without up to a twelfth of their surface.
    """
    signed = integrate(MemoryTriangles("body", mesh.corners_with(caps)))
    mesh = replace(mesh, vertices=mesh.vertices - signed.reference)
    closed, closing = mesh.corners_with(caps), replace(mesh, faces=caps)
    closed_region = _moments(signed) - _excess(closed)
    by_level = []
    for direction in directions():
        beyond = _beyond_caps(closed, closing, direction)
        if beyond is None:
            return None
        by_level.append(beyond)
    totals, wide, narrow = (closed_region[:, None] + np.array(by_level)).swapaxes(0, 1)
    region = totals.mean(axis=0)
    if region[3, 3] <= 0:
        return None
    apart = np.abs(centred(np.array([wide, narrow]).mean(axis=1) - region, region))
    error = _BRACKET * apart.max(axis=0) + _spread(totals) + signed.bound * np.abs(centred(region, region))
    if error[3, 3] > LARGEST_BAR * region[3, 3]:
        return None
    return _quadrature(region, error, signed.reference, "winding numbers")


def _beyond_caps(closed: Floats, caps: Indexed, direction: Floats) -> list[Floats] | None:
    """(4, 4) of each level, what has a larger winding number without caps, less what has a positive one with them.

    Parts of columns between hits are cut into cells, each of which is judged by the winding number in its middle.
    """
    count = _MOST
    while True:
        lattice = Lattice.over(closed, direction, count=count)
        cells = _cut(pieces(_with_margins(lattice.hits(closed))), lattice.step)
        cost = len(cells.start) * len(caps.faces) / _ANGLES
        if cost <= 1 or (count == _FEWEST and cost <= _TOO_MANY):
            break
        if count == _FEWEST:
            return None
        count = max(min(int(count / cost**0.7), count // 2), _FEWEST)
    middles = np.stack([*lattice.places(cells.column), (cells.start + cells.stop) / 2], axis=1)
    without = cells.weight - winding_numbers(product(middles, lattice.frame), caps)
    inside = (cells.weight > 0).astype(np.float64)
    return [cells._replace(weight=(without > level) - inside).moments(lattice) for level in _LEVELS]


def _with_margins(hits: Hits) -> Hits:
    """Return hits of columns with ends before and after them."""
    columns = np.unique(hits.column)
    lo, hi = hits.depth.min(initial=0.0), hits.depth.max(initial=0.0)
    ends = np.repeat([lo - (hi - lo) / 8, hi + (hi - lo) / 8], len(columns))
    none = np.zeros(len(ends), hits.sign.dtype)
    return Hits(*(np.concatenate(each) for each in zip(hits, (np.tile(columns, 2), ends, none), strict=True)))


def _cut(found: Pieces, step: float) -> Pieces:
    """Return the pieces cut into parts of equal length, none longer than the step."""
    many = np.maximum(np.ceil((found.stop - found.start) / step), 1).astype(np.int64)
    whole = Pieces._make(np.repeat(column, many) for column in found)
    place = np.arange(many.sum()) - np.repeat(np.cumsum(many) - many, many)
    part = (whole.stop - whole.start) / np.repeat(many, many)
    return whole._replace(start=whole.start + place * part, stop=whole.start + (place + 1) * part)


class Pieces(NamedTuple):
    """Parts of columns, each between two depths and with a weight."""

    column: Integers
    start: Floats
    stop: Floats
    weight: Floats

    def of(self, chosen: Mask) -> Pieces:
        """Return some of them."""
        return Pieces._make(column[chosen] for column in self)

    def moments(self, lattice: Lattice) -> Floats:
        """(4, 4) integral of y y^T times the weight, y = (x, 1); exact in depth, a sum over the columns across."""
        length = self.stop - self.start
        share = lattice.cell * self.weight * length
        Y = np.stack([*lattice.places(self.column), (self.start + self.stop) / 2, np.ones(len(length))])
        found: Floats = product(Y * share, Y.T)
        found[2, 2] += float(product(share, length**2)) / 12
        frame = np.eye(4)
        frame[:3, :3] = lattice.frame
        turned: Floats = product(frame.T, found, frame)
        return turned


def pieces(hits: Hits) -> Pieces:
    """Return what lies between the first and the last hit of each column, weighted with its winding number."""
    order = in_order(hits.column, hits.depth)
    column, depth = hits.column[order], hits.depth[order]
    within = column[1:] == column[:-1]
    winding = np.cumsum(hits.sign[order])[:-1][within]
    return Pieces(column[:-1][within], depth[:-1][within], depth[1:][within], winding.astype(np.float64))


def directions() -> list[Floats]:
    """Three unit vectors."""
    return [direction / length(direction) for direction in _DIRECTIONS]


def _excess(corners: Floats) -> Floats:
    """(3, 4, 4) in each direction, the moments of what a closed surface counts too often."""
    found = []
    for direction in directions():
        lattice = _lattice(corners, direction)
        every = pieces(lattice.hits(corners))
        wrong = every.of((every.weight != 0) & (every.weight != 1))
        found.append(wrong._replace(weight=wrong.weight - (wrong.weight > 0)).moments(lattice))
    return np.array(found)


def _lattice(corners: Floats, direction: Floats) -> Lattice:
    """Return COLUMNS columns, or as many as meet the triangles (m, 3, 3) not too often."""
    a, b, c = corners.transpose(1, 0, 2)
    shadows = float(np.abs(product(np.cross(b - a, c - a), direction)).sum()) / 2
    lattice = Lattice.over(corners, direction, count=COLUMNS)
    most = int(COLUMNS * lattice.cell * _HITS / shadows) if shadows else COLUMNS
    return lattice if most >= COLUMNS else Lattice.over(corners, direction, count=max(most, 1))


def _moments(signed: Integrals) -> Floats:
    """(4, 4) integral of y y^T with y = (x - reference, 1)."""
    return np.block([[signed.S, signed.first[:, None]], [signed.first, np.array(signed.volume)]])


def centred(totals: Floats, region: Floats) -> Floats:
    """Integrals (..., 4, 4) of y y^T, y = (x, 1), with x from the centre of a region that has such integrals (4, 4)."""
    shift = np.eye(4)
    shift[:3, 3] = -region[:3, 3] / region[3, 3]
    about: Floats = product(shift, totals, shift.T)
    return about


def _spread(totals: Floats) -> Floats:
    """(4, 4) by how much directions differ, about the centre."""
    spread: Floats = np.ptp(centred(totals, totals.mean(axis=0)), axis=0)
    return spread


def _quadrature(total: Floats, error: Floats, reference: Floats, method: str) -> Quadrature:
    """The bar is the larger of the relative error of the volume, and that of the largest of the second moments."""
    S, S_c = (total[:3, :3] + total[:3, :3].T) / 2, centred(total, total)[:3, :3]
    bar = max(float(error[3, 3] / total[3, 3]), float(error[:3, :3].max() / np.abs(S_c).max()))
    return Quadrature(float(total[3, 3]), total[:3, 3], S, reference, bar, method)
