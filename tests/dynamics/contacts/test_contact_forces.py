"""Contact forces against Clarabel's, the conditions of the optimum, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.stances import stance

from robodyn.dynamics.contacts.conic import conic_forces
from robodyn.dynamics.contacts.diagnosis import base_columns, kinds, least_friction
from robodyn.dynamics.contacts.problem import Problem
from robodyn.dynamics.contacts.solve import contact_forces


@pytest.mark.parametrize("points", [2, 4, 8])
def test_the_cost_is_that_of_clarabel(points):
    problem = stance(points, 60, points)
    ours, theirs = contact_forces(problem), conic_forces(problem)
    assert (ours.feasible == theirs.feasible).all()
    cost = 0.5 * (ours.f**2).sum(axis=(1, 2))[ours.feasible]
    expected = 0.5 * (theirs.f**2).sum(axis=(1, 2))[ours.feasible]
    assert np.abs(cost - expected) == pytest.approx(0.0, abs=1e-8 * expected.max(initial=1.0))


def test_four_feet_carry_a_quarter_each():
    arms = np.array([(x, y, -0.5) for x in (-0.3, 0.3) for y in (-0.2, 0.2)])[None]
    up, b = np.array((0.0, 0.0, 1.0)), np.array([(0.0, 0.0, 0.0, 0.0, 0.0, 100.0)])
    f = contact_forces(Problem(base_columns(arms, 0.3), b, np.tile(up, (4, 1)), np.full(4, 0.5))).f
    assert np.abs(f - 25.0 * up).max() <= 1e-12 * 100.0


@pytest.mark.parametrize("angle", [0.1, 0.6, 1.2])
def test_a_block_on_a_slope_needs_its_tangent(angle):
    """Of points in the plane of the mass centre, as the block is flat."""
    arms = np.array([(0.1, 0.1, 0.0), (-0.1, 0.1, 0.0), (-0.1, -0.1, 0.0), (0.1, -0.1, 0.0)])[None]
    b = 50.0 * np.array([(0.0, 0.0, 0.0, np.sin(angle), 0.0, np.cos(angle))])
    problem = Problem(base_columns(arms, 0.1), b, np.tile((0.0, 0.0, 1.0), (4, 1)), np.full(4, 0.01))
    found = contact_forces(problem)
    assert kinds(problem, found) == ["slip"]
    assert least_friction(problem) == pytest.approx(np.tan(angle), rel=1e-6)
