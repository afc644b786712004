"""Forward dynamics undoes inverse dynamics, whatever the scene, masses and torques; what a sample costs."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, EVERY_EFFECT, busy_robot
from helpers.example_robots import real
from helpers.oracles import EPS, frictionless, random_state, robot, worst
from helpers.small_robots import random_tree

import robodyn
from robodyn.dynamics.forward import acceleration_program, forward_dynamics
from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.scene.scene import Scene


@pytest.mark.parametrize("moving_base", [False, True])
@pytest.mark.parametrize(("scene", "times"), [(BUSY_SCENE, 16), (EVERY_EFFECT, 128)], ids=["busy", "motors"])
def test_it_undoes_inverse_dynamics_with_every_effect(moving_base, scene, times):
    model, rng = busy_robot(moving_base), np.random.default_rng(1)
    q, qd, qdd = random_state(model, rng, 20)
    more = {"scene": scene, "columns": {name: rng.normal(size=20) for name in scene.columns}}
    tau = inverse_dynamics(model, q, qd, qdd, **more)
    cond = np.linalg.cond(mass_matrix(model, q, scene=scene)).max()
    assert worst(robodyn.forward_dynamics(model, q, qd, tau, **more), qdd) <= times * EPS * cond
    assert worst(inverse_dynamics(model, q, qd, forward_dynamics(model, q, qd, tau, **more), **more), tau) <= 1e-14


BOUNDS = {"ur5_robot": (691, 1174), "anymal": (1674, 3896)}
"""With a fixed base and a free one."""


@pytest.mark.parametrize("name", BOUNDS)
def test_upper_bounds_of_operations(name):
    for free, bound in enumerate(BOUNDS[name]):
        model = real(name, bool(free))
        assert acceleration_program(Plan(model, frictionless(model))).size <= bound


def _size(model, zero_columns=frozenset(), **scene):
    bare = frictionless(model)
    friction = {**bare.friction, **scene.pop("friction", {})}
    return acceleration_program(Plan(model, Scene(friction=friction, **scene), zero_columns)).size


def test_rest_weightlessness_and_no_torque_are_cheaper():
    model = robot("scara")
    names = {source: frozenset((source, i) for i in range(3)) for source in ("qd", "tau")}
    weightless = {"gravity": (0.0, 0.0, 0.0)}
    assert _size(model, names["qd"]) < _size(model)
    assert _size(model, names["tau"]) < _size(model)
    assert _size(model, **weightless) < _size(model)
    assert _size(model, names["qd"] | names["tau"], **weightless) == 0


@pytest.mark.parametrize("scale", [1e-75, 1e75])
def test_scales_of_torque(scale):
    """At rest without gravity qdd is linear in tau."""
    model, weightless = random_tree(43), Scene(gravity=(0.0, 0.0, 0.0), friction={})
    q, _, tau = random_state(model, np.random.default_rng(44), 10)
    qdd = forward_dynamics(model, q, 0.0, tau, scene=weightless)
    assert worst(forward_dynamics(model, q, 0.0, scale * tau, scene=weightless) / scale, qdd) <= 64 * EPS
