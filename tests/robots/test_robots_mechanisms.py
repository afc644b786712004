"""The closed chains of robots/ against their closed forms: loops close, and virtual work balances the open tree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.driven_chains import MIDDLE, moving, still

import robodyn
from robodyn.dynamics.loops.closed_chain import closed_chain
from robodyn.dynamics.plan import plan

EPS = np.finfo(float).eps
g = 9.81


@pytest.mark.parametrize("name", MIDDLE)
def test_the_loops_close_with_their_rates(name):
    chain = moving(name)
    closed = closed_chain(plan(chain.model, chain.scene))
    for q, qd, qdd in zip(*chain.state, strict=True):
        sample = closed.sample(tuple(q), tuple(qd))
        here, J = closed.equations(sample), closed.jacobian(sample)
        largest = np.abs(J * qdd).max() + np.abs(qd).max() ** 2
        assert np.abs(here.error).max() <= 10 * EPS
        assert np.abs(here.rate).max() <= 50 * EPS * np.abs(J * qd).max()
        assert np.abs(J @ qdd + here.bias).max() <= 100 * EPS * largest


@pytest.mark.parametrize("name", MIDDLE)
def test_every_loop_of_a_mechanism_leaves_its_motors(name):
    chain = still(name, 1)
    closed = closed_chain(plan(chain.model, chain.scene))
    assert chain.model.n - closed.count == len(chain.u) == len(chain.scene.actuated)
    assert set(chain.scene.actuated) == set(chain.place.motors)


def balance(chain):
    """(samples, n) of `S tau + J' lambda = RNEA` solved densely."""
    tree = replace(chain.scene, loops=(), actuated=None)
    open_torques = robodyn.inverse_dynamics(chain.model, *chain.state, scene=tree)
    closed = closed_chain(plan(chain.model, chain.scene))
    driven = [chain.model.joint_names.index(name) for name in chain.scene.actuated]
    found = np.zeros_like(open_torques)
    for k, (q, right) in enumerate(zip(chain.state[0], open_torques, strict=True)):
        J = closed.jacobian(closed.sample(tuple(q)))
        left = np.column_stack([np.eye(chain.model.n)[:, driven], J.T])
        found[k, driven] = np.linalg.solve(left, right)[: len(driven)]
    return found


@pytest.mark.parametrize("make", [still, moving])
@pytest.mark.parametrize("name", MIDDLE)
def test_virtual_work_is_the_balance_of_the_open_tree(name, make):
    chain = make(name)
    bound = 2e-14 * np.abs(chain.torques).max()
    np.testing.assert_allclose(balance(chain), chain.torques, rtol=0, atol=bound)


def crank_slider(th):
    """All rates by hand, and the torque by the power of every mass: tau th' = sum of m a . v + I al w + m g z'."""
    r, l, m = 0.1, 0.3, 0.6
    s, c, w, al = np.sin(th.x), np.cos(th.x), th.v, th.a
    level = np.sqrt(l**2 - (r * s) ** 2)
    tilt_1 = -r * c / level
    tilt_2 = r * s / level * (1 - tilt_1**2)
    x_1 = -r * s - r**2 * s * c / level
    x_2 = -r * c - r**2 * (c * c - s * s) / level - r**4 * s**2 * c**2 / level**3
    middle_1, middle_2 = (x_1 - r * s) / 2, (x_2 - r * c) / 2
    z_1, z_2 = r * c / 2, -r * s / 2
    I = m * (3 * 0.012**2 + l**2) / 12
    M = 0.0216 + I * tilt_1**2 + m * (middle_1**2 + z_1**2) + 1.2 * x_1**2
    half_slope = I * tilt_1 * tilt_2 + m * (middle_1 * middle_2 + z_1 * z_2) + 1.2 * x_1 * x_2
    return M * al + half_slope * w**2 + m * g * z_1


def four_bar(th):
    I = 1.5 * (3 * 0.02**2 + 0.3**2) / 12 + 1.5 * 0.15**2
    return (2 * I + 4 * 0.3**2) * th.a - (2 * 1.5 * 0.15 + 4 * 0.3) * g * np.sin(th.x)


@pytest.mark.parametrize(("name", "formula"), [("crank_slider", crank_slider), ("four_bar", four_bar)])
def test_formulas_with_one_coordinate(name, formula):
    chain = moving(name)
    expected = formula(chain.u[0])
    driven = chain.model.joint_names.index(chain.scene.actuated[0])
    np.testing.assert_allclose(chain.torques[:, driven], expected, rtol=0, atol=40 * EPS * np.abs(expected).max())
