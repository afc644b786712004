"""Simulated motions against closed forms and references of 30 digits; many at once are the motions one by one."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.oracles import ROBOTS, random_state, reference, robot
from helpers.simulated_robots import pendulum, slide, tumbling

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError
from robodyn.scene.scene import Drive, Friction, Scene, Spring
from robodyn.simulation.equations import Equations, Steps
from robodyn.simulation.methods import method_named
from robodyn.simulation.rollouts import TOGETHER, rollouts

G = 9.81
PERIODS = {float(k): float(v) for k, v in reference("analytic")["pendulum_L1_g9.81"]["T_by_amplitude_deg"].items()}
DOUBLE = reference("double_pendulum")["data"]


@pytest.mark.parametrize("method", ["dop853", "gauss6"])
@pytest.mark.parametrize("degrees", [1, 90, 179])
def test_a_pendulum_hangs_down_after_a_quarter_of_its_period(degrees, method):
    scene, quarter = Scene(initial_q={"j1": np.radians(degrees)}), PERIODS[degrees] / 4
    how = {"rtol": 1e-13} if method == "dop853" else {"step": quarter / 100}
    found = robodyn.simulate(pendulum(), scene, quarter, method=method, **how)
    assert abs(found.q[-1, 0]) <= 1e-11
    speed = -np.sqrt(2 * G * (1 - np.cos(np.radians(degrees))))
    assert abs(found.qd[-1, 0] - speed) <= 1e-11 * abs(speed)


CASES = [
    ("small", (0.1, 0.05), 1e-12),
    ("large(pi/2,0)", (0.5 * np.pi, 0.0), 1e-11),
    ("chaotic(3pi/4,0)", (0.75 * np.pi, 0.0), 1e-9),
]


@pytest.mark.parametrize(("case", "start", "bound"), CASES)
def test_double_pendulum(case, start, bound):
    scene = Scene(initial_q=dict(zip(("j1", "j2"), start, strict=True)))
    found = robodyn.simulate(pendulum(masses=2), scene, 5.0, rtol=1e-13)
    expected = np.array(DOUBLE[case]["5"], dtype=float)
    assert np.abs([*found.q[-1], *found.qd[-1]] - expected).max() <= bound


def test_a_damped_spring():
    m, k, d, t = 2.0, 50.0, 3.0, 1.7
    scene = Scene(friction={"j1": Friction(viscous=d)}, spring={"j1": Spring(k, 0.1)}, initial_q={"j1": 0.3})
    found = robodyn.simulate(slide(m), scene, t, rtol=1e-13)
    decay, w = d / (2 * m), np.sqrt(k / m - (d / (2 * m)) ** 2)
    expected = 0.1 + 0.2 * np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
    assert abs(found.q[-1, 0] - expected) <= 1e-12
    assert found.energy_drift <= 1e-12 * found.figures.energy[0]


def test_friction_without_a_slip_speed_is_given_one_and_the_note_says_so():
    scene = Scene(friction={"j1": Friction(forward=3.0, backward=-2.0)}, initial_qd={"j1": 1.5})
    found = robodyn.simulate(slide(), scene, 0.01)
    assert found.scene.slip_speed == 1e-3
    assert (
        "Coulomb friction is regularised, f qd / sqrt(qd^2 + 0.001^2): up to 3e+03 N m s/rad near rest" in found.notes
    )
    assert not robodyn.simulate(slide(), Scene(), 0.01).notes


TOP = reference("analytic")["heavy_top_steady"]


@pytest.mark.parametrize(
    ("root", "method"), [("precession_slow", "gauss6"), ("precession_fast", "dop853"), ("precession_fast", "rk4")]
)
def test_a_heavy_top_precesses_steadily(root, method):
    """Leaning by 30 degrees, at either root of the quadratic: the lean stays and the precession is uniform."""
    rate, lean = float(TOP[root]), np.radians(TOP["theta_deg"])
    spin = TOP["omega3"] - rate * np.cos(lean)
    scene = Scene(initial_q={"nutation": lean}, initial_qd={"precession": rate, "spin": spin})
    how = {"rtol": 1e-13} if method == "dop853" else {"step": 5e-4}
    found = robodyn.simulate(robot("heavy_top"), scene, 2.0, method=method, **how)
    assert np.abs(found.q[:, 1] - lean).max() <= 1e-10
    assert np.abs(found.q[:, 0] - rate * found.time).max() <= 1e-9
    assert np.abs(found.q[:, 2] - spin * found.time).max() <= 1e-9


REFERENCE = Path(__file__).parents[1] / "data" / "reference" / "analytic.json"
BAR = 1e-3


def exact(last):
    """Rows of t, x, z at whole multiples of 10 s."""
    rows = np.array(json.loads(REFERENCE.read_text())["A01_pendulum_exact"]["rows"], dtype=float)
    return [row[:3] for row in rows if row[0] > 0 and row[0] % 10 == 0 and row[0] <= last]


@pytest.mark.parametrize(
    ("method", "step", "last"), [("rk4", 1e-2, 100), ("rk4", 1 / 120, 2000), ("gauss6", 0.1, 2000)]
)
def test_within_a_millimetre(method, step, last):
    scene = robodyn.load_scene(ROBOTS / "pendulum_a01.toml")
    result = robodyn.simulate(robot("pendulum"), scene, float(last), step=step, method=method)
    rows = exact(last)
    assert len(rows) == {100: 2, 2000: 4}[last]
    for t, *place in rows:
        k = np.argmin(np.abs(result.time - t))
        assert result.time[k] == pytest.approx(t, rel=1e-12)
        q = result.q[k, 0]
        assert np.hypot(np.cos(q) - place[0], np.sin(q) - place[1]) <= BAR


@pytest.mark.parametrize(
    ("count", "executor"), [(8, "compiled"), pytest.param(TOGETHER + 5, "numpy", marks=pytest.mark.slow)]
)
def test_each_is_what_it_is_alone(count, executor):
    model, scene = tumbling()
    q, qd, _ = random_state(model, np.random.default_rng(3), count)
    found = rollouts(model, q, qd, 10, 1e-3, every=5, scene=scene, executor=executor)
    assert found.q.shape == (3, count, model.nq)
    assert (found.time == np.arange(3) * (5 * 1e-3)).all()
    for k in {0, count // 2, count - 1}:
        alone = rollouts(model, q[k : k + 1], qd[k : k + 1], 10, 1e-3, every=5, scene=scene, executor=executor)
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
