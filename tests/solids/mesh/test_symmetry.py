"""Planes, axes and products of inertia that vanish, of known bodies and of each finite group; averages; scores."""

from __future__ import annotations

from math import comb, factorial, inf, pi, prod

import numpy as np
import pytest
from helpers import mesh_samples as samples
from helpers.mesh_oracle import rotation
from helpers.mesh_samples import box
from helpers.round_shapes import SOLIDS
from helpers.symmetric_bodies import axes, body, bracket, cavity, extrusion, found, group, pinwheel, planes, verdicts

from robodyn.errors import MeshError
from robodyn.solids.inertia.properties import from_integrals
from robodyn.solids.mesh.asymmetry import (
    CentredBody,
    TriangleSet,
    axial_moments,
    central_moments,
    mirror,
    sixth_moments,
)
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.read.load import from_array
from robodyn.solids.mesh.symmetry import symmetrized
from robodyn.solids.mesh.symmetry_search import Symmetry
from robodyn.support.floats import first_largest


def test_box_has_three_exact_planes_through_its_centre():
    planes = found(samples.moved(samples.box((1, 2, 3)), (5, 7, 9))).planes
    assert verdicts(planes) == ["exact"] * 3
    assert max(plane.asymmetry for plane in planes) <= 1e-14
    normals = np.array([plane.normal for plane in planes])
    np.testing.assert_allclose(np.abs(normals).sum(axis=0), 1.0, atol=1e-14)
    np.testing.assert_allclose([plane.offset for plane in planes], normals @ (5, 7, 9), rtol=1e-14)


def test_angle_bracket_has_one_plane_in_any_pose_and_a_tetrahedron_none():
    R = rotation(2)
    given = found(samples.moved(bracket(), (100.0, -300.0, 50.0), R))
    assert verdicts(given.planes) == ["exact", "none", "none"]
    np.testing.assert_allclose(np.abs(given.planes[0].normal @ R), (0, 0, 1), atol=1e-11)
    askew = found(samples.moved(bracket(), (0.1, 0.2, 0.3), rotation(1)).astype(np.float32)).planes[0]
    assert (askew.verdict, 0 < askew.asymmetry < 1e-6) == ("exact", True)
    planes = found(samples.tetrahedron()).planes
    assert verdicts(planes) == ["none"] * 3
    assert min(plane.asymmetry for plane in planes) > 0.3
    assert given.axes == found(samples.tetrahedron()).axes == ()
    with pytest.raises(MeshError, match=r"has no volume .symmetry is that of a closed mesh"):
        found(samples.sheet())


def test_hole_off_the_plane_is_seen():
    """A hole of 0.07 % moves the centre and tilts the principal axes, which adds to its own share."""
    body = np.concatenate([samples.box((2.0, 1.0, 0.9)), cavity((0.6, 0.3, 0.2), (0.14, 0.1, 0.09))])
    planes = found(body).planes
    assert verdicts(planes) == ["near"] * 3
    assert min(plane.asymmetry for plane in planes) > 7e-4
    assert max(plane.asymmetry for plane in planes) < 1e-2


@pytest.mark.parametrize("size", [0.02, 0.005])
def test_hole_between_the_columns_is_seen_by_the_moments(size):
    body = np.concatenate([samples.box((1.0, 2.0, 3.0)), cavity((0.3, 0.6, 0.9), (size, size, size))])
    for plane in found(body, tolerance=1e-9).planes:
        assert plane.asymmetry > size**3 / 6 / 2
        assert plane.verdict == "near"


def test_score_is_the_symmetric_difference_about_the_plane_that_is_reported():
    """A box about the origin with a hole at x = 0.01: the plane goes through the common centre, a little beside it."""
    shift, V, hole = 0.01, 8 - 0.4**3, 0.4**3
    body = np.concatenate([samples.box((4, 2, 1)), cavity((shift, 0, 0), (0.4, 0.4, 0.4))])
    (across,) = [plane for plane in found(body).planes if abs(plane.normal[0]) > 0.9]
    centre = -hole * shift / V
    assert across.offset * across.normal[0] == pytest.approx(centre, rel=1e-9)
    expected = (4 * abs(centre) * 2 * 1 + 4 * (shift - centre) * 0.4**2) / (2 * V)
    assert across.asymmetry == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("body", [samples.box((1, 2, 3)), samples.cylinder(height=3.0, sectors=5)])
def test_normals_and_axes_point_to_their_largest_component(body):
    """The first of ties: whichever sign an eigenvector or an angle came with."""
    symmetry = found(samples.moved(body, (1.0, 2.0, 3.0), rotation(3)))
    listed = [*(plane.normal for plane in symmetry.planes), *(axis.direction for axis in symmetry.axes)]
    listed += [plane.normal for plane in found(body).planes]
    assert len(listed) > 3
    assert all(line[first_largest(np.abs(line))] > 0 for line in listed)


