"""Where a body may have planes and axes of symmetry, by its moments, and the verdicts on them, by volumes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import atan2, gcd, inf, pi
from typing import Literal, TypeVar

import numpy as np

from robodyn.programs.vectors import Array, length, product, rotation_about
from robodyn.solids.inertia.properties import pointed
from robodyn.solids.mesh.asymmetry import FREQUENCIES, CentredBody, axial_moments, mirror, sixth_moments
from robodyn.solids.mesh.columns import frame_along
from robodyn.support.floats import Floats, einsum, first_largest, ranked

Verdict = Literal["exact", "within tessellation", "near", "none"]

NEAR = 1e-2
"""Asymmetries above this are none, whatever the facets: coarse ones could excuse anything."""


class _Judged:
    asymmetry: float
    verdict: Verdict

    @property
    def holds(self) -> bool:
        return self.verdict in ("exact", "within tessellation")


@dataclass(frozen=True, eq=False)
class Plane(_Judged):
    """A candidate for a mirror plane, n . x = offset; normal (3,) of length 1, offset in units of the file."""

    normal: Floats
    offset: float
    asymmetry: float
    verdict: Verdict


@dataclass(frozen=True, eq=False)
class Axis(_Judged):
    """A candidate for an axis of symmetry; fold n for rotations by 1 / n of a turn, infinite for revolution."""

    direction: Floats
    point: Floats
    fold: float
    asymmetry: float
    verdict: Verdict


@dataclass(frozen=True)
class Product:
    """A product of inertia about the centre, in the axes of the file: "xy", "xz" or "yz".

    residual: the computed integral of x_i x_j dV; relative: the same over the root of the two second moments; zero: it
    is 0 by symmetry.
    """

    axes: str
    residual: float
    relative: float
    zero: bool


@dataclass(frozen=True, eq=False)
class Symmetry:
    """What was found, the most symmetric first, the products xy, xz, yz, and an orthonormal basis (k, 3, 3) of the
    second moments that the planes and axes that hold leave possible."""

    planes: tuple[Plane, ...]
    axes: tuple[Axis, ...]
    products: tuple[Product, ...]
    invariants: Floats

    @property
    def accepted(self) -> tuple[int, int]:
        """How many planes and axes hold."""
        return sum(plane.holds for plane in self.planes), sum(axis.holds for axis in self.axes)

    def scaled(self, scale: float) -> Symmetry:
        """Return the same in another unit, of which there are so many in the present one."""
        return replace(
            self,
            planes=tuple(replace(plane, offset=plane.offset * scale) for plane in self.planes),
            axes=tuple(replace(axis, point=axis.point * scale) for axis in self.axes),
            products=tuple(replace(product, residual=product.residual * scale**5) for product in self.products),
        )


DISTINCT = 1e-9
"""Principal second moments that are closer than this part of the largest leave their axes open."""
CLOSE = 0.1
"""Those that are closer than this part may be equal but for facets, or but for an asymmetry that is near."""
_LEVELS = (1e-10, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2, 3e-2)
_STARTS, _STEPS = 256, 24
_STEEP = 1e-6
_RIM = 1e-6
_MOST = 64


def possible_folds(axial: Array) -> list[float]:
    """Folds that an axis may have, the largest first, infinite for revolution. An axis of fold n leaves only the
    moments whose frequency is a multiple of n: n is the greatest common divisor of the frequencies of those above a
    level of noise, for several levels."""
    size = np.abs(axial).max(axis=1)
    found = {gcd(*(int(m) + 1 for m in np.flatnonzero(size > level))) or inf for level in _LEVELS}
    return sorted(found - {1}, reverse=True)


def _strongest(axial: Array) -> tuple[int, float, int]:
    """Frequency, phase and power of z of the largest moment; frequency 0 of none."""
    size = np.abs(axial)
    m, k = (int(place) for place in np.unravel_index(first_largest(size), size.shape))
    found = complex(axial[m, k])
    return (m + 1, atan2(found.imag, found.real), k) if size[m, k] > _LEVELS[0] else (0, 0.0, 0)


def rim_angles(points: Array, frame: Array) -> Floats:
    """The angles about the last row of a frame, ascending, of the points (n, 3) farthest from it."""
    x, y = einsum("ij,nj->in", frame[:2], points)
    radius = np.hypot(x, y)
    outer = radius >= radius.max() * (1 - _RIM)
    angles = np.sort([atan2(b, a) for a, b in zip(x[outer].tolist(), y[outer].tolist(), strict=True)])
    found: Floats = angles[np.diff(angles, append=angles[0] + 2 * np.pi) > 2 * np.pi * _RIM]
    return found


def critical_directions(M: Array) -> Floats:
    """(n, 3) isolated critical points, one of each opposite pair, of a symmetric form M n ... n among unit vectors n.

    Every normal of a mirror plane and every axis is one, wherever the form tells directions apart: one of degree 4 for
    the symmetry of a cube, one of degree 6 for that of an icosahedron. Newton's method from many directions.
    """
    index = np.arange(_STARTS) + 0.5
    z, turn = index / _STARTS, np.pi * (1 + 5**0.5) * index
    r = np.sqrt(1 - z * z)
    n = np.concatenate([np.eye(3), np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)])
    for _ in range(_STEPS):
        step, _ = _newton(M, n)
        size = np.linalg.norm(step, axis=1, keepdims=True)
        n = n + step * np.minimum(1.0, 0.3 / np.maximum(size, 1e-300))
        n = n / np.linalg.norm(n, axis=1, keepdims=True)
    step, steep = _newton(M, n)
    return distinct_lines(n[(np.linalg.norm(step, axis=1) < 1e-9) & (steep > _STEEP * np.abs(M).max())])


def distinct_lines(directions: Array) -> Floats:
    """(n, 3) each direction once, whatever its sign, within 1e-6."""
    kept: list[Array] = []
    for direction in directions:
        if all(length(np.cross(direction, other)) > 1e-6 for other in kept):
            kept.append(direction)
    return np.array(kept).reshape(-1, 3)


def swapping_normals(points: Array) -> Floats:
    """(n, 3) normals of the planes through the origin that swap one of the farthest points (n, 3) with the others."""
    radius = np.linalg.norm(points, axis=1)
    far = points[radius >= radius.max() * (1 - _RIM)]
    between = far[0] - far
    length = np.linalg.norm(between, axis=1)
    apart = length > _RIM * radius.max()
    return distinct_lines((between[apart] / length[apart, None])[:_MOST])


def _newton(M: Array, n: Array) -> tuple[Array, Array]:
    """Newton's steps (n, 3) in the tangent planes, and the least absolute curvature (n,) there."""
    rest = M.reshape(1, -1) * (M.ndim * (M.ndim - 1))
    for _ in range(M.ndim - 2):
        rest = (n[:, :, None] * rest.reshape(len(rest), 3, -1)).sum(axis=1)
    hessian = rest.reshape(-1, 3, 3)
    gradient = einsum("nij,nj->ni", hessian, n) / (M.ndim - 1)
    slope = einsum("ni,ni->n", gradient, n)
    across = np.cross(n, np.eye(3)[np.argmin(np.abs(n), axis=1)])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    tangent = np.stack((across, np.cross(n, across)), axis=2)
    curvature = product(tangent.transpose(0, 2, 1), hessian - slope[:, None, None] * np.eye(3), tangent)
    values, turned = np.linalg.eigh(curvature)
    axes, size = product(tangent, turned), np.abs(curvature).max() + 1e-300
    safe = np.where(np.abs(values) > 1e-14 * size, values, size)
    step = -einsum("nij,nj->ni", axes, einsum("nij,ni->nj", axes, gradient) / safe)
    return step, np.abs(values).min(axis=1)


