"""The search for mirror planes and axes of symmetry: candidates by moments, verdicts by volumes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, pi
from typing import TypeVar

import numpy as np

from robodyn.programs.linear import eigen
from robodyn.programs.vectors import Array, length, product, rotation_about
from robodyn.solids.inertia.principal import pointed
from robodyn.solids.mesh.region.columns import frame_along
from robodyn.solids.mesh.symmetry import candidates
from robodyn.solids.mesh.symmetry.asymmetry import CentredBody, mirror
from robodyn.solids.mesh.symmetry.higher_moments import FREQUENCIES, EvenForm, axial_moments
from robodyn.solids.mesh.symmetry.kinds import NEAR, Axis, Plane, Verdict, verdict_of
from robodyn.support.floats import Floats, ranked

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

    @classmethod
    def of(cls, body: CentredBody, tolerance: float) -> Search:
        return cls(body, tolerance, *eigen(body.S))

    def axes(self) -> tuple[Axis, ...]:
        """Axes that are at least near, the most symmetric first."""
        found = list(self._ball)
        for i, direction in enumerate(self.principal):
            if i in self.lone:
                along = self._axial(direction, *self._about[i])
                found += along + self._half_turns(i, along)
            elif self._distinct(i) and self._half_turn_possible(i):
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
        return tuple(i for i in range(3) if self._equal(i - 1, i - 2, candidates.CLOSE) and self._distinct(i))

    @cached_property
    def special(self) -> Floats:
        """Directions that even moments single out where the second are all equal; none of a ball."""
        if self._ball or not self._all_equal:
            return np.empty((0, 3))
        forms = (EvenForm.of(self.body.corners, degree) for degree in (4, 6))
        return candidates.distinct_lines(np.concatenate([candidates.critical_directions(form) for form in forms]))

    @cached_property
    def _all_equal(self) -> bool:
        return all(self._equal(i, i - 1, candidates.CLOSE) for i in range(3))

    @cached_property
    def _ball(self) -> tuple[Axis, ...]:
        """Two axes of revolution: all are."""
        if not self._all_equal:
            return ()
        two = [axis for row in self.principal[:2] for axis in self._first(row, (inf,)) if axis.holds]
        return tuple(two) if len(two) == 2 else ()

    @cached_property
    def _always(self) -> dict[int, Plane]:
        """The planes normal to distinct principal axes."""
        return {i: self._plane(row) for i, row in enumerate(self.principal) if self._distinct(i)}

    def _half_turn_possible(self, i: int) -> bool:
        """Return whether a half turn may be near: of two reflections, it is no less than the difference of theirs."""
        planes = [self._always[j % 3] for j in (i + 1, i + 2) if j % 3 in self._always]
        return len(planes) < 2 or abs(planes[0].asymmetry - planes[1].asymmetry) <= NEAR

    def _equal(self, i: int, j: int, within: float) -> bool:
        one, other = self.second[i], self.second[j]
        return bool(abs(one - other) <= within * max(one, other))

    def _distinct(self, i: int) -> bool:
        return not any(self._equal(i, i - k, candidates.DISTINCT) for k in (1, 2))

    def _promising(self, Q: Array) -> bool:
        return self.body.least(Q) <= NEAR

    def _axial(self, direction: Array, frame: Floats, axial: Array) -> list[Axis]:
        """Revolution, and the highest finite fold that is not the same but for facets."""
        folds = candidates.folds(axial)
        revolved = self._first(direction, (inf,)) if inf in folds and not self._ball else []
        if inf in folds:
            folds += candidates.rim_folds(len(candidates.rim_angles(self._points, frame)))
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
        angles = candidates.half_turn_angles(axial) + self._rim_angles(i, along)
        across = np.array([frame[0] * np.cos(a) + frame[1] * np.sin(a) for a in angles]).reshape(-1, 3)
        return [axis for direction in candidates.distinct_lines(across) for axis in self._first(direction, (2.0,))]

    def _rim_angles(self, i: int, axes: Iterable[Axis]) -> list[float]:
        """Angles of half planes and directions that swap points of the rim, where moments do not tell."""
        frame, axial = self._about[i]
        if inf not in candidates.folds(axial):
            return []
        rim = candidates.rim_angles(self._points, frame)
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
            angles = candidates.mirror_angles(axial) + self._rim_angles(i, axes)
            normals.append(np.array([frame[1] * np.cos(a) - frame[0] * np.sin(a) for a in angles]).reshape(-1, 3))
        if not any(map(len, normals)) and len(self.lone) == 0 and not self._distinct(0):
            normals.append(candidates.swapping_normals(self._points))
        return candidates.distinct_lines(np.concatenate(normals))

    @cached_property
    def _about(self) -> dict[int, tuple[Floats, Array]]:
        """Of each lone axis, a frame along it and the moments about it."""
        frames = {i: frame_along(self.principal[i]) for i in self.lone}
        return {i: (frame, axial_moments(self.body.corners, frame, self.body.volume)) for i, frame in frames.items()}

    @cached_property
    def _points(self) -> Array:
        return self.body.corners.reshape(-1, 3)

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
        facets = self.body.facets if self.tolerance < asymmetry <= NEAR else 0.0
        return verdict_of(asymmetry, self.tolerance, facets)


def _once(found: Sequence[Found], line: Callable[[Found], tuple[float, Array]]) -> tuple[Found, ...]:
    """Return the most symmetric first, without those that are nearly parallel to an earlier one of the same fold.

    What is exact is so to rounding, which is another on each processor.
    """
    kept: list[Found] = []
    for each in ranked(found, lambda each: 0.0 if each.verdict == "exact" else -each.asymmetry):
        fold, direction = line(each)
        same = [other for its, other in map(line, kept) if its == fold]
        if not any(_parallel(direction, other, _APART if each.verdict == "exact" else _BLUR) for other in same):
            kept.append(each)
    return tuple(kept)


def _in_order(found: Iterable[Found], direction: Callable[[Found], Array]) -> list[Found]:
    """By coordinates, however they were found."""
    ordered = list(found)
    for k in (2, 1, 0):
        ordered = ranked(ordered, lambda each, k=k: float(direction(each)[k]), noise=_SAME_COORDINATE)  # type: ignore[misc]
    return ordered


def _parallel(one: Array, other: Array, within: float = _APART) -> bool:
    return bool(min(length(one - other), length(one + other)) <= within)