def test_cube_has_thirteen_axes_and_nine_planes():
    R = rotation(2)
    cube = found(samples.moved(samples.box(), R=R))
    folds = [(axis.fold, axis.verdict) for axis in cube.axes]
    assert sorted(folds) == [(2, "exact")] * 6 + [(3, "exact")] * 4 + [(4, "exact")] * 3
    assert verdicts(cube.planes) == ["exact"] * 9
    assert [product.zero for product in cube.products] == [True] * 3
    directions = np.sort([np.round(np.abs(plane.normal @ R) * 2**0.5, 9) ** 2 for plane in cube.planes], axis=1)
    assert sorted(map(tuple, directions.round(6))) == sorted([(0, 0, 2)] * 3 + [(0, 1, 1)] * 6)


@pytest.mark.parametrize("sectors", [24, 77])
@pytest.mark.parametrize("body", [samples.cylinder, samples.cone])
def test_facets_of_a_round_body_are_told_from_it(body, sectors):
    axes = found(body(height=3.0, sectors=sectors)).axes
    assert [(axis.fold, axis.verdict) for axis in axes] == [(sectors, "exact"), (inf, "within tessellation")]
    facets = (2 * pi / sectors) ** 2 / 6
    assert 0.1 * facets < axes[1].asymmetry < facets


def test_ball_is_round_about_two_axes():
    axes = found(samples.uv_sphere(rings=24, sectors=48)).axes
    assert [axis.fold for axis in axes] == [48, inf, inf]
    assert [axis.verdict for axis in axes] == ["exact", "within tessellation", "within tessellation"]


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
    assert zeros(samples.moved(samples.box((1, 2, 3)), R=rotation(2))) == []
    assert zeros(samples.tetrahedron()) == []


def test_average_with_the_mirror_image_has_no_product_with_the_normal():
    """A hole off the plane moves the centre, which goes back."""
    R = rotation(5)
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


def test_normals_of_a_float32_file_lie_along_the_axes():
    """And so the products with them are 0 after the average, not only nearly."""
    solid = samples.moved(bracket(), (0.1, 0.2, 0.3)) * 1.1
    body = solid.astype(np.float32).astype(float)
    plane = found(body).planes[0]
    assert plane.holds
    assert sorted(np.abs(plane.normal)) == [0, 0, 1]
    average = symmetrized(properties(body), found(body))
    assert average.S_c[0, 2] == average.S_c[1, 2] == 0 < abs(average.S_c[0, 1])


MIRROR = np.diag([1.0, 1.0, -1.0])


def test_a_corner_moved_by_a_millionth_or_a_triangle_twice_makes_it_another():
    body = samples.cylinder(sectors=12)
    both = np.concatenate([body, body * (1, 1, -1)])
    assert TriangleSet(both, 2.0).invariant(MIRROR)
    twice = np.concatenate([both, body[:1]])
    assert not TriangleSet(twice, 2.0).invariant(MIRROR)
    both[3, 1, 2] += 1e-6
    assert not TriangleSet(both, 2.0).invariant(MIRROR)


AXIAL = ["C", "Cv", "Ch", "D", "Dh", "Dd", "S"]
REGULAR = ["T", "Td", "Th", "O", "Oh", "I", "Ih"]
GROUPS = [(name, 2 + k % 2) for k, name in enumerate(AXIAL)] + [("Td", 1)]
FURTHER = [(name, n) for n in (4, 5) for name in AXIAL] + [(name, 1) for name in REGULAR]
ALMOST = [(name, 3) for name in AXIAL] + [(name, 1) for name in REGULAR]


def same(one: np.ndarray, other: np.ndarray, within: float) -> bool:
    return bool(np.linalg.norm(np.cross(one, other)) < within)


def all_found(name: str, n: int, noise: float = 0.0, seed: int = 0, within: float = 1e-5) -> None:
    elements = group(name, n)
    corners, R = body(elements, noise, seed)
    verdict = found(corners)
    least = max(1e-6, 100 * noise)
    mirrors = [plane.normal for plane in verdict.planes if plane.asymmetry <= least]
    turns = [(axis.direction, axis.fold) for axis in verdict.axes if axis.asymmetry <= least]
    for normal in planes(elements):
        assert any(same(R @ normal, other, within) for other in mirrors)
    for direction, fold in axes(elements):
        assert any(same(R @ direction, other, within) and fold == many for other, many in turns)
    assert len(mirrors) == len(planes(elements))
    assert len(turns) == len(axes(elements))


@pytest.mark.parametrize(("name", "n"), GROUPS)
def test_every_element_of_a_finite_group_is_found_and_no_other(name: str, n: int) -> None:
    all_found(name, n)


