"""Second derivatives of torques against differences with 100 digits and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import EVERY_EFFECT, busy_robot
from helpers.exact_rates import exact_rates
from helpers.oracles import EPS, ROBOTS, frictionless, random_state, robot, tangent, worst

import robodyn
from robodyn.dynamics.derivatives import inverse_derivatives
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.scene.scene import Scene


def exact(model, state, scene, columns):
    """The four tensors, by differences of the program of first derivatives."""
    names = ("q", "qd", "qdd")
    sources = {**dict(zip(names, state, strict=True)), "columns": np.column_stack([*columns.values(), state[1][:, :0]])}
    n, program = model.n, inverse_derivatives(Plan(model, scene))
    ways = [*tangent(model, state[0]), *({("qd", i): 1} for i in range(n))]
    rates = exact_rates(program, ways, sources).astype(float).reshape(-1, 3, n, n, 2, n)
    by_q, by_qd = rates[..., 0, :], rates[..., 1, :]
    return by_q[:, 0], by_q[:, 1], by_qd[:, 1], by_q[:, 2]


def twice(model, state, scene, columns, **options):
    return robodyn.inverse_dynamics_second_derivatives(model, *state, scene=scene, columns=columns, **options)


@pytest.mark.slow
def test_every_effect():
    model, rng = busy_robot(), np.random.default_rng(8)
    state, columns = random_state(model, rng, 1), {name: rng.uniform(-1, 1, 1) for name in EVERY_EFFECT.columns}
    found = twice(model, state, EVERY_EFFECT, columns, executor="numpy")
    assert max(map(worst, found, exact(model, state, EVERY_EFFECT, columns))) <= 1e-14
    assert worst(found.q_q, np.swapaxes(found.q_q, -1, -2)) <= 1e-14


def test_a_free_base():
    """A pendulum that hangs from a body that turns: turns do not commute, and the order is that of the indices."""
    model, rng = robot("double_pendulum", moving_base=True), np.random.default_rng(4)
    state = random_state(model, rng, 1)
    found = twice(model, state, Scene(), {}, executor="numpy")
    assert max(map(worst, found, exact(model, state, Scene(), {}))) <= 1e-14


@pytest.mark.parametrize("executor", ["numpy", "compiled"])
def test_an_arm(executor):
    """d^2 tau / dqd dqd is twice Christoffel's symbols, which follow from dM / dq alone."""
    model, rng = robot("two_link_spatial"), np.random.default_rng(9)
    state, scene = random_state(model, rng, 2), frictionless(model)
    found = twice(model, state, scene, {}, executor=executor)
    dM = found.qdd_q
    symbols = (dM + np.swapaxes(dM, -1, -2) - np.moveaxis(dM, -1, -3)) / 2
    assert worst(found.qd_qd, 2 * symbols, 2 * np.abs(dM).max()) <= 16 * EPS
    assert worst(found.q_q, exact(model, state, scene, {})[0]) <= 1e-13


def test_robots_with_many_joints_are_refused(monkeypatch):
    monkeypatch.setattr("robodyn.dynamics.derivatives.MOST_BEFORE", 10)
    with pytest.raises(InputError, match=r"more than 100000 operations \(those of its first need \d{3}\)"):
        robodyn.inverse_dynamics_second_derivatives(robodyn.load(ROBOTS / "puma.urdf"), np.zeros(3), 0.0, 0.0)
