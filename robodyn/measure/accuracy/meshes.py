"""What the digits of a mesh's volume and inertia cost, and what proof costs; inertia as accurate as asked."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import isfinite, sqrt

import numpy as np

from robodyn.errors import InputError, MeshError
from robodyn.measure.accuracy.ladder import ROUNDING, Accuracy, Ladder, Price, Rung, refuse_beyond_doubles, timed
from robodyn.measure.accuracy.mesh_methods import (
    by_box,
    by_chance,
    by_columns,
    by_decimation,
    by_hull,
    by_triangles,
    by_voxels,
    by_winding_numbers,
    counted,
    inertia,
    integral_operations,
    union_with_a_copy,
)
from robodyn.solids.inertia.laws import exact, fraction
from robodyn.solids.mass_properties import Part
from robodyn.solids.mesh.asymmetry import CentredBody
from robodyn.solids.mesh.closed import fingerprint, is_one_shell
from robodyn.solids.mesh.integrals import LIMIT, Integrals, Moments, integrate
from robodyn.solids.mesh.measured import SYMMETRY_TRIANGLES, measured
from robodyn.solids.mesh.repair import repair
from robodyn.solids.mesh.symmetry import symmetry
from robodyn.solids.mesh.tessellation import tessellation
from robodyn.solids.mesh.triangles import MemoryTriangles, Triangles
from robodyn.support.floats import Floats

COLUMNS = 256, 4096, 65536
VOXELS = 256, 4096
POINTS = 100, 1000, 10000
TOLERANCES = 3e-2, 3e-3
"""Of decimated surfaces, shares of the diagonal of the box."""
MOST_TESTS = 20_000_000
"""Of random points against triangles: a second or two."""
MEASURES = "volume", "inertia"

Act = Callable[[], Moments]


def mesh_accuracy(triangles: Triangles) -> Accuracy:
    """Return errors of volume and inertia by every method against the integral in exact rationals, and their times.

    The error of the inertia is that of the matrix about the centre of mass, in the Frobenius norm.

    Raises:
        MeshError: the surface encloses no definite volume, or overlaps itself, so that there is no exact reference.

    Accuracy: of errors, 1e-15 of themselves; those of exact rationals are 2^-53 or less.
    """
    try:
        found = measured(triangles, exact=True)
    except MeshError as error:
        elsewhere = error.remedy and error.remedy.startswith("--")
        remedy = f"robodyn inertia: {error.remedy}" if elsewhere else error.remedy
        raise MeshError(error.what, remedy=remedy, file=error.file) from None
    if not found.defined:
        raise MeshError(
            "what the surface encloses is not the sum over its triangles: there is no exact reference",
            remedy="robodyn inertia gives it with an error bar",
            file=triangles.name,
        )
    whole = found.integrals
    corners = np.ascontiguousarray(found.triangles.array() - whole.reference)
    crude, notes = _crude(corners)
    notes += triangles.warnings
    surface = MemoryTriangles(triangles.name, found.triangles.array())
    acts, counts = _acts(surface, whole, corners, crude)
    rungs = []
    for name, (moments, time) in timed(acts).items():
        errors = _errors(moments, whole)
        if all(map(isfinite, errors)):
            rungs.append(Rung(name, errors, time, counts.get(name)))
        else:
            notes.append(f"{name}: finds no volume")
    ladder = Ladder("volume and inertia", MEASURES, "exact rationals", "mesh", tuple(rungs))
    return Accuracy(triangles.name, (ladder,), _prices(triangles, surface, whole, corners), notes=tuple(notes))


def _crude(corners: Floats) -> tuple[dict[str, Callable[[Floats], Moments]], list[str]]:
    """Methods on an array of corners, and why some are missing."""
    ways: dict[str, Callable[[Floats], Moments]] = {"bounding box": by_box, "convex hull": by_hull}
    notes = []
    for count in VOXELS:
        ways[f"voxels on {count} columns"] = partial(by_voxels, count=count)
    for count in COLUMNS:
        ways[f"{count} columns"] = partial(by_columns, count=count)
    for count in POINTS:
        if count * len(corners) <= MOST_TESTS:
            ways[f"Monte Carlo, {count} points"] = partial(by_chance, count=count)
            ways[f"winding numbers at {count} points"] = partial(by_winding_numbers, count=count)
        else:
            notes.append(f"{count} random points: left out, {count * len(corners):.0e} tests")
    try:
        for share in TOLERANCES:
            way = partial(by_decimation, tolerance=share)
            way(corners)
            ways[f"decimated within {100 * share:g} % of its size"] = way
    except MeshError as error:
        notes.append(f"decimated: left out, {error.what}")
    return ways, notes


def _acts(
    triangles: Triangles, whole: Integrals, corners: Floats, crude: dict[str, Callable[[Floats], Moments]]
) -> tuple[dict[str, Act], dict[str, float]]:
    """Methods ready to be called, and operations of those whose operations can be counted."""
    acts: dict[str, Act] = {name: partial(way, corners) for name, way in crude.items()}
    uncounted = by_hull, by_decimation, by_winding_numbers  # whose arithmetic is not all NumPy's
    counts: dict[str, float] = {
        name: counted(way, corners) for name, way in crude.items() if getattr(way, "func", way) not in uncounted
    }
    floats: dict[str, type] = {"float32": np.float32, "float64": np.float64}
    if np.finfo(np.longdouble).nmant > np.finfo(np.float64).nmant:
        floats["long double"] = np.longdouble
    for name, dtype in floats.items():
        acts[f"integral, {name}"] = partial(by_triangles, triangles, dtype, whole.reference)
        counts[f"integral, {name}"] = integral_operations(triangles.count)
    acts[f"integral, escalated to {integrate(triangles).method}"] = lambda: integrate(triangles).moments
    acts["integral, exact rationals"] = lambda: integrate(triangles, exact=True).moments
    return acts, counts


def _errors(moments: Moments, whole: Integrals) -> tuple[float, float]:
    """Relative errors of volume and inertia, rounded to floats; infinite where there is no volume."""
    expected = whole.moments
    try:
        volume, matrix = fraction(float(moments.volume)), exact(inertia(moments).astype(float))
    except (ZeroDivisionError, InputError):
        return np.inf, np.inf
    I = inertia(expected)
    off = float(abs((volume - expected.volume) / expected.volume))
    scale = max(abs(I).ravel())
    norms = (sqrt(sum(float(x) ** 2 for x in (part / scale).ravel())) for part in (matrix - I, I))
    return off, next(norms) / next(norms)


def _prices(given: Triangles, triangles: Triangles, whole: Integrals, corners: Floats) -> tuple[Price, ...]:
    """Of what makes the numbers trustworthy; the repair is that of the mesh as it was given."""

    def facets() -> object:
        body = CentredBody.of(triangles, whole)
        return tessellation(body.line_masses, whole, body.centre)

    acts: dict[str, Callable[[], object]] = {
        "proof that it is closed": partial(fingerprint, triangles),
        "proof that it is one shell": partial(is_one_shell, triangles),
        "repair ladder": partial(repair, given),
        "tessellation error": facets,
    }
    with suppress(MeshError):
        union_with_a_copy(corners)
        acts["union with a copy of it"] = partial(union_with_a_copy, corners)
    if triangles.count <= SYMMETRY_TRIANGLES:
        acts["symmetry"] = lambda: symmetry(CentredBody.of(triangles, whole))
    return tuple(Price(name, time) for name, (_, time) in timed(acts).items())


def needs_rationals(target: float) -> bool:
    """Whether floats, which are escalated until their bounds are below 1e-12, are not enough for a relative error.

    Raises:
        InputError: no result in doubles can be that accurate.
    """
    refuse_beyond_doubles(target)
    return target < LIMIT


def with_promise(part: Part, target: float) -> Part:
    """Return the part with a note that says by which arithmetic the target is met.

    Raises:
        MeshError: what the surface encloses is not known that well.

    Accuracy: bounds are proven for the triangles as given, whose own rounding is reported beside.
    """
    if part.union is not None and part.union > target:
        raise MeshError(
            f"an accuracy of {target:g} cannot be promised: what the surface encloses is known to {part.union:.0e}",
            remedy="mend overlaps and gaps, or ask for less",
            file=part.name,
        )
    rational = part.method == "rational"
    bound = f"{ROUNDING:.1e}" if rational else f"{LIMIT:.0e} (volume: {part.arithmetic:.0e})"
    name = "exact rationals" if rational else part.method
    data = f"; the rounding of the file can make {part.rounding:.0e} of it" if part.rounding > target else ""
    said = f"accuracy: {target:g} asked, proven within {bound} by {name}{data}"
    return replace(part, notes=(*part.notes, said))
