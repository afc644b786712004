from math import pi, sin

import numpy as np
import pytest
from helpers import mesh_samples as samples
from helpers.smooth_solids import solids
from helpers.symmetric_bodies import any_rotation, bracket
from helpers.tessellation_errors import case, cases, estimated

from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.read.load import from_array
from robodyn.solids.mesh.tessellation import line_masses

RESOLUTIONS = (12, 16, 24, 48)


@pytest.fixture(scope="module")
def density_cases():
    return list(cases(RESOLUTIONS))


def test_tessellations_are_closed_and_converge_to_the_exact_moments():
    for solid in solids():
        coarse, fine = (integrate(from_array(solid.mesh(n))) for n in (16, 64))
        errors = [abs(found.volume / solid.volume - 1) for found in (coarse, fine)]
        assert errors[1] < errors[0] / 8, solid.name


def test_numbers_are_twenty_times_better_in_the_median_and_none_is_made_worse(density_cases):
    volume, inertia = np.array([one.mesh[:2] / one.corrected[:2] for one in density_cases]).T
    assert min(np.median(volume), np.median(inertia)) >= 20
    assert min(inertia) > 1.5


def test_bars_hold_at_a_given_mass():
    found = list(cases((16, 32), fixed_mass=True))
    for bars in ("mesh", "on_surface"):
        held = [(one.over(getattr(one.found, bars))[:2] <= 1).all() for one in found]
        assert np.mean(held) >= 0.95


def test_bars_are_not_idle(density_cases):
    assert np.median([one.found.mesh.inertia / one.mesh[1] for one in density_cases]) < 1.5
    assert np.median([one.found.on_surface.inertia / one.mesh[1] for one in density_cases]) < 0.4


def test_pose_and_winding_do_not_matter():
    solid = named("tube")
    turned = [case(solid, 24, seed) for seed in range(3)]
    assert [one.corrected[1] for one in turned] == pytest.approx([turned[0].corrected[1]] * 3, rel=1e-6)
    corners = samples.moved(solid.mesh(24), (3.0, -2.0, 1.0), any_rotation(3))
    (given, found), (inwards, other) = estimated(corners), estimated(samples.flipped(corners))
    assert other.corrected.volume == pytest.approx(-found.corrected.volume, rel=1e-13)
    assert abs(found.corrected.volume - given.volume) > 1e-3 * given.volume
    assert inwards.volume == pytest.approx(-given.volume, rel=1e-13)
    for wanted, got in ((found.corrected.first, other.corrected.first), (found.corrected.S, other.corrected.S)):
        np.testing.assert_allclose(got, -wanted, rtol=0, atol=1e-12 * np.abs(found.corrected.S).max())
    assert (other.mesh.inertia, other.rest.inertia) == pytest.approx((found.mesh.inertia, found.rest.inertia), rel=1e-9)


def named(name):
    (solid,) = [solid for solid in solids() if solid.name == name]
    return solid


def test_sharp_bodies_stand_for_themselves():
    for body in (samples.box(), bracket(), samples.cylinder(sectors=5), samples.tetrahedron()):
        integrals, found = estimated(samples.moved(body, (0.1, 0.2, 0.3), any_rotation(1)))
        assert np.array_equal(found.corrected.S, integrals.S)
        assert (found.corrected.volume, found.mesh.volume, found.mesh.inertia) == (integrals.volume, 0, 0)
        assert found.rest == found.mesh


@pytest.mark.parametrize("sectors", [16, 64, 256])
def test_prism_lacks_what_its_polygon_does_of_the_circle(sectors):
    lacking = (pi - sectors / 2 * sin(2 * pi / sectors)) * 3.0
    found = line_masses(samples.cylinder(1.0, 3.0, sectors))
    assert found.size == pytest.approx(lacking, rel=(2 * pi / sectors) ** 2 / 10)
    assert len(found.missing) == sectors


def test_float32_files_are_told_the_same():
    """Flat strips of a rounded box are no longer quite flat, and yet planes that touch its fillets."""
    body = named("box with small fillets").mesh(32)
    placed = samples.moved(body, (0.5, -1.0, 2.0), any_rotation(2)).astype(np.float32).astype(float)
    wanted = line_masses(body)
    found = line_masses(placed)
    assert found.size == pytest.approx(wanted.size, rel=1e-3)
    assert found.doubt.sum() == pytest.approx(wanted.doubt.sum(), rel=1e-3)
