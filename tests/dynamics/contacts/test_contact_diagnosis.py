"""Slipping, tipping and pulling feet, what is missing, and the least friction, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.stances import base_columns, feet

from robodyn.dynamics.contacts.solve import (
    STRONGEST,
    Problem,
    centre_of_pressure,
    contact_forces,
    friction_used,
    kinds,
    least_friction,
)

UP = np.array((0.0, 0.0, 1.0))
SQUARE = np.array([(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.1, 0.1)])
LENGTH = 0.1


def block(wanted, friction, height=0.0):
    """A block of half width 0.1 m on a floor, with so much force wanted at its mass centre."""
    b = np.zeros((len(wanted), 6))
    b[:, 3:] = wanted
    arms = np.tile(SQUARE - height * UP, (len(wanted), 1, 1))
    return Problem(base_columns(arms, LENGTH), b, np.tile(UP, (4, 1)), np.full(4, friction))


@pytest.mark.parametrize("angle", [0.1, 0.6, 1.2])
def test_a_block_on_a_slope_needs_the_tangent_of_its_angle(angle):
    problem = block([50.0 * np.array((np.sin(angle), 0.0, np.cos(angle)))], 0.01)
    assert kinds(problem, contact_forces(problem)) == ["slip"]
    assert least_friction(problem) == pytest.approx(np.tan(angle), rel=2e-6)


def test_what_a_slipping_block_lacks_is_the_distance_from_the_cone():
    angle, friction = 0.5, 0.2
    problem = block([50.0 * np.array((np.sin(angle), 0.0, np.cos(angle)))], friction)
    left = contact_forces(problem).residual[0]
    assert np.linalg.norm(left[3:]) == pytest.approx(50.0 * np.sin(angle - np.arctan(friction)), rel=1e-5)
    assert np.abs(left[:3]).max() <= 1e-2


def test_a_block_tips_where_the_push_passes_its_edge():
    height, weight = 0.4, 30.0
    pushes = weight * 0.1 / height * np.array((0.5, 1.0 - 1e-6, 1.0 + 1e-6, 2.0))
    problem = block([(push, 0.0, weight) for push in pushes], 5.0, height)
    found = contact_forces(problem)
    assert kinds(problem, found) == ["", "", "tip", "tip"]
    assert least_friction(problem.chosen([3])) is None
    assert least_friction(problem.chosen([0, 1])) == pytest.approx(0.1 / height, rel=1e-5)


def test_feet_that_would_have_to_pull():
    problem = block([(0.0, 0.0, -7.0), (0.0, 0.0, 7.0)], 0.5)
    found = contact_forces(problem)
    assert kinds(problem, found) == ["pull", ""]
    assert found.residual[:, 3:] == pytest.approx(np.array([(0.0, 0.0, -7.0), (0.0, 0.0, 0.0)]), abs=1e-12)


@pytest.mark.parametrize("lean", [0.0, 0.2])
def test_between_walls_only_friction_carries(lean):
    """Walls lean over by `lean`: what is atan(W / 2 h) from the horizontal is `lean` more from the normal."""
    normals = np.array([(np.cos(lean), 0.0, -np.sin(lean)), (-np.cos(lean), 0.0, -np.sin(lean))])
    arms, b = np.array([[(-0.3, 0.0, 0.0), (0.3, 0.0, 0.0)]]), np.array([(0.0, 0.0, 0.0, 0.0, 0.0, 40.0)])
    squeeze = np.sqrt(0.5 * STRONGEST**2 - 0.25)
    expected = np.tan(lean + np.arctan(0.5 / squeeze))
    problem = Problem(base_columns(arms, 0.3), b, normals, np.full(2, 0.5))
    found = contact_forces(problem)
    assert found.feasible.all()
    assert found.f.sum(axis=1)[0] == pytest.approx((0.0, 0.0, 40.0), abs=40e-12)
    across = np.tan(np.arctan(0.5) - lean)  # the least forces are on the edges of the cones
    assert np.abs(found.f[0, :, 0]) == pytest.approx(20.0 / across, rel=1e-9)
    assert least_friction(problem) == pytest.approx(expected, rel=1e-5)


def test_the_least_friction_is_that_of_the_worst_sample():
    problem = feet(3, 5, 2, push=0.2)
    mu = least_friction(problem)
    alone = [least_friction(problem.chosen([k])) for k in range(5)]
    assert mu == pytest.approx(max(alone), rel=1e-5)
    assert least_friction(problem, known=0.5) == 0.5
    assert least_friction(problem.chosen([0]), known=0.5 * alone[0]) == pytest.approx(alone[0], rel=1e-5)


FOOT = np.array([(0.1, 0.05, 0.0), (-0.1, 0.05, 0.0), (-0.1, -0.05, 0.0), (0.1, -0.05, 0.0), (0.02, 0.01, 0.0)])


def test_the_centre_is_the_mean_weighed_by_the_press():
    random = np.random.default_rng(0)
    forces = random.uniform(0.1, 1.0, (50, 5, 3))
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    there = np.array((1.0, 2.0, 3.0))
    where, margin = centre_of_pressure(np.tile(FOOT @ turn.T + there, (50, 1, 1)), turn[:, 2], forces @ turn.T)
    expected = np.einsum("nk,ki->ni", forces[:, :, 2], FOOT) / forces[:, :, 2].sum(axis=1)[:, None]
    assert np.abs((where - there) @ turn - expected).max() <= 1e-13
    sides = np.stack((0.1 - np.abs(expected[:, 0]), 0.05 - np.abs(expected[:, 1])))
    assert margin == pytest.approx(sides.min(axis=0), abs=1e-13)


def test_forces_that_pull_put_it_beyond_an_edge():
    forces = np.outer((0.0, 2.0, 0.0, -1.0, 0.0), UP)[None]
    where, margin = centre_of_pressure(FOOT[None], UP, forces)
    assert where[0] == pytest.approx((-0.3, 0.15, 0.0))
    assert margin == pytest.approx([-0.2])


def test_friction_used():
    forces = np.array([(3.0, 4.0, 10.0), (0.0, 0.0, 10.0), (0.0, 0.0, 0.0)])[:, None]
    assert friction_used(forces, UP, 0.5) == pytest.approx([1.0, 0.0, np.nan], nan_ok=True)
    assert friction_used(forces, UP, 0.0) == pytest.approx([np.inf, 0.0, np.nan], nan_ok=True)
