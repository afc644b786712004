import numpy as np
import pytest
from helpers import mesh_samples as samples
from helpers.symmetric_bodies import any_rotation, bracket, cavity, found, pinwheel

from robodyn.solids.inertia.properties import from_integrals
from robodyn.solids.mesh.asymmetry import CentredBody, mirror
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.read.load import from_array
from robodyn.solids.mesh.symmetry import symmetrized


def zeros(corners):
    return [product.axes for product in found(corners).products if product.zero]


def test_plane_makes_the_products_with_its_normal_zero():
    assert zeros(bracket()) == ["xz", "yz"]
    products = {product.axes: product for product in found(bracket()).products}
    assert abs(products["xz"].relative) <= 1e-14
    assert products["xy"].residual == pytest.approx(-1.5 * 0.75, rel=1e-12)


def test_axis_of_any_fold_does_so_too():
    assert zeros(pinwheel()) == ["xy", "xz", "yz"]


def test_askew_body_has_planes_but_no_product_that_is_zero():
    assert zeros(samples.moved(samples.box((1, 2, 3)), R=any_rotation(2))) == []
    assert zeros(samples.moved(samples.box(), R=any_rotation(2))) == ["xy", "xz", "yz"]
    assert zeros(samples.tetrahedron()) == []


@pytest.mark.parametrize("seed", range(3))
def test_asymmetry_is_not_below_what_products_and_moments_allow(seed):
    triangles = from_array(samples.moved(bracket(), R=any_rotation(seed)))
    body = CentredBody.of(triangles, integrate(triangles))
    for normal in any_rotation(seed + 10):
        across = np.eye(3)[0] - normal[0] * normal
        across /= np.linalg.norm(across)
        points = body.corners.reshape(-1, 3)
        integral = abs(across @ body.S @ normal)
        bound = integral / (body.volume * np.abs(points @ across).max() * np.abs(points @ normal).max())
        assert 1e-4 < bound <= body.mirrored(normal)
        assert 0 < body.least(mirror(normal)) <= body.mirrored(normal)


def test_average_with_the_mirror_image_has_no_product_with_the_normal():
    """A hole off the plane moves the centre, which goes back."""
    R = any_rotation(5)
    whole = samples.moved(bracket(), (1.0, 2.0, 3.0), R)
    hole = samples.moved(cavity((0.5, 0.5, 0.4), (0.3, 0.2, 0.1)), (1.0, 2.0, 3.0), R)
    given = properties(np.concatenate([whole, hole]))
    average = symmetrized(given, found(whole))
    plane = found(whole).planes[0]
    n, eps = plane.normal, np.finfo(float).eps
    assert abs(given.com @ n - plane.offset) > 1e-4
    assert abs(average.com @ n - plane.offset) <= 4e-15
    np.testing.assert_allclose(np.cross(average.com - given.com, n), 0, atol=2e-15)
    product = average.S_c @ n
    assert np.abs(product - n * (n @ product)).max() <= 4 * eps * np.trace(average.S_c)
    assert (average.mass, average.volume) == (given.mass, given.volume)
    half = given.scaled_to_mass(given.mass / 2)
    both = half + half.placed(mirror(n), 2 * plane.offset * n)
    np.testing.assert_allclose(average.S_c, both.S_c, rtol=0, atol=8 * eps * np.trace(both.S_c))


def properties(corners):
    found = integrate(from_array(corners))
    return from_integrals(found.volume, found.first, found.S, density=2.0, reference=found.reference)


def test_average_under_an_axis_has_equal_transverse_moments():
    body = samples.moved(pinwheel(), (1.0, 2.0, 3.0))
    noisy = properties(body + 1e-4 * np.random.default_rng(1).normal(size=(3, 3)))
    average = symmetrized(noisy, found(body))
    assert average.S_c[0, 0] == pytest.approx(average.S_c[1, 1], rel=1e-15)
    assert abs(noisy.S_c[0, 0] / noisy.S_c[1, 1] - 1) > 1e-6
    assert [average.S_c[0, 1], average.S_c[0, 2], average.S_c[1, 2]] == [0, 0, 0]


def test_average_of_a_body_without_symmetry_is_itself():
    given = properties(samples.tetrahedron())
    average = symmetrized(given, found(samples.tetrahedron()))
    np.testing.assert_allclose(average.S_c, given.S_c, rtol=0, atol=1e-15 * np.trace(given.S_c))
    assert np.array_equal(average.com, given.com)


def test_normals_of_a_float32_file_lie_along_the_axes():
    """And so the products with them are 0 after the average, not only nearly."""
    solid = samples.moved(bracket(), (0.1, 0.2, 0.3)) * 1.1
    body = solid.astype(np.float32).astype(float)
    plane = found(body).planes[0]
    assert plane.holds
    assert sorted(np.abs(plane.normal)) == [0, 0, 1]
    average = symmetrized(properties(body), found(body))
    assert average.S_c[0, 2] == average.S_c[1, 2] == 0 < abs(average.S_c[0, 1])
