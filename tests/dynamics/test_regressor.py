"""The regressor: Y theta and the rest are the torques, and Y does not depend on theta."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import EVERY_EFFECT, busy_robot
from helpers.example_robots import kinds
from helpers.oracles import random_state, robot, worst

import robodyn
from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.errors import SceneError
from robodyn.robot.load import load
from robodyn.scene.scene import Friction, Loop, Payload, Rotor, Scene

SAMPLES = 3
bases = pytest.mark.parametrize("moving_base", [False, True], ids=["fixed", "free"])
COMPILED = pytest.param(False, 0.2, "compiled", marks=pytest.mark.slow)


def error(found, tau):
    """Of Y theta + rest, as a part of the largest term."""
    terms = np.abs(found.Y * found.theta).max(initial=0)
    return worst((found.Y @ found.theta) + found.rest, tau, max(terms, np.abs(tau).max(initial=0)))


@pytest.mark.parametrize(
    ("moving_base", "slip_speed", "executor"), [(False, 0.0, "numpy"), (True, 0.2, "numpy"), COMPILED]
)
def test_every_effect(moving_base, slip_speed, executor):
    model, rng = busy_robot(moving_base), np.random.default_rng(4)
    scene = replace(EVERY_EFFECT, slip_speed=slip_speed)
    state = random_state(model, rng, SAMPLES)
    columns = {name: rng.uniform(-1, 1, SAMPLES) for name in scene.columns}
    expected = robodyn.inverse_dynamics(model, *state, scene=scene, columns=columns)
    found = regressor(model, *state, scene=scene, columns=columns, executor=executor)
    assert found.Y.shape == (SAMPLES, model.n, len(found.names)) == (SAMPLES, model.n, len(found.theta))
    assert error(found, expected) <= 1e-14
    alone = replace(scene, friction={}, rotor={}, payloads=(), gravity=(0.0, 0.0, 0.0))
    assert np.abs(found.rest).max() > 0.1, alone


@bases
@pytest.mark.parametrize("path", kinds())
def test_published_robots(path, moving_base):
    model = load(path, moving_base=moving_base)
    state = random_state(model, np.random.default_rng(len(path.name)), 2)
    found = regressor(model, *state)
    assert not found.rest.any()
    assert error(found, robodyn.inverse_dynamics(model, *state)) <= 1e-13


def test_what_is_linear_stays_so():
    """Another mass, payload, friction and rotor: the same Y, and it makes the new torques too."""
    model, state = robot("puma560"), random_state(robot("puma560"), np.random.default_rng(2), SAMPLES)
    names = model.joint_names
    one = Scene(
        friction=dict.fromkeys(names, Friction(0.1, 0.2, -0.3, 0.5)), rotor=dict.fromkeys(names, Rotor(1e-4, 50.0))
    )
    two = replace(
        one,
        friction=dict.fromkeys(names, Friction(0.7, 0.1, -0.6, 0.9)),
        rotor=dict.fromkeys(names, Rotor(3e-4, 20.0)),
        payloads=(Payload(model.bodies[-1].name, 2.5, (0.1, 0.2, 0.3), (0.1, 0.0, 0.0, 0.2, 0.01, 0.3)),),
    )
    first, second = (regressor(model, *state, scene=scene) for scene in (one, two))
    assert (first.Y == second.Y).all()
    assert first.names == second.names
    assert worst(first.Y @ second.theta, robodyn.inverse_dynamics(model, *state, scene=two)) <= 1e-13
    assert (first.theta != second.theta).sum() == 10 + 5 * len(names)


def test_names():
    found = regressor(robot("pendulum"), [0.3], [0.1], [0.2])
    body, joint = robot("pendulum").bodies[-1].name, robot("pendulum").joint_names[0]
    expected = [f"{body}.{name}" for name in INERTIAL]
    expected += [f"{joint}.{name}" for name in ("viscous", "forward", "backward", "rotor")]
    assert list(found.names[-14:]) == expected
    assert found.theta[found.names.index(f"{body}.m")] == robot("pendulum").bodies[-1].inertia.m


def test_refusals():
    model = busy_robot()
    with pytest.raises(SceneError, match="loop"):
        regressor(model, 0.0, 0.0, 0.0, scene=Scene(loops=(Loop("l", "tool"),)))
