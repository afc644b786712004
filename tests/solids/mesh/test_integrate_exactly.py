"""Integrals against exact rationals by another formula: how far they are off, and that no bound is broken."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_oracle import deviation, rational_moments, rational_moments_from, rotation
from helpers.mesh_samples import box, cone, corners, cylinder, flipped, moved, tetrahedron, torus, uv_sphere
from helpers.sampled import sampled
from hypothesis import given
from hypothesis import strategies as st

from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.triangles import MemoryTriangles

EPS = np.finfo(float).eps
BODIES = {
    "box": box((0.3, 2.0, 0.7)),
    "tetrahedron": tetrahedron(),
    "sphere": uv_sphere(0.77, 12, 25),
    "cylinder": cylinder(0.37, 1.3, 100),
    "cone": cone(0.5, 1.0, 40),
    "torus": torus(2.0, 0.5, 40, 24),
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
@pytest.mark.parametrize("offset", sampled([0, 1, 1e2, 1e8, 1e4, 1e6], 3))
def test_within_1e15_wherever_the_origin_is(body, offset):
    array = moved(BODIES[body], np.array((0.6, -1.0, 0.8)) * offset, rotation(3))
    found = integrals(array)
    volume, second = errors(found, array)
    assert volume <= min(1e-15, found.bound)
    assert second <= 1e-15
    assert found.method == "float64"


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("scale", sampled([1e-50, 1e-20, 1e-6, 1e50, 1e-3, 1e3, 1e6, 1e20], 3))
def test_within_1e15_at_any_scale(body, scale):
    array = moved(BODIES[body], (1, 2, 3), rotation(7)) * scale
    found = integrals(array)
    assert max(errors(found, array)) <= 1e-15
    assert found.method == "float64"


@pytest.mark.parametrize("sectors", [300, 707, 1003, 1040, 3000])
def test_equal_terms_do_not_pile_up_their_rounding(sectors):
    array = cylinder(1.0, 2.0, sectors)
    assert max(errors(integrals(array), array)) <= 2 * EPS


@pytest.mark.parametrize("body", BODIES)
def test_float32_corners_are_integrated_as_they_are(body):
    array = moved(BODIES[body], (1e3, 2e3, -4e3), rotation(1)).astype(np.float32)
    assert max(errors(integrals(array), array)) <= 1e-15


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("place", [0, 1, 1e8])
def test_exact_is_correctly_rounded(body, place):
    array = moved(BODIES[body], np.array((0.1, 1.0, -0.3)) * place, rotation(5))
    found = integrals(array, exact=True)
    V, first, S = rational_moments(array, found.reference)
    assert (found.moments.volume, *found.moments.first) == (V, *first)
    assert (found.moments.second == S).all()
    assert found.volume == float(V)
    assert (S.astype(float) == found.S).all()
    assert found.method == "rational"
    assert found.bound == EPS / 2


@pytest.mark.parametrize(("small", "large"), [(1e-300, 1e50), (5e-324, 1.0), (2.0**-60, 3e7)])
def test_exact_over_many_orders_of_magnitude(small, large):
    array = moved(BODIES["torus"][:9], (0.5, 0.25, 2))
    array[1, 2] = (small, -large, 3 * small)
    found = integrals(array, exact=True)
    V, first, S = rational_moments_from(found.reference, array)
    assert (found.moments.volume, *found.moments.first) == (V, *first)
    assert (found.moments.second == S).all()


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
    V, first, S = rational_moments_from(found.reference, array)
    assert (found.moments.volume, *found.moments.first) == (V, *first)
    assert (found.moments.second == S).all()
