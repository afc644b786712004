"""Plates and needles: every principal second moment holds, in any pose, by finer arithmetic where it takes that."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from helpers.mesh_oracle import centred, deviation, rational_moments, rotation
from helpers.mesh_samples import box, cylinder, moved, tetrahedron, torus, uv_sphere
from hypothesis import example, given
from hypothesis import strategies as st

from robodyn.solids.inertia.principal import principal_axes
from robodyn.solids.inertia.properties import from_integrals
from robodyn.solids.mesh.integrals import Moments, integrate, volume_bound
from robodyn.solids.mesh.triangles import MemoryTriangles

EPS = np.finfo(float).eps
BODIES = {
    "box": box(),
    "tetrahedron": tetrahedron(),
    "sphere": uv_sphere(1, 8, 12),
    "cylinder": cylinder(0.5, 1.0, 24),
    "torus": torus(1.0, 0.3, 16, 8),
}
FINER = {"long double", "rational"}


def integrals(array):
    return integrate(MemoryTriangles("body", array))


def principal_errors(found, array):
    """Relative error of each principal second moment about the centre."""
    expected = principal_axes(centred(*rational_moments(array, found.reference))).second
    return np.abs(principal_axes(centred(*found.moments)).second / expected - 1)


@pytest.mark.parametrize("sizes", [(1, 1, 1e-6), (1, 1e-6, 1e-6), (1, 1e-3, 1e-6), (1, 1, 1e-9)])
@pytest.mark.parametrize("body", ["box", "sphere", "cylinder"])
@pytest.mark.parametrize("place", [(0, 0, 0), (1.5, -0.25, 3), (1e3, 2e2, -1e3)])
def test_in_any_pose(sizes, body, place):
    array = moved(BODIES[body] * sizes, place, rotation(11))
    found = integrals(array)
    assert principal_errors(found, array).max() <= 1e-12
    assert deviation(found.volume, rational_moments(array, found.reference)[0]) <= 1e-12
    assert found.method in FINER


@pytest.mark.parametrize("sizes", [(1, 1, 1e-6), (1, 1e-6, 1e-6)])
@pytest.mark.parametrize("body", ["box", "sphere"])
def test_along_the_axes_float64_is_enough(sizes, body):
    array = moved(BODIES[body] * sizes, (0.5, -2, 0.25))
    found = integrals(array)
    assert found.method == "float64"
    assert principal_errors(found, array).max() <= 1e-14


def test_mass_properties_keep_the_small_moments():
    array = moved(box((1, 1e-6, 1e-6)), (3, 2, 1), rotation(2))
    found = integrals(array)
    body = from_integrals(*found.moments, density=1.0, reference=found.reference)
    expected = principal_axes(centred(*rational_moments(array, (0, 0, 0))))
    assert body.principal.second == pytest.approx(expected.second, rel=1e-12)
    assert body.principal.moments == pytest.approx(expected.moments, rel=1e-12)


@pytest.mark.skipif(np.finfo(np.longdouble).nmant < 63, reason="long doubles have no more bits here")
def test_long_double_is_tried_before_integers():
    assert integrals(moved(box((1, 1, 0.03)), R=rotation(5))).method == "long double"
    assert integrals(moved(box((1, 1, 1e-6)), R=rotation(5))).method == "rational"


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


@pytest.mark.parametrize("perm", [1.0, 3.3, 12.34567, 9.999e5, 1e-3])
def test_last_digits_do_not_show(perm: float) -> None:
    bounds = [volume_bound(ONE, perm * (1 + k * 1e-15), 1e-16) for k in (-3, 0, 5)]
    exact = 8e-16 * perm + 2.0**-53
    assert len(set(bounds)) == 1
    assert exact <= bounds[0] <= 1.01 * exact
    assert float(f"{bounds[0]:.2e}") == bounds[0]
