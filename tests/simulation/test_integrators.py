"""Every method: its order, what it keeps, and that machine code and NumPy do the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.oracles import robot
from helpers.sampled import sampled
from helpers.simulated_robots import pendulum, tumbling

import robodyn
from robodyn.errors import InputError
from robodyn.scene.scene import Scene
from robodyn.simulation.methods import METHODS

FIXED = [method for method in METHODS if not method.adaptive and not method.leapfrog]
ADAPTIVE = [method for method in METHODS if method.adaptive]


@pytest.fixture(scope="module")
def settled():
    model, scene = tumbling()
    found = robodyn.simulate(model, scene, 0.5, rtol=1e-13)
    return np.array([*found.q[-1], *found.qd[-1], found.work[-1]])


@pytest.mark.parametrize("method", sampled(FIXED, 2), ids=lambda method: method.name)
def test_order(method, settled):
    model, scene = tumbling()
    errors = []
    for steps in {"gauss4": (16, 32), "gauss6": (8, 16)}.get(method.name, (128, 256)):
        found = robodyn.simulate(model, scene, 0.5, method=method.name, step=0.5 / steps, executor="compiled")
        assert found.steps == steps
        errors.append(np.abs([*found.q[-1], *found.qd[-1], found.work[-1]] - settled).max())
    assert abs(np.log2(errors[0] / errors[1]) - method.order) <= 0.15
    assert errors[1] <= 0.05


@pytest.mark.slow
@pytest.mark.parametrize("method", [method for method in FIXED if method.implicit], ids=lambda method: method.name)
def test_sweeps_are_counted(method):
    """One of each step where nothing pushes; else some, as many in machine code as by NumPy but for rounding."""
    stages = len(method.b)
    model, scene = tumbling()
    at_rest = replace(scene, gravity=(0, 0, 0), initial_qd={}, wrenches=(), drive={})
    for executor in ("compiled", "numpy"):
        found = robodyn.simulate(model, at_rest, 0.1, method=method.name, step=0.01, executor=executor)
        assert found.evaluations == 10 * stages
    counts = [
        robodyn.simulate(model, scene, 0.1, method=method.name, step=1e-3, executor=executor).evaluations
        for executor in ("compiled", "numpy")
    ]
    assert 3 * 100 * stages <= min(counts) <= max(counts) <= 20 * 100 * stages
    assert max(counts) <= 1.05 * min(counts)


@pytest.mark.parametrize("method", ADAPTIVE, ids=lambda method: method.name)
def test_tolerance(method, settled):
    model, scene = tumbling()
    for rtol in (1e-6, 1e-9):
        found = robodyn.simulate(model, scene, 0.5, method=method.name, rtol=rtol)
        assert np.abs([*found.q[-1], *found.qd[-1], found.work[-1]] - settled).max() <= 100 * rtol


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_tables_are_consistent(method):
    if method.adaptive:
        assert not method.A
        return
    A, b = np.array(method.A), np.array(method.b)
    c = A.sum(axis=1)
    for k in range(min(method.order, 4)):
        assert abs(b @ c**k - 1 / (k + 1)) <= 1e-15


@pytest.mark.parametrize("name", ["gauss2", "gauss4", "gauss6"])
def test_energy_of_gauss_methods_does_not_drift(name):
    scene = Scene(initial_q={"j1": 0.8})
    found = robodyn.simulate(pendulum(masses=2), scene, 400.0, method=name, step=0.02)
    error = np.abs(found.figures.energy - found.figures.energy[0])
    halves = [part.max() for part in np.array_split(error, 2)]
    assert halves[1] <= 1.3 * halves[0]
    assert halves[0] <= {"gauss2": 0.5, "gauss4": 5e-3, "gauss6": 1e-4}[name]


def test_energy_of_explicit_methods_drifts_and_the_drift_is_reported():
    scene = Scene(initial_q={"j1": np.pi / 2})
    found = robodyn.simulate(pendulum(masses=2), scene, 400.0, step=0.02)
    error = np.abs(found.figures.energy - found.figures.energy[0])
    assert found.energy_drift == error.max()
    assert error[-1] > 2 * error[len(error) // 2] > 0


@pytest.mark.parametrize("method", sampled(FIXED, 2), ids=lambda method: method.name)
def test_machine_code_and_numpy_agree(method):
    model, scene = tumbling()
    runs = [
        robodyn.simulate(model, scene, 0.03, method=method.name, step=1e-3, executor=executor)
        for executor in ("numpy", "compiled")
    ]
    assert [run.executor for run in runs] == ["numpy", "compiled"]
    first, second = (np.hstack((run.columns, run.work[:, None])) for run in runs)
    assert np.abs(first - second).max() <= 1e-11 * np.abs(first).max()


def test_a_steady_turn_is_exact_at_any_step():
    scene = Scene(gravity=(0, 0, 0), initial_qd={"base_wz": 40.0})
    found = robodyn.simulate(robot("rigid_body"), scene, 5.0, method="euler", step=0.02)
    assert np.abs(found.q[-1, 3:] - [0, 0, np.sin(100), np.cos(100)]).max() <= 1e-12


def test_long_motions_are_recorded_every_few_steps(monkeypatch):
    monkeypatch.setattr("robodyn.simulation.fixed.MOST_RECORDS", 30)
    scene = Scene(initial_q={"j1": 1.0})
    whole, thin = (robodyn.simulate(pendulum(), scene, 0.1, step=1e-3, executor=e) for e in ("numpy", "compiled"))
    monkeypatch.undo()
    full = robodyn.simulate(pendulum(), scene, 0.1, step=1e-3)
    assert (len(thin.time), thin.steps) == (26, 100)
    assert "recorded every 4 steps" in thin.notes
    assert (np.abs(thin.q - full.q[::4]) <= 1e-13).all()
    assert (np.abs(whole.q - full.q[::4]) <= 1e-13).all()


@pytest.mark.parametrize("executor", ["numpy", "compiled"])
def test_sweeps_that_do_not_settle(executor, monkeypatch):
    monkeypatch.setattr("robodyn.programs.run.stepper.SWEEPS", 2)
    with pytest.raises(InputError, match="the steps of gauss4 do not settle at 0 s"):
        robodyn.simulate(pendulum(), Scene(initial_q={"j1": 1.0}), 1.0, method="gauss4", step=0.1, executor=executor)
