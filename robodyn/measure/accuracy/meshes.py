"""What the digits of a mesh's volume and inertia cost, and what proof costs; inertia as accurate as asked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import isfinite, sqrt
from typing import Any

import numpy as np

from robodyn.errors import InputError, MeshError
from robodyn.measure.accuracy.ladder import ROUNDING, Accuracy, Ladder, Price, Rung, refuse_beyond_doubles, timed
from robodyn.programs.vectors import Array, length, product
from robodyn.solids.inertia.laws import exact, fraction
from robodyn.solids.mass_properties import SYMMETRY_TRIANGLES, Part, measured
from robodyn.solids.mesh.asymmetry import CentredBody
from robodyn.solids.mesh.closed import fingerprint, is_one_shell
from robodyn.solids.mesh.columns import DIRECTIONS, Lattice, pieces
from robodyn.solids.mesh.indexed import merged
from robodyn.solids.mesh.inside import manifold, winding_numbers
from robodyn.solids.mesh.integrals import LIMIT, Integrals, Moments, integrate, swept
from robodyn.solids.mesh.kernel import symmetric, volume_kernel
from robodyn.solids.mesh.repair import repair
from robodyn.solids.mesh.symmetry import symmetry
from robodyn.solids.mesh.tessellation import tessellation
from robodyn.solids.mesh.triangles import MemoryTriangles, Triangles
from robodyn.support.floats import Floats

COLUMNS = 256, 4096, 65536
POINTS = 100, 1000, 10000
TOLERANCES = 3e-2, 3e-3  # of decimated surfaces, shares of the diagonal of the box
OPERATIONS = 112  # of the integral over a triangle, nine of them to take its corners to the point of reference
MOST_TESTS = 20_000_000  # of random points against triangles: a second or two


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
    surface = MemoryTriangles(triangles.name, found.triangles.array())
    acts, notes = _crude(corners)
    notes += triangles.warnings
    floats: dict[str, Any] = {
        f"integral, {name}": dtype for name, dtype in (("float32", np.float32), ("float64", np.float64))
    }
    if np.finfo(np.longdouble).nmant > np.finfo(np.float64).nmant:
        floats["integral, long double"] = np.longdouble
    acts |= {name: partial(by_triangles, surface, dtype, whole.reference) for name, dtype in floats.items()}
    acts[f"integral, escalated to {integrate(surface).method}"] = lambda: integrate(surface).moments
    acts["integral, exact rationals"] = lambda: integrate(surface, exact=True).moments
    rungs = []
    for name, (moments, time) in timed(acts).items():
        errors = _errors(moments, whole)
        if all(map(isfinite, errors)):
            rungs.append(Rung(name, errors, time, OPERATIONS * surface.count if name in floats else None))
        else:
            notes.append(f"{name}: finds no volume")
    ladder = Ladder("volume and inertia", ("volume", "inertia"), "exact rationals", "mesh", tuple(rungs))
    return Accuracy(triangles.name, (ladder,), _prices(triangles, surface, whole), notes=tuple(notes))


def _crude(corners: Floats) -> tuple[dict[str, Callable[[], Moments]], list[str]]:
    """Return methods on an array of corners, and why some are missing."""
    acts: dict[str, Callable[[], Moments]] = {
        "bounding box": partial(by_box, corners),
        "convex hull": partial(by_hull, corners),
    }
    acts |= {f"{count} columns": partial(by_columns, corners, count) for count in COLUMNS}
    notes = []
    for count in POINTS:
        if count * len(corners) <= MOST_TESTS:
            acts[f"winding numbers at {count} points"] = partial(by_winding_numbers, corners, count)
        else:
            notes.append(f"{count} random points: left out, {count * len(corners):.0e} tests")
    try:
        for share in TOLERANCES:
            way = partial(by_decimation, corners, share)
            way()
            acts[f"decimated within {100 * share:g} % of its size"] = way
    except MeshError as error:
        notes.append(f"decimated: left out, {error.what}")
    return acts, notes


def _errors(moments: Moments, whole: Integrals) -> tuple[float, float]:
    """Return relative errors of volume and inertia, rounded to floats; infinite where there is no volume."""
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


def _prices(given: Triangles, triangles: Triangles, whole: Integrals) -> tuple[Price, ...]:
    """Return times of what makes the numbers trustworthy; the repair is that of the mesh as it was given."""

    def facets() -> object:
        body = CentredBody.of(triangles, whole)
        return tessellation(body.line_masses, whole, body.centre)

    acts: dict[str, Callable[[], object]] = {
        "proof that it is closed": partial(fingerprint, triangles),
        "proof that it is one shell": partial(is_one_shell, triangles),
        "repair ladder": partial(repair, given),
        "tessellation error": facets,
    }
    if triangles.count <= SYMMETRY_TRIANGLES:
        acts["symmetry"] = lambda: symmetry(CentredBody.of(triangles, whole))
    return tuple(Price(name, time) for name, (_, time) in timed(acts).items())


def by_box(corners: Floats) -> Moments:
    """Of the box around the corners (m, 3, 3)."""
    lo, hi = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    size, middle = hi - lo, lo / 2 + hi / 2
    volume = size[0] * size[1] * size[2]
    return Moments(volume, volume * middle, volume * (np.outer(middle, middle) + np.diag(size * size / 12)))


def by_hull(corners: Floats) -> Moments:
    """Of the convex hull; raise scipy.spatial.QhullError if the corners lie in a plane."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(corners.reshape(-1, 3))
    faces = hull.points[hull.simplices]
    normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    inwards = (normals * hull.equations[:, :3]).sum(axis=1) < 0
    faces[inwards] = faces[inwards, ::-1]
    return _about_origin(faces)


