"""Every method: its order, what it keeps, over a million steps too, and that machine code and NumPy do the same."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import robot
from helpers.sampled import sampled
from helpers.simulated_robots import pendulum, slide, tumbling

import robodyn
from robodyn.errors import InputError
from robodyn.scene.scene import Drive, ExternalWrench, Friction, Scene, Spring
from robodyn.simulation.methods import METHODS

FIXED = [method for method in METHODS if not method.adaptive and not method.leapfrog]
ADAPTIVE = [method for method in METHODS if method.adaptive]
PULLED = Scene(
    spring={"j1": Spring(20.0, 0.3)},
    drive={"j1": Drive(torque=1.5, kp=4.0, reference=-0.2)},
    wrenches=(ExternalWrench("l1", (0.4, 0.0, 0.7), point=(0.0, 0.0, -1.0), frame="world"),),
    initial_q={"j1": 0.9},
    initial_qd={"j1": 0.5},
)


@pytest.fixture(scope="module")
def settled():
    model, scene = tumbling()
    found = robodyn.simulate(model, scene, 0.25, rtol=1e-13)
    return np.array([*found.q[-1], *found.qd[-1], found.work[-1]])


@pytest.mark.parametrize("method", sampled(FIXED, 5), ids=lambda method: method.name)
def test_order(method, settled):
    model, scene = tumbling()
    errors = []
    for steps in {"gauss4": (8, 16), "gauss6": (4, 8)}.get(method.name, (64, 128)):
        found = robodyn.simulate(model, scene, 0.25, method=method.name, step=0.25 / steps, executor="compiled")
        assert found.steps == steps
        errors.append(np.abs([*found.q[-1], *found.qd[-1], found.work[-1]] - settled).max())
    assert abs(np.log2(errors[0] / errors[1]) - method.order) <= 0.15
    assert errors[1] <= 0.05


@pytest.mark.parametrize("method", ADAPTIVE, ids=lambda method: method.name)
def test_tolerance(method, settled):
    model, scene = tumbling()
    for rtol in (1e-5, 1e-8):
        found = robodyn.simulate(model, scene, 0.25, method=method.name, rtol=rtol)
        assert np.abs([*found.q[-1], *found.qd[-1], found.work[-1]] - settled).max() <= 100 * rtol


def test_energy_of_explicit_methods_drifts_and_the_drift_is_reported():
    scene = Scene(initial_q={"j1": np.pi / 2})
    found = robodyn.simulate(pendulum(masses=2), scene, 400.0, step=0.02)
    error = np.abs(found.figures.energy - found.figures.energy[0])
    assert found.energy_drift == error.max()
    assert error[-1] > 2 * error[len(error) // 2] > 0


REST = [pytest.param(method.name, marks=pytest.mark.slow) for method in FIXED[1:]]


@pytest.mark.parametrize("name", ["euler", "verlet", *REST])
def test_machine_code_and_numpy_agree(name):
    model, scene = (pendulum(), PULLED) if name == "verlet" else tumbling()
    runs = [
        robodyn.simulate(model, scene, 0.03, method=name, step=1e-3, executor=executor)
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
    monkeypatch.setattr("robodyn.simulation.integrate.MOST_RECORDS", 30)
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


def last(found):
    return np.array([found.q[-1, 0], found.qd[-1, 0], found.work[-1]])


def test_order_with_every_force_that_it_can_take():
    settled = last(robodyn.simulate(pendulum(), PULLED, 2.0, method="gauss6", step=2e-3))
    errors = [
        np.abs(last(robodyn.simulate(pendulum(), PULLED, 2.0, method="verlet", step=2.0 / steps)) - settled).max()
        for steps in (256, 512)
    ]
    assert abs(np.log2(errors[0] / errors[1]) - 2) <= 0.05
    assert errors[1] <= 1e-3


def test_a_step_back_undoes_a_step():
    there = robodyn.simulate(pendulum(), PULLED, 1.0, method="verlet", step=0.01)
    turned = Scene(**{**vars(PULLED), "initial_q": {"j1": there.q[-1, 0]}, "initial_qd": {"j1": -there.qd[-1, 0]}})
    back = robodyn.simulate(pendulum(), turned, 1.0, method="verlet", step=0.01)
    assert abs(back.q[-1, 0] - 0.9) <= 1e-12
    assert abs(back.qd[-1, 0] + 0.5) <= 1e-12


def test_energy_is_bounded_over_a_million_steps():
    found = robodyn.simulate(pendulum(), Scene(initial_q={"j1": 2.0}), 10_000.0, method="verlet", step=0.01)
    error = np.abs(found.figures.energy - found.figures.energy[0])
    assert found.steps == 1_000_000
    parts = [part.max() for part in np.array_split(error, 10)]
    assert max(parts) <= 1.05 * parts[0] <= 0.02


REFUSED = {
    "two hinges": (pendulum(masses=2), Scene(), "coriolis"),
    "a free body": (robot("rigid_body"), Scene(moving_base=True), "coriolis"),
    "a drive that damps": (slide(), Scene(drive={"j1": Drive(kd=1.0)}), "drives with kd"),
    "friction": (slide(), Scene(friction={"j1": Friction(1.0, 2.0, -2.0)}), "viscous friction, coulomb friction"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_robots_to_which_it_does_not(name):
    model, scene, causes = REFUSED[name]
    with pytest.raises(InputError) as caught:
        robodyn.simulate(model, scene, 0.01, method="verlet")
    assert caught.value.what == f"verlet does not apply: accelerations depend on speeds ({causes})"
    assert caught.value.remedy == "--method gauss2 keeps energy too, whatever forces there are"


FEW, MANY = 20_000, 1_000_000
LONG = [pytest.param(method, MANY, marks=pytest.mark.slow) for method in ("gauss2", "gauss6")]


@pytest.mark.parametrize(("method", "steps"), [*((method, FEW) for method in ("gauss2", "gauss4", "gauss6")), *LONG])
def test_energy_of_a_double_pendulum(method, steps):
    """A million steps are 20 000 s of some 7000 swings: the largest error of each tenth is that of the first."""
    scene = Scene(initial_q={"j1": 0.8})
    found = robodyn.simulate(pendulum(masses=2), scene, steps * 0.02, method=method, step=0.02)
    assert found.steps == steps
    error = np.abs(found.figures.energy - found.figures.energy[0])
    parts = [part.max() for part in np.array_split(error, 10 if steps == MANY else 2)]
    assert max(parts) <= (1.1 if steps == MANY else 1.3) * parts[0]
    assert parts[0] <= {"gauss2": 4e-4, "gauss4": 2e-7, "gauss6": 2e-10}[method]


@pytest.mark.slow
def test_momenta_of_a_free_robot_over_a_million_steps():
    speeds = {"base_wx": 0.1, "base_wy": 0.3, "base_wz": -0.05, "base_vx": 0.2, "left_array": 0.05}
    scene, model = Scene(gravity=(0, 0, 0), initial_qd=speeds, joint_limits="ignore"), robot("satellite", True)
    found = robodyn.simulate(model, scene, MANY * 0.02, method="rk4-momenta", step=0.02)
    assert found.steps == MANY
    linear, angular = found.momentum_drift
    assert linear <= 1e-14 * np.abs(found.figures.linear).max()
    assert angular <= 1e-14 * np.abs(found.figures.angular).max()
