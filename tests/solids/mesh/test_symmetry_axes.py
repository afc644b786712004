from math import inf, pi

import numpy as np
import pytest
from helpers import mesh_samples as samples
from helpers.symmetric_bodies import any_rotation, bracket, found, pinwheel


def listed(corners):
    return [(axis.fold, axis.verdict) for axis in found(corners).axes]


def test_box_has_three_axes_of_half_turns():
    assert listed(samples.box((1, 2, 3))) == [(2, "exact")] * 3


def test_cube_has_thirteen_axes():
    assert sorted(listed(samples.box())) == [(2, "exact")] * 6 + [(3, "exact")] * 4 + [(4, "exact")] * 3


@pytest.mark.parametrize("sectors", [3, 4, 5, 6, 7, 8])
def test_prism_has_the_fold_of_its_polygon_and_is_not_round(sectors):
    assert listed(samples.cylinder(height=3.0, sectors=sectors)) == [(sectors, "exact")] + [(2.0, "exact")] * sectors


@pytest.mark.parametrize("sectors", [24, 32, 77, 256])
@pytest.mark.parametrize("body", [samples.cylinder, samples.cone])
def test_facets_of_a_round_body_are_told_from_it(body, sectors):
    axes = found(body(height=3.0, sectors=sectors)).axes
    assert [(axis.fold, axis.verdict) for axis in axes] == [(sectors, "exact"), (inf, "within tessellation")]
    facets = (2 * pi / sectors) ** 2 / 6
    assert 0.1 * facets < axes[1].asymmetry < facets


def test_torus_is_round():
    body = samples.moved(samples.torus(rings=40), (10, -20, 5), any_rotation(3))
    axes = found(body).axes
    assert [(axis.fold, axis.verdict) for axis in axes] == [(40, "exact"), (inf, "within tessellation")]
    for axis in axes:
        np.testing.assert_allclose(np.abs(any_rotation(3).T @ axis.direction), (0, 0, 1), atol=1e-10)
        np.testing.assert_allclose(axis.point, (10, -20, 5), rtol=1e-13)


def test_ball_is_round_about_two_axes():
    axes = found(samples.uv_sphere(rings=24, sectors=48)).axes
    assert [axis.fold for axis in axes] == [48, inf, inf]
    assert [axis.verdict for axis in axes] == ["exact", "within tessellation", "within tessellation"]


def test_bracket_and_tetrahedron_have_no_axis():
    assert listed(bracket()) == []
    assert listed(samples.tetrahedron()) == []


def test_pinwheel_has_an_axis_and_only_the_plane_across():
    assert listed(pinwheel()) == [(3, "exact")]
    (plane,) = [plane for plane in found(pinwheel()).planes if plane.verdict != "none"]
    np.testing.assert_allclose(np.abs(plane.normal), (0, 0, 1), atol=1e-14)


def test_half_turn_without_planes():
    one = samples.moved(samples.box((1.0, 0.5, 0.3)), (0.2, 1.0, 1.0), any_rotation(7))
    other = samples.moved(one, R=np.diag([1.0, -1.0, -1.0]))
    body = np.concatenate([one, other])
    assert listed(body) == [(2, "exact")]
    assert all(plane.verdict == "none" for plane in found(body).planes)
