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
