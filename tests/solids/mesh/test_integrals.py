"""Integrals of closed surfaces: books, exact rationals by another formula, thin bodies, bounds, stretched meshes."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import partial
from math import isqrt

import numpy as np
import pytest
from helpers import mesh_samples
from helpers.mesh_oracle import centred, deviation, exact, rational_moments, rational_moments_from, rotation
from helpers.mesh_samples import (
    binary_stl,
    box,
    cone,
    corners,
    cylinder,
    flipped,
    moved,
    tetrahedron,
    torus,
    uv_sphere,
)
from hypothesis import example, given
from hypothesis import strategies as st

from robodyn.errors import MeshError
from robodyn.solids.inertia.properties import principal_axes
from robodyn.solids.mass_properties import mass_properties
from robodyn.solids.mesh.integrals import Moments, integrate, measure, surface, volume_bound
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.solids.mesh.triangles import ROWS, MemoryTriangles

EPS = np.finfo(float).eps


def test_mirtichs_tetrahedron():
    body = mass_properties(tetrahedron(), density=1.0).body
    inertia = [[9.375, 2.5, 1.875], [2.5, 12.75, 1.5], [1.875, 1.5, 15.375]]
    for found, expected in ((body.volume, 10.0), (body.com, (1.25, 1.0, 0.75)), (body.inertia, inertia)):
        assert np.abs(found - np.asarray(expected)).max() <= 8 * EPS * np.abs(expected).max()


BODIES = {
    "box": box((0.3, 2.0, 0.7)),
    "tetrahedron": tetrahedron(),
    "sphere": uv_sphere(0.77, 12, 25),
    "cylinder": cylinder(0.37, 1.3, 100),
    "cone": cone(0.5, 1.0, 40),
    "torus": torus(2.0, 0.5, 24, 12),
    "two": np.concatenate([box(), moved(torus(1, 0.3, 16, 8), (2.1, 0.2, -0.4))]),
    "cavity": np.concatenate([box((3, 3, 3)), flipped(uv_sphere(1, 8, 16))]),
}


def integrals(array, exact=False):
    return integrate(MemoryTriangles("body", array), exact)


def errors(found, array):
    """Relative errors of volume and second moments, normwise, against rationals."""
    V, _, S = rational_moments(array, found.reference)
    return deviation(found.volume, V), deviation(found.S, S)


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize(("offset", "scale"), [(1e8, 1.0), (2.0, 1e-50), (2.0, 1e50)])
def test_within_1e15_wherever_the_origin_is_and_at_any_scale(body, offset, scale):
    array = moved(BODIES[body], np.array((0.6, -1.0, 0.8)) * offset, rotation(3)) * scale
    found = integrals(array)
    volume, second = errors(found, array)
    assert volume <= min(1e-15, found.bound)
    assert second <= 1e-15
    assert found.method == "float64"


numbers = st.one_of(
    st.integers(-3, 3).map(float),
    st.floats(-2.0, 2.0),
    st.floats(-1e12, 1e12),
    st.sampled_from([0.1, -0.0, 1e-20]),
)


@given(st.lists(st.tuples(*[numbers] * 3), min_size=3, max_size=8), st.data())
def test_exact_on_any_triangles(points, data):
    index = st.integers(0, len(points) - 1)
    faces = data.draw(st.lists(st.tuples(index, index, index), min_size=1, max_size=12))
    array = corners(points, faces)
    found = integrals(array, exact=True)
    assert (found.method, found.bound) == ("rational", EPS / 2)
    V, first, S = rational_moments_from(found.reference, array)
    assert (found.moments.volume, *found.moments.first) == (V, *first)
    assert (found.moments.second == S).all()


def principal_errors(found, array):
    """Relative error of each principal second moment about the centre."""
    expected = principal_axes(centred(*rational_moments(array, found.reference))).second
    return np.abs(principal_axes(centred(*found.moments)).second / expected - 1)


def test_where_long_doubles_are_no_wider_integers_follow(monkeypatch):
    monkeypatch.setattr(np, "longdouble", np.float64)
    assert integrals(moved(box((1, 1, 0.03)), R=rotation(5))).method == "rational"


@given(
    body=st.sampled_from(sorted(BODIES)),
    exponents=st.tuples(*[st.floats(-5, 0)] * 3),
    seed=st.integers(0, 99),
    offset=st.sampled_from([0.0, 1.0, 1e3]),
)
@example(body="box", exponents=(0.0, 0.0, -1.5), seed=1, offset=0.0)
@example(body="box", exponents=(0.0, 0.0, -2.5), seed=1, offset=1.0)
@example(body="cylinder", exponents=(0.0, -2.5, -2.5), seed=4, offset=1e3)
def test_no_bound_is_broken(body, exponents, seed, offset):
    array = moved(BODIES[body] * 10.0 ** np.array(exponents), np.array((0.3, 0.1, -0.9)) * offset, rotation(seed))
    found = integrals(array)
    V, _, _ = rational_moments(array, found.reference)
    assert deviation(found.volume, V) <= found.bound <= 1e-12
    assert principal_errors(found, array).max() <= found.bound_second + 16 * EPS
    assert found.bound_second <= 1e-12


ONE = Moments(Fraction(1), np.zeros(3), np.eye(3))


@pytest.mark.parametrize("perm", [12.34567, 9.999e5])
def test_last_digits_do_not_show(perm: float) -> None:
    bounds = [volume_bound(ONE, perm * (1 + k * 1e-15), 1e-16) for k in (-3, 0, 5)]
    exact = 8e-16 * perm + 2.0**-53
    assert len(set(bounds)) == 1
    assert exact <= bounds[0] <= 1.01 * exact
    assert float(f"{bounds[0]:.2e}") == bounds[0]


def surface_moments(corners, reference):
    """Area, first and second moments of faces, of which each area has 40 digits."""
    area, first, second = Fraction(0), np.zeros(3, object), np.zeros((3, 3), object)
    for a, b, c in exact(corners) - exact(reference):
        normal = np.cross(b - a, c - a)
        size = Fraction(isqrt((normal @ normal) * 10**80 // 1), 10**40) / 2
        s = a + b + c
        area += size
        first = first + size * s / 3
        second = second + size * sum(np.outer(v, v) for v in (a, b, c, s)) / 12
    return area, first, second


@pytest.mark.parametrize("body", [box((1, 2, 3)), uv_sphere(0.5, 6, 8), torus(2, 0.5, 12, 8)])
@pytest.mark.parametrize("offset", [0, 1e8])
def test_surfaces_within_1e15_wherever_the_origin_is_and_however_wound(body, offset):
    array = moved(body, (0.6 * offset, -offset, 0.8 * offset), rotation(3))
    array[:5] = flipped(array[:5])
    area, arms, second, reference = surface(MemoryTriangles("sheet", array))
    A, first, S = surface_moments(array, reference)
    assert deviation(area, A) <= 1e-15
    assert deviation(second, S) <= 1e-15
    assert np.abs(exact(arms) - first).max() <= 1e-15 * float(A) * np.ptp(array)


@pytest.mark.parametrize(("count", "spare"), [(ROWS, 0), (ROWS - 4, 1), (ROWS + 4, 1)])
def test_the_edge_of_a_block(count, spare):
    array = np.concatenate([cylinder(0.7, 1.1, count // 4), np.zeros((spare, 3, 3))])
    found = integrals(array)
    V, _, S = rational_moments(array, found.reference)
    assert found.count == len(array) == count + spare
    assert deviation(found.volume, V) <= 4 * EPS
    assert deviation(found.S, S) <= 4 * EPS


@pytest.mark.parametrize(("size", "how"), [(1e70, "large"), (1e200, "large"), (1e-70, "small"), (1e-200, "small")])
def test_beyond_the_range_of_floats(size, how):
    for use in (integrals, partial(integrals, exact=True), lambda array: surface(MemoryTriangles("body", array))):
        with pytest.raises(MeshError, match=re.escape(f"body: is too {how}")):
            use(box((size, size, size)))


def test_no_triangles():
    with pytest.raises(MeshError, match="body: has no triangles"):
        integrals(np.zeros((0, 3, 3)))


@pytest.mark.parametrize(("value", "face"), [(np.nan, 0), (np.inf, ROWS - 1), (-np.inf, ROWS + 5)])
@pytest.mark.parametrize("use", [integrate, measure])
def test_a_corner_of_a_streamed_file_that_is_not_finite_names_its_face(use, face, value):
    corners = cylinder(1, 1, ROWS).astype(np.float32)
    corners[face, 1, 2] = value
    with pytest.raises(MeshError, match=rf"face {face + 1} has a corner at \(.*{value:g}\)"):
        use(load_triangles(binary_stl(corners)))


def test_above_a_limit_neither_is_sought_though_asked(monkeypatch):
    body = torus()
    found = mass_properties(body, symmetry=True, tessellation=True)
    assert found.symmetry is not None
    assert found.tessellation is not None
    monkeypatch.setenv("ROBODYN_LIMITS", f"mesh_shape={len(body) - 1}")
    found = mass_properties(body, symmetry=True, tessellation=True)
    assert found.symmetry is None
    assert found.tessellation is None
    assert [note.partition(",")[0] for note in found.notes] == [
        "symmetry: not sought above 1023 triangles",
        "tessellation: not sought above 1023 triangles",
    ]
    assert found.body.volume > 0
    with pytest.raises(MeshError, match="ROBODYN_LIMITS=mesh_shape=NUMBER"):
        mass_properties(body, symmetrize=True)


WEDGE = mesh_samples.tetrahedron()


@pytest.mark.parametrize("factors", [(0.5, 2, 4), (1, -1, 1), (-1, -1, 3), (-2, -2, -2)])
def test_moments_are_those_of_the_stretched_body(factors):
    """V' = |det A| V, c' = A c, S' = |det A| A S A for A = diag(factors), mirror images included."""
    A, det = np.diag(factors), abs(np.prod(factors))
    before = mass_properties(WEDGE, density=1).body
    part = mass_properties(WEDGE, density=1, scale=factors)
    assert (part.closed, part.repairs) == (True, ())
    assert part.body.volume == pytest.approx(det * before.volume, rel=8 * EPS)
    np.testing.assert_allclose(part.body.com, A @ before.com, rtol=8 * EPS)
    expected = det * A @ before.S_c @ A
    np.testing.assert_allclose(part.body.S_c, expected, rtol=0, atol=32 * EPS * np.abs(expected).max())
    corners = WEDGE * factors
    np.testing.assert_array_equal((part.lo, part.hi), (corners.min(axis=(0, 1)), corners.max(axis=(0, 1))))


def test_a_part_in_millimetres_is_not_doubted():
    assert mass_properties(100 * WEDGE, scale=(0.001,) * 3).warnings == ()
    assert len(mass_properties(100 * WEDGE).warnings) == 1
