"""Meshes fixed to each other as one rigid body."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import mesh_samples

from robodyn.errors import InputError
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.solids.inertia.solids import box
from robodyn.solids.mass_properties import combined, mass_properties

EPS = np.finfo(float).eps
SIZES = ((0.5, 0.25, 0.125), (0.25, 0.25, 1.0))
POSES = (
    (rotation_from_rpy(0.1, 0.2, 0.3), np.array([1.0, 0, 0])),
    (rotation_from_rpy(-0.5, 0, 1), np.array([0, -1.0, 2])),
)


def parts(*densities):
    return [mass_properties(mesh_samples.box(size), density=rho) for size, rho in zip(SIZES, densities, strict=True)]


def close(found, expected):
    assert found.mass == pytest.approx(expected.mass, rel=8 * EPS)
    np.testing.assert_allclose(found.com, expected.com, rtol=0, atol=8 * EPS)
    np.testing.assert_allclose(found.inertia, expected.inertia, rtol=0, atol=16 * EPS * np.abs(expected.inertia).max())


def solids(*densities):
    return [box(*size, density=rho).placed(*pose) for size, rho, pose in zip(SIZES, densities, POSES, strict=True)]


def test_boxes_of_two_densities_at_their_places():
    found = combined(parts(1000, 500), POSES)
    one, other = solids(1000, 500)
    close(found.body, one + other)
    for body, expected in zip(found.placed, (one, other), strict=True):
        close(body, expected)
    assert found.warnings == ()


def test_the_mass_of_the_whole_is_shared_as_the_densities_say():
    found = combined(parts(1000, 500), POSES, mass=2.0)
    one, other = solids(1000, 500)
    close(found.body, (one + other).scaled_to_mass(2.0))
    assert [part.body.mass for part in found.parts] == pytest.approx([2 / 3, 4 / 3], rel=8 * EPS)


def test_without_places_meshes_stay_where_they_are():
    moved = mass_properties(mesh_samples.moved(mesh_samples.box(), (2, 0, 0)), density=1)
    still = mass_properties(mesh_samples.box(), density=1)
    close(combined([still, moved]).body, box(1, 1, 1, density=1) + box(1, 1, 1, density=1).moved(np.array([2.0, 0, 0])))
    assert len(combined([still, still]).warnings) == 1
    found = combined([still, moved]).box
    np.testing.assert_array_equal((found.lo, found.hi), ([-0.5] * 3, [2.5, 0.5, 0.5]))


@pytest.mark.parametrize(("poses", "mass"), [(POSES[:1], None), (POSES, 0.0), (POSES, np.nan), (POSES, np.inf)])
def test_refused(poses, mass):
    with pytest.raises(InputError):
        combined(parts(1, 1), poses, mass)
