"""What is kept over a million steps: energy by the methods that keep it, momenta of free robots."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import robot
from helpers.simulated_robots import pendulum

import robodyn
from robodyn.scene.scene import Scene

STEPS = 1_000_000
BOUNDS = {"gauss2": 4e-4, "gauss4": 2e-7, "gauss6": 2e-10}


@pytest.mark.parametrize(
    "method", ["gauss2", pytest.param("gauss4", marks=pytest.mark.slow), pytest.param("gauss6", marks=pytest.mark.slow)]
)
def test_energy_of_a_double_pendulum(method):
    """20 000 s of some 7000 swings: the largest error of each tenth is that of the first."""
    scene = Scene(initial_q={"j1": 0.8})
    found = robodyn.simulate(pendulum(masses=2), scene, STEPS * 0.02, method=method, step=0.02)
    assert found.steps == STEPS
    error = np.abs(found.figures.energy - found.figures.energy[0])
    parts = [part.max() for part in np.array_split(error, 10)]
    assert max(parts) <= 1.1 * parts[0]
    assert parts[0] <= BOUNDS[method]


FLOATING = {
    "rigid_body": {"base_wx": 1e-3, "base_wy": 1.0, "base_wz": 1e-3},
    "satellite": {"base_wx": 0.1, "base_wy": 0.3, "base_wz": -0.05, "base_vx": 0.2, "left_array": 0.05},
}


SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    ("method", "name"),
    [
        ("rk4-momenta", "rigid_body"),
        *(pytest.param(*case, marks=SLOW) for case in [("rk4-momenta", "satellite"), ("gauss6", "satellite")]),
        pytest.param("gauss6", "rigid_body", marks=SLOW),
    ],
)
def test_momenta_of_free_robots(method, name):
    scene = Scene(gravity=(0, 0, 0), initial_qd=FLOATING[name], joint_limits="ignore")
    found = robodyn.simulate(
        robot(name, moving_base=name == "satellite"), scene, STEPS * 0.02, method=method, step=0.02
    )
    assert found.steps == STEPS
    linear, angular = found.momentum_drift
    assert linear <= 1e-12 * max(np.abs(found.figures.linear).max(), 1e-300)
    assert angular <= 1e-12 * np.abs(found.figures.angular).max()
