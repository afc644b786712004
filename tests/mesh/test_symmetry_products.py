import mesh_samples as samples
import numpy as np
import pytest
from symmetric_bodies import any_rotation, bracket, cavity, found, pinwheel

from robodyn.inertia.conversions import from_integrals
from robodyn.mesh.asymmetry import CentredBody, mirror
from robodyn.mesh.integrate import integrate
from robodyn.mesh.load import from_array
from robodyn.mesh.symmetry import symmetrized


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
    R = any_rotation(5)
    whole = samples.moved(bracket(), (1.0, 2.0, 3.0), R)
    hole = samples.moved(cavity((0.5, 0.5, 0.4), (0.3, 0.2, 0.1)), (1.0, 2.0, 3.0), R)
    triangles = from_array(np.concatenate([whole, hole]))
    integrals = integrate(triangles)
    given = from_integrals(integrals.volume, integrals.first, integrals.S, density=2.0, reference=integrals.reference)
    plane = found(whole).planes[0]
    average = symmetrized(given, plane)
    n = plane.normal
    assert abs(average.com @ n - plane.offset) <= 4e-15
    product = average.S_c @ n
    assert np.abs(product - n * (n @ product)).max() <= 2 * 2.3e-16 * np.trace(average.S_c)
    assert (average.mass, average.volume) == (pytest.approx(given.mass, rel=1e-15), given.volume)
    assert n @ average.S_c @ n == pytest.approx(n @ given.S_c @ n + given.mass * (given.com @ n - plane.offset) ** 2)
