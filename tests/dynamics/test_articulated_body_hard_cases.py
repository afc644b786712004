"""Forward dynamics of long chains, heavy and light tips, wide scales: the torques of the accelerations are the torques.

What is asked is the residual, not qdd: an error in qdd is larger by cond(M), whatever the algorithm.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from helpers.oracles import EPS, random_state, worst
from helpers.small_robots import built, chain, chain_parts, link, random_tree

from robodyn.dynamics.forward import forward_dynamics
from robodyn.dynamics.inverse import bias_forces, inverse_dynamics
from robodyn.dynamics.mass import mass_matrix
from robodyn.scene.scene import Scene

SAMPLES = 10


def _residuals(model, seed, solve=forward_dynamics):
    """Of torques of a motion, normwise; of any torques, of the largest entry of |M| |qdd| + |bias| + |tau|."""
    q, qd, given = random_state(model, np.random.default_rng(seed), SAMPLES)
    tau = inverse_dynamics(model, q, qd, given)
    back = inverse_dynamics(model, q, qd, solve(model, q, qd, tau))
    M, bias = mass_matrix(model, q), bias_forces(model, q, qd)
    qdd = solve(model, q, qd, given)
    called_for = (np.abs(M) @ np.abs(qdd)[..., None])[..., 0] + np.abs(bias) + np.abs(given)
    off = np.abs(inverse_dynamics(model, q, qd, qdd) - given)
    return worst(back, tau), (off.max(axis=1) / called_for.max(axis=1)).max()


LONG = [pytest.param(100, skew, marks=pytest.mark.slow) for skew in (False, True)]


@pytest.mark.parametrize(("n", "skew"), [(2, False), (10, False), (2, True), (30, True), *LONG])
def test_chains(n, skew):
    assert max(_residuals(chain(n, skew), n)) <= 1e-14


@pytest.mark.slow
def test_a_hundred_joints_of_every_kind():
    assert max(_residuals(random_tree(40, 100, branching=3), 41)) <= 1e-14


def _with_tip(n, skew, ratio):
    """A chain of equal links, the last of which is `ratio` times as heavy."""
    parts = chain_parts(n, skew)
    moments = (ratio / 400, 0, 0, ratio * 1.015 / 12, 0, ratio * 1.015 / 12)
    parts[-2] = link(f"l{n}", ratio, (0.5, 0, 0), moments)
    return built(*parts)


RATIOS = [1e-12, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9, 1e12]
LONG = [pytest.param(100, False, ratio, marks=pytest.mark.slow) for ratio in (1e-12, 1e12)]


@pytest.mark.parametrize(("n", "skew", "ratio"), [*product((2, 10), (False, True), RATIOS), *LONG, (30, True, 1e12)])
def test_tips(n, skew, ratio):
    assert max(_residuals(_with_tip(n, skew, ratio), n)) <= 1e-14


@pytest.mark.parametrize("taper", [10.0**-1.5, 10.0**1.5])
@pytest.mark.parametrize("skew", [False, True], ids=["planar", "skew"])
def test_tapering_chains(taper, skew):
    """Twelve decades from the first of nine links to the last."""
    assert max(_residuals(chain(9, skew, taper=taper), 42)) <= 1e-14


def test_a_straight_chain_moves_as_well_as_a_bent_one():
    model = chain(30)
    tau = np.random.default_rng(2).uniform(-3, 3, (SAMPLES, model.n))
    qdd = forward_dynamics(model, np.zeros_like(tau), 0.0, tau)
    called_for = (np.abs(mass_matrix(model, np.zeros(model.n))) @ np.abs(qdd.T)).max()
    assert worst(inverse_dynamics(model, 0 * tau, 0.0, qdd), tau, called_for) <= 1e-14


@pytest.mark.parametrize("scale", [1e-75, 1e-8, 1e8, 1e75])
def test_scales_of_torque(scale):
    """At rest without gravity qdd is linear in tau."""
    model, weightless = random_tree(43), Scene(gravity=(0.0, 0.0, 0.0), friction={})
    q, _, tau = random_state(model, np.random.default_rng(44), 10)
    qdd = forward_dynamics(model, q, 0.0, tau, scene=weightless)
    assert worst(forward_dynamics(model, q, 0.0, scale * tau, scene=weightless) / scale, qdd) <= 64 * EPS


def test_single_precision():
    model = random_tree(45, 6)
    q, qd, tau = random_state(model, np.random.default_rng(46), 100)
    exact = forward_dynamics(model, q, qd, tau)
    found = forward_dynamics(model, q, qd, tau, dtype=np.float32)
    assert found.dtype == np.float32
    assert 1e-9 < worst(found, exact) <= np.finfo(np.float32).eps * np.linalg.cond(mass_matrix(model, q)).max()