def by_columns(corners: Floats, count: int) -> Moments:
    """By about so many columns along one direction, exact in depth."""
    lattice = Lattice.over(corners, DIRECTIONS[0], count=count)
    every = pieces(lattice.hits(corners))
    inside = every.of(every.weight > 0)
    return _of_matrix(inside._replace(weight=np.ones(len(inside.column))).moments(lattice))


def by_winding_numbers(corners: Floats, count: int) -> Moments:
    """By so many random points in the box; one counts where the surface goes around it, by its solid angle."""
    lo, hi = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    points = lo + (hi - lo) * np.random.default_rng(0).random((count, 3))
    inside = points[winding_numbers(points, merged(corners)) > 0.5]
    Y = np.concatenate([inside, np.ones((len(inside), 1))], axis=1)
    return _of_matrix(product(Y.T, Y) * (np.prod(hi - lo) / count))


def _of_matrix(matrix: Floats) -> Moments:
    """Of the integral (4, 4) of y y^T with y = (x, 1)."""
    return Moments(matrix[3, 3], matrix[:3, 3], matrix[:3, :3])


def by_decimation(corners: Floats, tolerance: float) -> Moments:
    """Of fewer triangles, none farther off than this share of the box's diagonal; raise MeshError if no manifold."""
    mesh = merged(corners)
    solid = manifold(mesh.vertices, mesh.faces)
    if solid is None or not hasattr(solid, "simplify"):
        raise MeshError("the surface is no manifold" if solid is None else "manifold3d is older than 3.1")
    few = solid.simplify(tolerance * length(np.ptp(corners, axis=(0, 1)))).to_mesh64()
    return _about_origin(few.vert_properties[:, :3][few.tri_verts])


def _about_origin(corners: Floats) -> Moments:
    found = integrate(MemoryTriangles("surface", np.ascontiguousarray(corners)))
    r, V = found.reference, found.volume
    mixed = np.outer(found.first, r)
    return Moments(V, found.first + V * r, found.S + mixed + mixed.T + V * np.outer(r, r))


def by_triangles(triangles: Triangles, dtype: type, reference: Floats) -> Moments:
    """The integral over the surface in floats of this type, about a point of reference; nan where it overflows."""
    sweep = swept(triangles, volume_kernel, dtype=dtype, reference=reference.astype(dtype))
    if not np.isfinite(sweep.sums[:, :10]).all():
        return Moments(np.nan, np.full(3, np.nan), np.full((3, 3), np.nan))
    sums = sweep.totals(slice(10))
    return Moments(sums[0] / 6, sums[1:4] / 24, symmetric(sums[4:10] / 120))


def inertia(moments: Moments) -> Array:
    """Return (3, 3) fractions, about the centre of mass at density 1, without any rounding of their own."""
    V, first, S = (exact(part) if isinstance(part, np.ndarray) else exact(part).item() for part in moments)
    about = S - np.outer(first, first) / V
    turned: Array = np.eye(3, dtype=int) * about.trace() - about
    return turned


def needs_rationals(target: float) -> bool:
    """Whether floats, escalated to `LIMIT`, are not enough; raise InputError if no result in doubles is as accurate."""
    refuse_beyond_doubles(target)
    return target < LIMIT


def with_promise(part: Part, target: float) -> Part:
    """Return the part with a note on the arithmetic that meets the target; MeshError: the surface is not known so well.

    Accuracy: bounds are proven for the triangles as given, whose own rounding is reported beside."""
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