@pytest.mark.parametrize("longer", [1e-3, 1e-2])
def test_an_axis_is_near_though_one_arm_of_a_star_is_longer(longer: float) -> None:
    angles, radii = np.pi * np.arange(6) / 3, np.array((1 + longer, 0.5, 1.0, 0.5, 1.0, 0.5))
    verdict = found(extrusion(np.column_stack([radii * np.cos(angles), radii * np.sin(angles)]), 0.6))
    ((asymmetry, kind),) = [(axis.asymmetry, axis.verdict) for axis in verdict.axes if axis.fold == 3]
    assert kind == "near"
    assert 0.2 * longer < asymmetry < longer
    assert sum(axis.fold == 2 for axis in verdict.axes) == 3


@pytest.mark.slow
@pytest.mark.parametrize(("name", "n"), FURTHER)
def test_every_element_of_further_axial_groups_is_found(name: str, n: int) -> None:
    all_found(name, n, seed=n)


@pytest.mark.parametrize(("name", "n"), [("Cv", 3), ("D", 4)])
def test_every_element_is_found_where_it_is_near(name: str, n: int) -> None:
    all_found(name, n, noise=1e-5, within=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "n"), ALMOST)
def test_every_element_of_a_group_is_found_where_it_is_near(name: str, n: int) -> None:
    all_found(name, n, 1e-5, seed=1, within=0.01)


PLANES = dict.fromkeys(["cylinder", "tube", "capsule", "ball", "rounded disc", "pulley", "torus"], "xyz") | {
    "cone": "xy",
    "half ball": "xy",
    "ellipsoid": "xyz",
    "ball of equal triangles": "xyz",
    "plate with a hole": "z",
    "bracket": "z",
    "lever": "yz",
    "rounded box": "xyz",
    "box with small fillets": "xyz",
}


def lacking(corners: np.ndarray) -> float:
    """What facets leave out, as a part of the volume."""
    triangles = from_array(corners)
    return CentredBody.of(triangles, integrate(triangles)).facets


def holds(verdict: Symmetry, normal: np.ndarray) -> bool:
    """A plane near this normal holds, or an axis of revolution in that plane, or two such axes: a ball."""
    near = any(same(plane.normal, normal, 0.02) for plane in verdict.planes if plane.holds)
    lines = [axis.direction for axis in verdict.axes if axis.holds and axis.fold == inf]
    return near or len(lines) > 1 or any(abs(line @ normal) < 0.02 for line in lines)


@pytest.mark.slow
def test_fewer_than_one_verdict_in_a_hundred_is_false() -> None:
    """In any pose and size; every other one with a box off the planes, clearly larger than what facets leave out."""
    rng = np.random.default_rng(0)
    wrong = []
    for k, name in enumerate(4 * [*PLANES]):
        turn = k // len(PLANES)
        facets, planes = int(rng.integers(16, 49)), PLANES[name]
        while lacking(corners := SOLIDS[name](facets).corners) > 4e-3:
            facets *= 2
        if (k + turn) % 2:
            share = max(4.0 * lacking(corners), 10 ** rng.uniform(-4, -2))
            edge = (share * integrate(from_array(corners)).volume) ** (1 / 3)
            place = corners.max(axis=(0, 1)) + edge * rng.uniform(0.6, 1.5, 3)
            corners, planes = np.concatenate([corners, samples.moved(box((edge, edge, edge)), place)]), ""
        R = rotation(k)
        placed = samples.moved(corners, rng.normal(size=3), R) * 10.0 ** rng.uniform(-3, 3)
        verdict = found(placed.astype(np.float32).astype(float) if turn < 2 else placed)
        wrong += [holds(verdict, R[:, i]) != (axis in planes) for i, axis in enumerate("xyz")]
    assert np.mean(wrong) < 0.01


def monomial(*powers):
    """The integral of x^a y^b z^c over the unit tetrahedron at the origin, a! b! c! / (a + b + c + 3)!."""
    return prod(map(factorial, powers)) / factorial(sum(powers) + 3)


def test_moments_of_the_unit_tetrahedron():
    corner = samples.tetrahedron(((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)))
    _, third, fourth = central_moments(corner, np.eye(3), 1 / 6).tensors
    for tensor in (third, fourth, sixth_moments(corner)):
        for index in np.ndindex(tensor.shape):
            assert tensor[index] == pytest.approx(monomial(*(index.count(i) for i in range(3))), rel=1e-13)
    axial = axial_moments(corner, np.eye(3), 1 / 6)
    for m, k in np.ndindex(8, 3):
        powers = [comb(m + 1, j) * 1j**j * monomial(m + 1 - j, j, k) for j in range(m + 2)]
        assert abs(axial[m, k] - (6 * sum(powers) if m + 1 + k <= 8 else 0.0)) <= 1e-14
