from math import pi, sin

import mesh_samples as samples
import pytest
from symmetric_bodies import any_rotation

from robodyn.mesh.facets import facet_volume


@pytest.mark.parametrize("sectors", [16, 64, 256])
def test_prism_lacks_what_its_polygon_does_of_the_circle(sectors):
    lacking = (pi - sectors / 2 * sin(2 * pi / sectors)) * 3.0
    assert facet_volume(samples.cylinder(1.0, 3.0, sectors)) == pytest.approx(lacking, rel=8 / sectors**2 * 5)


def test_torus():
    body = samples.torus(2.0, 0.5, 128, 64)
    faceted = 2 * pi**2 * 2 * 0.25
    from robodyn.mesh.integrate import integrate
    from robodyn.mesh.load import from_array

    assert facet_volume(body) == pytest.approx(faceted - integrate(from_array(body)).volume, rel=0.15)


def test_sharp_bodies_stand_for_themselves():
    for body in (samples.box(), samples.cylinder(sectors=6), samples.tetrahedron()):
        assert facet_volume(samples.moved(body, R=any_rotation(1))) == 0.0