Found = TypeVar("Found", bound=Plane | Axis)

DECIMALS = 12
"""Of asymmetries: what is smaller is rounding, and another one on each processor."""
_APART = 1e-3
"""Angle between planes that are told apart."""
_BLUR = 0.05
"""That between what is not exact and something more symmetric, which it may be taken for."""
_SAME_COORDINATE = 1e-9
_ASKEW = 1e-4
"""A normal that is closer to a coordinate axis is tried along it: facets and rounding turn it by less."""
_SOLID_FOLDS = (5.0, 4.0, 3.0, 2.0)
"""Of the axes of the regular bodies."""


@dataclass(frozen=True, eq=False)
class Search:
    """A body, its principal second moments, descending, and their axes as rows."""

    body: CentredBody
    tolerance: float
    second: Floats
    principal: Floats

    def axes(self) -> tuple[Axis, ...]:
        """Axes that are at least near, the most symmetric first."""
        found = list(self._ball)
        for i, direction in enumerate(self.principal):
            if i in self.lone:
                along = self._axial(direction, *self._about[i])
                found += along + self._half_turns(i, along)
            elif self._distinct(i):
                planes = [self._always[j % 3] for j in (i + 1, i + 2) if j % 3 in self._always]
                # a half turn, as two reflections, is off by no less than the difference of theirs
                if len(planes) < 2 or abs(planes[0].asymmetry - planes[1].asymmetry) <= NEAR:
                    found += self._first(direction, (2.0,))
        for direction in self.special:
            if not any(_parallel(direction, axis.direction) for axis in found):
                found += self._first(direction, _SOLID_FOLDS)
        if len(self.special):
            for axis in tuple(found):
                others = [other.direction for other in found if other.fold == axis.fold]
                for direction in self._images(axis.direction, found, others):
                    found += self._first(direction, (axis.fold,))
        found = ranked(_in_order(found, lambda axis: axis.direction), lambda axis: axis.fold)
        return _once(found, lambda axis: (axis.fold, axis.direction))

    def planes(self, axes: Iterable[Axis]) -> tuple[Plane, ...]:
        """Planes normal to distinct principal axes, and all others that are at least near; the most symmetric first."""
        axes = tuple(axes)
        others = [self._plane(normal) for normal in self._wanted_normals(axes)]
        if len(self.special):
            near = [plane.normal for plane in others if plane.verdict != "none"]
            for normal in tuple(near):
                others += [self._plane(image) for image in self._images(normal, axes, near)]
        others = _in_order((plane for plane in others if plane.verdict != "none"), lambda plane: plane.normal)
        return _once([*self._always.values(), *others], lambda plane: (1.0, plane.normal))

    @cached_property
    def lone(self) -> tuple[int, ...]:
        """The principal axes whose two transverse moments are equal but for facets."""
        return tuple(i for i in range(3) if self._equal(i - 1, i - 2, CLOSE) and self._distinct(i))

    @cached_property
    def special(self) -> Floats:
        """Directions that even moments single out where the second are all equal; none of a ball."""
        if self._ball or not self._all_equal:
            return np.empty((0, 3))
        forms = self.body.moments.tensors[2], sixth_moments(self.body.corners)
        return distinct_lines(np.concatenate([critical_directions(form) for form in forms]))

    @cached_property
    def _all_equal(self) -> bool:
        return all(self._equal(i, i - 1, CLOSE) for i in range(3))

    @cached_property
    def _ball(self) -> tuple[Axis, ...]:
        """Two axes of revolution: all are."""
        if not self._all_equal:
            return ()
        two = [axis for row in self.principal[:2] for axis in self._first(row, (inf,)) if axis.holds]
        return tuple(two) if len(two) == 2 else ()

    @cached_property
    def _always(self) -> dict[int, Plane]:
        return {i: self._plane(row) for i, row in enumerate(self.principal) if self._distinct(i)}

    def _equal(self, i: int, j: int, within: float) -> bool:
        one, other = self.second[i], self.second[j]
        return bool(abs(one - other) <= within * max(one, other))

    def _distinct(self, i: int) -> bool:
        return not any(self._equal(i, i - k, DISTINCT) for k in (1, 2))

    def _promising(self, Q: Array) -> bool:
        return self.body.moments.least_asymmetry(Q) <= NEAR

    def _axial(self, direction: Array, frame: Floats, axial: Array) -> list[Axis]:
        """Revolution, and the highest finite fold that is not the same but for facets."""
        folds = possible_folds(axial)
        revolved = self._first(direction, (inf,)) if inf in folds and not self._ball else []
        if inf in folds:
            count = len(rim_angles(self.body.corners.reshape(-1, 3), frame))
            folds += [float(n) for n in range(count, 1, -1) if count % n == 0][:4]
        finite = self._first(direction, sorted({fold for fold in folds if fold < inf}, reverse=True))
        implied = self._ball or any(axis.holds for axis in revolved)
        return revolved + [axis for axis in finite if axis.verdict == "exact" or not implied]

    def _images(self, direction: Array, axes: Sequence[Axis], known: list[Array]) -> list[Array]:
        """Return where turns of a regular body carry a direction, but for the known ones; they are known then."""
        found: list[Array] = []
        if not all(axis.fold in _SOLID_FOLDS for axis in axes):
            return found
        for axis in axes:
            image = product(rotation_about(axis.direction, 2 * pi / axis.fold), direction)
            if not any(_parallel(image, other, _BLUR) for other in known):
                known.append(image)
                found.append(image)
        return found

    def _half_turns(self, i: int, along: Iterable[Axis]) -> list[Axis]:
        """The twofold axes normal to a lone one; of an axis of revolution, where all are or none, nothing is said."""
        if self._ball or any(axis.fold == inf and axis.holds for axis in along):
            return []
        frame, axial = self._about[i]
        # seen from the axis of a half turn moments with an even power of z are real, those with an odd one imaginary
        frequency, phase, power = _strongest(axial)
        angles = [(phase + np.pi * (j - power / 2)) / frequency for j in range(frequency)]
        angles += self._rim_angles(i, along)
        across = np.array([frame[0] * np.cos(a) + frame[1] * np.sin(a) for a in angles]).reshape(-1, 3)
        return [axis for direction in distinct_lines(across) for axis in self._first(direction, (2.0,))]

    def _rim_angles(self, i: int, axes: Iterable[Axis]) -> list[float]:
        """Angles of half planes and directions that swap points of the rim, where moments do not tell."""
        frame, axial = self._about[i]
        if inf not in possible_folds(axial):
            return []
        rim = rim_angles(self.body.corners.reshape(-1, 3), frame)
        folds = [axis.fold for axis in axes if axis.holds and FREQUENCIES < axis.fold < inf]
        period = len(rim) // int(max(folds)) if folds else 4 * FREQUENCIES
        return [(rim[0] + angle) / 2 for angle in rim[: period + 1]]

    def _first(self, direction: Array, folds: Iterable[float]) -> list[Axis]:
        """The axis of the first of these folds that holds, else the one that is nearest to it, if any is near."""
        direction, near = pointed(direction), list[Axis]()
        for fold in folds:
            if fold < inf and not self._promising(rotation_about(direction, 2 * pi / fold)):
                continue
            apart = self.body.revolved(direction) if fold == inf else self.body.turned(direction, 2 * pi / fold)
            asymmetry = round(apart, DECIMALS)
            axis = Axis(direction, self.body.centre, fold, asymmetry, self._verdict(asymmetry))
            if axis.holds:
                return [axis]
            near += [axis] if axis.verdict == "near" else []
        return ranked(near, lambda axis: -axis.asymmetry)[:1]

    def _wanted_normals(self, axes: tuple[Axis, ...]) -> list[Floats]:
        """Further normals; of planes that an axis of revolution implies those with the same triangles, or else two."""
        found = [normal for normal in self._further_normals(axes) if self._promising(mirror(normal))]
        directions = [axis.direction for axis in axes if axis.fold == inf and axis.holds]
        for direction in directions:
            implied = [normal for normal in found if self._ball or abs(product(normal, direction)) <= _APART]
            others = [normal for normal in found if not (self._ball or abs(product(normal, direction)) <= _APART)]
            exact = [normal for normal in implied if self.body.same(mirror(normal))]
            found = others + (exact or [row for row in self.principal if abs(product(row, direction)) <= _APART])
        return found

    def _further_normals(self, axes: Iterable[Axis]) -> Floats:
        """Normals of planes through lone axes, special ones, and of what even fourth moments do not show."""
        normals = [self.special]
        for i in self.lone:
            frame, axial = self._about[i]
            frequency, phase, _ = _strongest(axial)  # seen from a plane all moments are real
            angles = [(phase + np.pi * j) / frequency for j in range(frequency)] + self._rim_angles(i, axes)
            normals.append(np.array([frame[1] * np.cos(a) - frame[0] * np.sin(a) for a in angles]).reshape(-1, 3))
        if not any(map(len, normals)) and len(self.lone) == 0 and not self._distinct(0):
            normals.append(swapping_normals(self.body.corners.reshape(-1, 3)))
        return distinct_lines(np.concatenate(normals))

    @cached_property
    def _about(self) -> dict[int, tuple[Floats, Array]]:
        frames = {i: frame_along(self.principal[i]) for i in self.lone}
        return {i: (frame, axial_moments(self.body.corners, frame, self.body.volume)) for i, frame in frames.items()}

    def _plane(self, normal: Array) -> Plane:
        nearest = np.eye(3)[np.argmax(np.abs(normal))]
        if 0 < length(np.cross(normal, nearest)) <= _ASKEW:
            along = self._plane(nearest)
            if along.holds:
                return along
        normal = pointed(normal)
        asymmetry = round(self.body.mirrored(normal), DECIMALS)
        return Plane(normal, float(product(normal, self.body.centre)), asymmetry, self._verdict(asymmetry))

    def _verdict(self, asymmetry: float) -> Verdict:
        if asymmetry <= self.tolerance:
            return "exact"
        if asymmetry > NEAR:
            return "none"
        return "within tessellation" if asymmetry <= 2 * self.body.facets else "near"


def _once(found: Sequence[Found], line: Callable[[Found], tuple[float, Array]]) -> tuple[Found, ...]:
    """Return the most symmetric first, without those that are nearly parallel to an earlier one of the same fold."""
    kept: list[Found] = []
    for each in ranked(found, lambda each: 0.0 if each.verdict == "exact" else -each.asymmetry):
        fold, direction = line(each)
        same = [other for its, other in map(line, kept) if its == fold]
        if not any(_parallel(direction, other, _APART if each.verdict == "exact" else _BLUR) for other in same):
            kept.append(each)
    return tuple(kept)


def _in_order(found: Iterable[Found], direction: Callable[[Found], Array]) -> list[Found]:
    ordered = list(found)
    for k in (2, 1, 0):
        ordered = ranked(ordered, lambda each, k=k: float(direction(each)[k]), noise=_SAME_COORDINATE)  # type: ignore[misc]
    return ordered


def _parallel(one: Array, other: Array, within: float = _APART) -> bool:
    return bool(min(length(one - other), length(one + other)) <= within)
