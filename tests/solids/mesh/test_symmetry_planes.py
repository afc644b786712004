import numpy as np
import pytest
from helpers import mesh_samples as samples
from helpers.symmetric_bodies import any_rotation, bracket, cavity, found, verdicts

from robodyn.errors import MeshError
from robodyn.support.floats import first_largest


def test_box_has_three_exact_planes_through_its_centre():
    planes = found(samples.moved(samples.box((1, 2, 3)), (5, 7, 9))).planes
    assert verdicts(planes) == ["exact"] * 3
    assert max(plane.asymmetry for plane in planes) <= 1e-14
    normals = np.array([plane.normal for plane in planes])
    np.testing.assert_allclose(np.abs(normals).sum(axis=0), 1.0, atol=1e-14)
    np.testing.assert_allclose([plane.offset for plane in planes], normals @ (5, 7, 9), rtol=1e-14)


def test_cube_has_nine_planes():
    planes = found(samples.box()).planes
    assert verdicts(planes) == ["exact"] * 9
    directions = np.sort([np.round(np.abs(plane.normal) * 2**0.5, 9) ** 2 for plane in planes], axis=1)
    assert sorted(map(tuple, directions.round(6))) == sorted([(0, 0, 2)] * 3 + [(0, 1, 1)] * 6)


@pytest.mark.parametrize("sectors", [3, 4, 5, 6, 7, 8])
def test_prism_on_a_regular_polygon_has_a_plane_for_each_corner_and_one_across(sectors):
    body = samples.cylinder(height=3.0, sectors=sectors)
    assert verdicts(found(body).planes) == ["exact"] * (sectors + 1)


def test_angle_bracket_has_one_plane():
    planes = found(bracket()).planes
    assert verdicts(planes) == ["exact", "none", "none"]
    np.testing.assert_allclose(np.abs(planes[0].normal), (0, 0, 1), atol=1e-14)


def test_tetrahedron_of_three_different_legs_has_none():
    planes = found(samples.tetrahedron()).planes
    assert verdicts(planes) == ["none"] * 3
    assert min(plane.asymmetry for plane in planes) > 0.3


@pytest.mark.parametrize("seed", range(4))
def test_pose_does_not_matter(seed):
    body = samples.moved(bracket(), (100.0, -300.0, 50.0), any_rotation(seed))
    planes = found(body).planes
    assert verdicts(planes) == ["exact", "none", "none"]
    np.testing.assert_allclose(np.abs(planes[0].normal @ any_rotation(seed)), (0, 0, 1), atol=1e-11)


def test_winding_and_scale_do_not_matter():
    body = bracket()
    reference = [plane.asymmetry for plane in found(body).planes]
    for other in (samples.flipped(body), body * 2.0**-20, body * 2.0**20):
        assert [plane.asymmetry for plane in found(other).planes] == pytest.approx(reference, rel=1e-9, abs=1e-14)


def test_float32_file_is_exact_within_the_tolerance():
    body = samples.moved(bracket(), (0.1, 0.2, 0.3), any_rotation(1)).astype(np.float32)
    assert found(body).planes[0].verdict == "exact"
    assert 0 < found(body).planes[0].asymmetry < 1e-6


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


def test_no_volume_is_an_error():
    with pytest.raises(MeshError, match="no volume"):
        found(samples.sheet())


@pytest.mark.parametrize("body", [samples.box((1, 2, 3)), samples.box(), samples.cylinder(height=3.0, sectors=5)])
def test_normals_and_axes_point_to_their_largest_component(body):
    """The first of ties: whichever sign an eigenvector or an angle came with."""
    symmetry = found(samples.moved(body, (1.0, 2.0, 3.0), any_rotation(3)))
    listed = [*(plane.normal for plane in symmetry.planes), *(axis.direction for axis in symmetry.axes)]
    listed += [plane.normal for plane in found(body).planes]
    assert len(listed) > 3
    assert all(line[first_largest(np.abs(line))] > 0 for line in listed)
