from math import pi, sin

import mesh_samples as samples
import pytest
from symmetric_bodies import any_rotation

from robodyn.mesh.facets import facet_volume
from robodyn.mesh.integrate import integrate
from robodyn.mesh.load import from_array


@pytest.mark.parametrize("sectors", [16, 64, 256])
def test_prism_lacks_what_its_polygon_does_of_the_circle(sectors):
    lacking = (pi - sectors / 2 * sin(2 * pi / sectors)) * 3.0
    assert facet_volume(samples.cylinder(1.0, 3.0, sectors)) == pytest.approx(lacking, rel=8 / sectors**2 * 5)


def test_ball_lacks_what_its_facets_cut_off():
    body = samples.uv_sphere(rings=32, sectors=64)
    lacking = 4 / 3 * pi - integrate(from_array(body)).volume
    assert facet_volume(body) == pytest.approx(lacking, rel=0.1)


def test_inner_and_outer_facets_of_a_torus_add_up():
    body = samples.torus(2.0, 0.5, 128, 64)
    assert facet_volume(body) > 2 * pi**2 * 2 * 0.25 - integrate(from_array(body)).volume > 0


def test_sharp_bodies_stand_for_themselves():
    for body in (samples.box(), samples.cylinder(sectors=6), samples.tetrahedron()):
        assert facet_volume(samples.moved(body, R=any_rotation(1))) == 0.0
