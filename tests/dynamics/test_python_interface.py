"""The Python interface: shapes, errors, M and b as parts of tau, payload and rotors in M."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.compiled_programs import needs_compiler
from helpers.oracles import random_state, robot, worst

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError
from robodyn.scene.scene import Scene


@pytest.mark.parametrize("moving_base", [False, True])
def test_tau_is_mass_times_acceleration_plus_bias(moving_base):
    model = busy_robot(moving_base)
    rng = np.random.default_rng(1)
    q, qd, qdd = random_state(model, rng, 20)
    columns = {name: rng.normal(size=20) for name in BUSY_SCENE.columns}
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=BUSY_SCENE, columns=columns)
    bias = robodyn.bias_forces(model, q, qd, scene=BUSY_SCENE, columns=columns)
    M = robodyn.mass_matrix(model, q, scene=BUSY_SCENE)
    assert worst(np.einsum("ijk,ik->ij", M, qdd) + bias, tau) <= 1e-14
    np.testing.assert_array_equal(M, np.swapaxes(M, 1, 2))
    assert (np.linalg.eigvalsh(M) > 0).all()


def test_shapes():
    model = robot("puma560")
    q = np.zeros((2, 3, 4, 6))
    assert robodyn.inverse_dynamics(model, q, 0, 0).shape == (2, 3, 4, 6)
    assert robodyn.inverse_dynamics(model, q[0, 0, 0], 0, 0).shape == (6,)
    assert robodyn.mass_matrix(model, q).shape == (2, 3, 4, 6, 6)
    assert robodyn.bias_forces(model, q[0], q).shape == (2, 3, 4, 6)
    assert robodyn.mass_matrix(model, q[:0]).shape == (0, 3, 4, 6, 6)


WRONG = {
    "q has 5 columns, the robot has 6": ([0] * 5, 0, 0),
    "qd has 7 columns, the robot has 6": (0, [0] * 7, 0),
    "qdd has 1 columns, the robot has 6": (0, 0, [0]),
    "the shapes do not go together": (np.zeros((2, 6)), np.zeros((3, 6)), 0),
}


@pytest.mark.parametrize("message", WRONG)
def test_wrong_shapes(message):
    with pytest.raises(InputError, match=message):
        robodyn.inverse_dynamics(robot("puma560"), *WRONG[message])


def test_columns_of_another_shape_are_named():
    model = busy_robot()
    columns = {"push": np.zeros(3), "twist": 0.0}
    with pytest.raises(InputError, match=r"q \(2, 5\), qd \(5,\), qdd \(5,\), push \(3,\), twist \(\)"):
        robodyn.bias_forces(model, np.zeros((2, 5)), 0, scene=BUSY_SCENE, columns=columns)


NO_NUMBERS = {
    "complex ones": [1j] * 6,
    "text": ["1"] * 6,
    "None": None,
    "other objects": [None] * 6,
    "dates": np.zeros(6, "M8[D]"),
    "rows have different lengths": [[1.0], [1.0, 2.0]],
}


@pytest.mark.parametrize("found", NO_NUMBERS)
def test_no_numbers(found):
    """Neither as a coordinate nor as a column of the scene."""
    with pytest.raises(InputError, match=f"^qd is no array of numbers: it.* {found}$"):
        robodyn.inverse_dynamics(robot("puma560"), 0, NO_NUMBERS[found], 0)
    columns = {"push": NO_NUMBERS[found], "twist": 0.0}
    with pytest.raises(InputError, match=f"^push is no array of numbers: it.* {found}$"):
        robodyn.inverse_dynamics(busy_robot(), 0, 0, 0, scene=BUSY_SCENE, columns=columns)


@pytest.mark.parametrize("dtype", [bool, np.int8, np.uint64, np.float16, np.float32, np.longdouble, ">f8"])
def test_all_numbers_are_converted(dtype):
    model, q = robot("puma560"), np.array([0, 1, 0, 1, 1, 0])
    expected = robodyn.inverse_dynamics(model, q.astype(float), 0, 0)
    np.testing.assert_array_equal(robodyn.inverse_dynamics(model, q.astype(dtype), 0, 0), expected)
    np.testing.assert_array_equal(robodyn.inverse_dynamics(model, q.tolist(), 0, 0), expected)


OF_STATES = {
    "inverse_dynamics": 3,
    "forward_dynamics": 3,
    "bias_forces": 2,
    "mass_matrix": 1,
    "coriolis_matrix": 2,
    "momenta": 2,
    "regressor": 3,
    "inverse_dynamics_derivatives": 3,
    "inverse_dynamics_derivative_entries": 3,
    "inverse_dynamics_second_derivatives": 3,
    "forward_dynamics_derivatives": 3,
    "free_bodies": 3,
}


@pytest.mark.parametrize(
    ("model", "scene", "words"),
    [
        (None, Scene(), "model is no robot but None"),
        ("ur5.urdf", Scene(), "model is no robot but of type str"),
        ("puma560", None, "scene is no scene but None"),
        ("puma560", "scene.toml", "scene is no scene but of type str"),
        ("puma560", {}, "scene is no scene but of type dict"),
    ],
)
def test_no_robot_or_no_scene(model, scene, words):
    model = robot(model) if model == "puma560" else model
    for name, count in OF_STATES.items():
        with pytest.raises(InputError, match=words):
            getattr(robodyn, name)(model, *(0,) * count, scene=scene)
    for call in (
        lambda: robodyn.function(model, "mass_matrix", scene=scene),
        lambda: robodyn.export(model, "c", scene=scene),
        lambda: robodyn.simulate(model, scene, duration=1.0),
        lambda: robodyn.rollouts(model, [0], [0], scene=scene, steps=1, step=0.1),
        lambda: robodyn.torques(model, "motion.csv", scene),
        lambda: robodyn.dae(model, scene),
        lambda: robodyn.linearize(model, scene),
        lambda: robodyn.read_motion("motion.csv", model, scene),
    ):
        with pytest.raises(InputError, match=words):
            call()


OPTIONS = {
    "out is no array but of type list": {"out": [0.0] * 6},
    "dtype 'decimal' is not offered": {"dtype": "decimal"},
    "dtype int64 is not offered": {"dtype": np.int64},
    "there is no executor 'gpu'": {"executor": "gpu"},
    "out has shape": {"out": np.empty((2, 6))},
    "'all' threads cannot work": {"threads": "all"},
    "1.5 threads cannot work": {"threads": 1.5},
    "there is no executor None": {"executor": None},
}


@pytest.mark.parametrize("words", OPTIONS)
def test_wrong_options(words):
    with pytest.raises(InputError, match=words):
        robodyn.inverse_dynamics(robot("puma560"), 0, 0, 0, **OPTIONS[words])
    with pytest.raises(InputError, match="columns is no mapping"):
        robodyn.inverse_dynamics(busy_robot(), 0, 0, 0, scene=BUSY_SCENE, columns=(1.0, 2.0))


@needs_compiler
@pytest.mark.parametrize(("name", "most"), [("inverse_dynamics", 52), ("forward_dynamics", 56), ("mass_matrix", 45)])
def test_few_samples_take_few_calls(name, most):
    """What a call costs are the functions that it calls: so many, of Python and of C, whatever the joints."""
    model, calls = robot("puma560"), []
    function, state = getattr(robodyn, name), [np.full(6, 0.3)] * OF_STATES[name]
    function(model, *state, executor="compiled")
    sys.setprofile(lambda frame, event, argument: calls.append(event) if event.endswith("call") else None)
    try:
        function(model, *state, executor="compiled")
    finally:
        sys.setprofile(None)
    assert 20 < len(calls) <= most


def test_plans_are_made_once():
    model, scene = robot("puma560"), Scene()
    assert plan(model, scene) is plan(model, scene)
    assert plan(model, scene) is plan(model, Scene())
    assert plan(model, scene) is not plan(robodyn.load(model.file), scene)
