"""Machine code against NumPy: real robots, every program of a plan, golden numbers, and arrays of any layout."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.compiled_programs import bits, needs_compiler
from helpers.example_robots import cases
from helpers.oracles import EPS, golden_model, random_state, robot, worst
from helpers.robot_catalogue import names
from helpers.sampled import sampled

from robodyn.dynamics.balance import energy, laws, losses
from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.plan import Plan
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.robot.load import load
from robodyn.scene.scene import Scene

pytestmark = needs_compiler

SAMPLES = 130
APART = {False: 4 * EPS, True: 8 * EPS}
"""Of the largest torque, for fixed and free bases: the rotation from a quaternion costs some roundings more."""


def sources(model, scene, samples=SAMPLES):
    rng = np.random.default_rng(len(model.name))
    arrays = dict(zip(("q", "qd", "qdd"), random_state(model, rng, samples), strict=True))
    return arrays | {"columns": rng.uniform(-2.0, 2.0, (samples, len(scene.columns)))}


def both(program, arrays, dtype=np.float64):
    """The results of the two executors, in doubles."""
    samples = len(arrays["q"])
    widths = {name: values.shape[1] for name, values in arrays.items()}
    given = {name: values.astype(dtype) for name, values in arrays.items()}
    return [ready(program, widths, dtype)(given, samples).astype(float) for ready in (CompiledBlocks, NumpyBlocks)]


@pytest.mark.parametrize("moving_base", [False, True], ids=["fixed", "free"])
@pytest.mark.parametrize("path", sampled(cases(), 7))
def test_torques_of_real_robots(path, moving_base):
    model = load(path, moving_base=moving_base)
    compiled, plain = both(Plan(model, Scene()).torques(), sources(model, Scene()))
    assert worst(compiled, plain) <= APART[moving_base]


ROBOTS = {
    "tree": (lambda free: golden_model("tree15_bf2_skew0.3"), Scene()),
    "every effect": (busy_robot, BUSY_SCENE),
    "mimic joints": (lambda free: robot("gripper", moving_base=free), Scene()),
}


@pytest.mark.parametrize(
    ("name", "free"),
    [
        ("tree", False),
        ("every effect", False),
        ("mimic joints", True),
        pytest.param("every effect", True, marks=pytest.mark.slow),
        pytest.param("mimic joints", False, marks=pytest.mark.slow),
    ],
)
def test_every_program_of_a_plan(name, free):
    made, scene = ROBOTS[name]
    plan = Plan(made(free), scene)
    arrays = sources(plan.model, scene)
    programs = [plan.torques(), plan.wrenches(joints=True), energy(plan), losses(plan), *map(plan.share, plan.effects)]
    assert len(programs) >= 7
    for program in programs:
        assert worst(*both(program, arrays)) <= 8 * EPS
    compiled, plain = both(laws(plan), arrays)
    for part in (slice(0, 3), slice(3, 6), slice(6, 7), slice(7, 10)):
        assert worst(compiled[:, part], plain[:, part]) <= 8 * EPS


@pytest.mark.parametrize("name", names())
@pytest.mark.parametrize("free", [False, True])
def test_single_precision(name, free):
    model = robot(name, moving_base=free)
    program, arrays = Plan(model, Scene()).torques(), sources(model, Scene(), 1000)
    exact = both(program, arrays)[1]
    for found in both(program, arrays, np.float32):
        assert worst(found, exact) <= 1e-6


def test_single_precision_of_inverse_dynamics():
    model = robot("puma560")
    state = random_state(model, np.random.default_rng(4), 1000)
    exact = inverse_dynamics(model, *state)
    for executor in ("numpy", "compiled"):
        tau = inverse_dynamics(model, *state, executor=executor, dtype=np.float32)
        assert tau.dtype == np.float32
        assert 1e-9 < worst(tau, exact) <= 1e-6


MODEL = golden_model("puma560_corke")
STATE = random_state(MODEL, np.random.default_rng(5), 5000)


def torques(state, **more):
    return inverse_dynamics(MODEL, *state, executor="compiled", **more)


def test_neither_threads_nor_order_nor_company_change_a_bit():
    right = torques(STATE, threads=1)
    assert worst(right, inverse_dynamics(MODEL, *STATE, executor="numpy")) <= 4 * EPS
    for threads in (2, 3, 5):
        np.testing.assert_array_equal(bits(torques(STATE, threads=threads)), bits(right))
    order = np.random.default_rng(6).permutation(5000)
    np.testing.assert_array_equal(bits(torques([x[order] for x in STATE])), bits(right[order]))
    for part in (slice(0, 1), slice(1000, 1009), slice(4990, None)):
        np.testing.assert_array_equal(bits(torques([x[part] for x in STATE])), bits(right[part]))


LAYOUTS = {
    "columns": np.asfortranarray,
    "backwards": lambda x: np.ascontiguousarray(x[::-1])[::-1],
    "every third row": lambda x: np.repeat(x, 3, axis=0)[::3],
    "other bytes first": lambda x: x.astype(">f8"),
    "nested lists": lambda x: x.tolist(),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_arrays_of_any_layout(layout):
    state = [x[:300] for x in STATE]
    np.testing.assert_array_equal(bits(torques([LAYOUTS[layout](x) for x in state])), bits(torques(state)))


def test_output_arrays():
    state = [x[:240] for x in STATE]
    right = torques(state)
    for out in (np.empty((240, 6)), np.empty((6, 240)).T, np.empty((240, 12))[:, ::2], np.empty((480, 6))[::-2]):
        assert torques(state, out=out) is out
        np.testing.assert_array_equal(bits(out), bits(right))
    cube = np.empty((6, 4, 3, 20)).T
    torques([x.reshape(20, 3, 4, 6) for x in state], out=cube)
    np.testing.assert_array_equal(cube, right.reshape(20, 3, 4, 6))
    over = state[0].copy()
    torques([over, *state[1:]], out=over)
    np.testing.assert_array_equal(bits(over), bits(right))


def test_inputs_that_broadcast():
    q, qd, qdd = (x[:40] for x in STATE)
    crossed = torques([q[0], qd[:, None], qdd])
    assert crossed.shape == (40, 40, 6)
    np.testing.assert_array_equal(bits(crossed[5, 7]), bits(torques([q[0], qd[5], qdd[7]])))
    resting = torques([q, 0.0, 0.0])
    assert worst(resting, inverse_dynamics(MODEL, q, 0.0, 0.0, executor="numpy")) <= 4 * EPS
