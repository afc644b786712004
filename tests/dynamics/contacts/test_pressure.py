"""Centres of pressure, their margins, and friction used, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.dynamics.contacts.diagnosis import centre_of_pressure, friction_used

FOOT = np.array([(0.1, 0.05, 0.0), (-0.1, 0.05, 0.0), (-0.1, -0.05, 0.0), (0.1, -0.05, 0.0), (0.02, 0.01, 0.0)])
UP = np.array((0.0, 0.0, 1.0))


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


def test_points_have_no_margin_and_feet_in_the_air_no_centre():
    where, margin = centre_of_pressure(FOOT[None, :1], UP, UP[None, None])
    assert where[0] == pytest.approx(FOOT[0])
    assert np.isnan(margin).all()
    assert np.isnan(centre_of_pressure(FOOT[None], UP, np.zeros((1, 5, 3)))[1]).all()


def test_friction_used():
    forces = np.array([(3.0, 4.0, 10.0), (0.0, 0.0, 10.0), (0.0, 0.0, 0.0)])[:, None]
    assert friction_used(forces, UP, 0.5) == pytest.approx([1.0, 0.0, np.nan], nan_ok=True)
    assert friction_used(forces, UP, 0.0) == pytest.approx([np.inf, 0.0, np.nan], nan_ok=True)


def test_points_use_friction_together():
    turning = np.array([[(2.0, 0.0, 30.0), (-2.0, 0.0, 10.0)]])
    assert friction_used(turning, UP, 0.5) == pytest.approx([0.2])
