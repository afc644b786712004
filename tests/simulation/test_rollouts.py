"""Many motions at once are the motions one by one, and what a step of them costs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.oracles import random_state, robot
from helpers.simulated_robots import pendulum, tumbling

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError
from robodyn.scene.scene import Drive, Scene, Spring
from robodyn.simulation.equations import Equations, Steps
from robodyn.simulation.methods import method_named
from robodyn.simulation.rollouts import TOGETHER, rollouts


@pytest.mark.parametrize(("count", "executor"), [(8, "compiled"), (TOGETHER + 5, "numpy")])
def test_each_is_what_it_is_alone(count, executor):
    model, scene = tumbling()
    q, qd, _ = random_state(model, np.random.default_rng(3), count)
    found = rollouts(model, q, qd, 20, 1e-3, every=5, scene=scene, executor=executor)
    assert found.q.shape == (5, count, model.nq)
    assert (found.time == np.arange(5) * (5 * 1e-3)).all()
    for k in {0, count // 2, count - 1}:
        alone = rollouts(model, q[k : k + 1], qd[k : k + 1], 20, 1e-3, every=5, scene=scene, executor=executor)
        assert (found.q[:, k] == alone.q[:, 0]).all()
        assert (found.qd[:, k] == alone.qd[:, 0]).all()
        assert (found.work[:, k] == alone.work[:, 0]).all()


@pytest.mark.parametrize("method", ["rk4", "symplectic-euler", "gauss4"])
def test_a_rollout_is_a_simulation(method):
    model = robot("two_link_planar")
    scene = Scene(initial_q={"shoulder": 0.4}, initial_qd={"elbow": 1.0})
    alone = robodyn.simulate(model, scene, 0.1, step=1e-3, method=method)
    found = rollouts(model, [[0.4, 0.0]], [[0.0, 1.0]], 100, 1e-3, method=method)
    assert np.abs(found.q[:, 0] - alone.q).max() <= 1e-13
    assert np.abs(found.work[:, 0] - alone.work).max() <= 1e-13


def test_threads_change_nothing():
    model = pendulum(masses=2)
    q = np.random.default_rng(1).uniform(-3, 3, (300, 2))
    one, two = (rollouts(model, q, 0 * q, 50, 1e-3, executor="compiled", threads=k) for k in (1, 2))
    assert (one.q == two.q).all()


@pytest.mark.parametrize(
    ("how", "what"),
    [
        ({"method": "dop853"}, "10 steps of 0.01 s by dop853"),
        ({"every": 3}, "10 steps of 0.01 s by rk4, recorded every 3"),
        ({"q": np.zeros((2, 2, 2))}, r"the initial states have shape \(2, 2\)"),
        ({"q": np.full((3, 2), np.nan)}, "a motion of rows 0 to 2 cannot be followed"),
    ],
)
def test_what_does_not_fit(how, what):
    with pytest.raises(InputError, match=what):
        rollouts(**{"model": pendulum(masses=2), "q": np.zeros((2, 2)), "qd": 0.0, "steps": 10, "step": 0.01} | how)


def test_without_a_compiler(monkeypatch):
    monkeypatch.setattr("robodyn.simulation.integrate.compiler_problem", lambda: "llvmlite is not installed")
    scene = Scene(initial_q={"j1": 1.0})
    assert robodyn.simulate(pendulum(), scene, 1.0, step=2e-3).executor == "numpy"
    with pytest.raises(InputError, match="the compiled executor cannot run: llvmlite is not installed"):
        robodyn.simulate(pendulum(), scene, 1.0, executor="compiled")
    with pytest.raises(InputError, match="there is no executor 'fast'"):
        robodyn.simulate(pendulum(), scene, 1.0, executor="fast")


def test_a_compiler_that_fails(monkeypatch):
    def failing(*_):
        raise RuntimeError("no\nway")

    monkeypatch.setattr("robodyn.simulation.integrate._compiled", failing)
    assert robodyn.simulate(pendulum(), Scene(), 1.0, step=2e-3).executor == "numpy"
    with pytest.raises(InputError, match=r"LLVM fails on this program \(no\)"):
        robodyn.simulate(pendulum(), Scene(), 1.0, executor="compiled")


BARE = Scene(gravity=(0, 0, 0))
ABSENT = [
    replace(BARE, spring={"elbow": Spring(0.0, 0.1)}),
    replace(BARE, drive={"elbow": Drive(reference=1.0, speed=2.0)}),
    replace(BARE, joint_limits="stop"),
    replace(BARE, joint_limits="ignore", initial_q={"elbow": 1.0}, initial_qd={"elbow": 1.0}),
]


@pytest.mark.parametrize("method", ["gauss4", "rk4"])
def test_what_is_absent_costs_nothing(method):
    def programs(scene):
        steps = Steps(Equations(plan(robot("two_link_planar"), scene)), method_named(method))
        return steps.step, steps.sweep

    bare = programs(BARE)
    assert all(programs(scene) == bare for scene in ABSENT)
