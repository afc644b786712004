"""Verlet's method: its order, what it keeps, and the robots to which it does not apply."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import robot
from helpers.simulated_robots import pendulum, slide

import robodyn
from robodyn.errors import InputError
from robodyn.scene.parts import Drive, ExternalWrench, Friction, Spring
from robodyn.scene.scene import Scene

PULLED = Scene(
    spring={"j1": Spring(20.0, 0.3)},
    drive={"j1": Drive(torque=1.5, kp=4.0, reference=-0.2)},
    wrenches=(ExternalWrench("l1", (0.4, 0.0, 0.7), point=(0.0, 0.0, -1.0), frame="world"),),
    initial_q={"j1": 0.9},
    initial_qd={"j1": 0.5},
)


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


def test_machine_code_and_numpy_agree_on_one_evaluation_per_step():
    first, second = (
        robodyn.simulate(pendulum(), PULLED, 0.1, method="verlet", step=1e-3, executor=executor)
        for executor in ("numpy", "compiled")
    )
    assert np.abs(first.columns - second.columns).max() <= 1e-13 * np.abs(first.columns).max()
    assert first.evaluations == first.steps == 100


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
