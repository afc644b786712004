"""Which mass properties a body can have: bodies of positive masses always, planted faults never, with the slack."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from helpers.mass_clouds import random_cloud
from helpers.oracles import EPS
from hypothesis import example, given
from hypothesis import strategies as st

from robodyn.programs.vectors import ZERO, rotation_from_rpy
from robodyn.solids.inertia.laws import rotation_law
from robodyn.solids.inertia.properties import MassProperties, from_inertia
from robodyn.solids.inertia.solids import box, sphere
from robodyn.solids.inertia.validity import unphysical, validity

TURN = rotation_from_rpy(0.3, 0.5, 0.7)
angles = st.floats(-3, 3)


@given(st.integers(0, 10**6), st.integers(1, 6), st.sampled_from([1.0, 1e-6, 0.0]))
def test_bodies_of_positive_masses_are_physical(seed, points, thickness):
    body = random_cloud(seed, points, (1.0, 1.0, thickness)).properties.rotated(TURN)
    found = validity(body, relative=4 * EPS)
    assert found.faults == ()
    assert found.slack >= (-4 * EPS if thickness == 0 or points < 4 else 0)
    assert unphysical(body.inertia, relative=8 * EPS) is None


@example(0.75, 0.75, 0.03125, 0.0, 1.0, 1.5)  # 1.546875 is half-way between two numbers of six digits
@given(st.floats(0.001, 1), st.floats(0.001, 1), st.floats(1e-5, 1), angles, angles, angles)
def test_what_breaks_the_triangle_inequality_is_found_in_any_axes(one, two, excess, roll, pitch, yaw):
    """Also where the diagonal entries alone obey it."""
    I = rotation_law(np.diag([one, two, (one + two) * (1 + excess)]), rotation_from_rpy(roll, pitch, yaw))
    assert "break the triangle inequality" in unphysical(I)
    (fault,) = validity(from_inertia(1.0, ZERO, I)).faults
    assert fault == unphysical(I)


def test_the_diagonal_alone_does_not_show_it():
    I = rotation_law(np.diag([0.1, 0.2, 0.5]), rotation_from_rpy(np.pi / 4, 0.6, 0))
    diagonal = np.sort(np.diagonal(I))
    assert diagonal[0] + diagonal[1] > diagonal[2]
    assert unphysical(I) == "principal moments 0.1 + 0.2 < 0.5 kg m^2 break the triangle inequality"


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_the_slack_is_relative(scale):
    assert unphysical(np.diag([1, 2, 3.0000029]) * scale) is None
    assert "triangle" in unphysical(np.diag([1, 2, 3.0000031]) * scale)
    assert unphysical(np.diag([1, 2, 3.0000031]) * scale, relative=1e-5) is None
    assert unphysical(np.diag([1, 1, -1e-7]) * scale) is None
    assert "negative" in unphysical(np.diag([1, 1, -1e-5]) * scale)
    for tensor in ([1, 2, 3.0000029], [1, 2, 3.0000031], [1, 1, -1e-7], [1, 1, -1e-5]):
        body = from_inertia(1.0, ZERO, np.diag(tensor) * scale)
        assert bool(validity(body).faults) == bool(unphysical(body.inertia))


def test_tensors_that_are_negative_altogether():
    assert unphysical(np.diag([-1.0, -2.0, -3.0])) == "a principal moment of inertia is negative (-3 kg m^2)"
    assert "negative" in unphysical(np.full((3, 3), -1.0))


def test_tensors_at_the_end_of_the_range():
    assert unphysical(np.diag([1.7e308, 1.7e308, 1.7e308])) is None
    assert "negative (-1.7e+308" in unphysical(np.diag([1.7e308, 1.7e308, -1.7e308]))
    assert unphysical(np.diag([2e-320, 2e-320, 2e-320])) is None


@pytest.mark.parametrize(
    ("body", "slack"),
    [
        (sphere(0.1, mass=2), 1.0),
        (box(1.0, 1.0, 0.0, mass=2), 0.0),
        (box(1.0, 0.0, 0.0, mass=2), 0.0),
        (box(1.0, 1e-6, 1e-6, mass=2), 2e-12 / (1 + 1e-12)),
        (sphere(0.0, mass=2), 0.0),
    ],
)
def test_slack_of_solids(body, slack):
    found = validity(body.rotated(TURN))
    assert found.faults == ()
    assert abs(found.slack - slack) <= 32 * EPS * max(slack, 0.5 if slack == 0 else 0)


@pytest.mark.parametrize("seed", range(30))
def test_slack_against_more_digits(seed):
    rng = np.random.default_rng(seed)
    S = rng.normal(size=(3, 3))
    S = S + S.T if seed % 2 else S @ S.T
    with mpmath.workdps(60):
        small, middle, large = sorted(mpmath.eigsy(mpmath.matrix(S.tolist()), eigvals_only=True))
        moments = small + middle, small + large, middle + large
        expected = 2 * small / max(map(abs, moments))
    bound = 32 * EPS * expected if seed % 2 == 0 else 16 * EPS
    assert abs(validity(MassProperties(1.0, ZERO, S)).slack - expected) <= bound


@pytest.mark.parametrize("mass", [0.0, -2.5])
def test_a_mass_that_is_not_positive(mass):
    found = validity(from_inertia(mass, ZERO, np.eye(3)))
    assert found.faults == (f"the mass is not positive ({mass:g} kg)",)
    assert found.mass == mass


def test_all_faults_are_named():
    found = validity(from_inertia(-1.0, ZERO, np.diag([1.0, 1.0, -1.0])))
    assert [fault.split(" (")[0] for fault in found.faults] == [
        "the mass is not positive",
        "a principal moment of inertia is negative",
    ]
    assert found.slack == -1.0
    np.testing.assert_array_equal(found.moments, [-1.0, 1.0, 1.0])
