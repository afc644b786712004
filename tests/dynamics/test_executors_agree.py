"""Machine code against NumPy: every program of a plan, single precision, and output arrays of any layout."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.compiled_programs import bits, needs_compiler
from helpers.oracles import EPS, ROBOTS, random_state, robot, worst

from robodyn.dynamics.forward import forward_dynamics
from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.dynamics.momenta import energy, laws, losses
from robodyn.dynamics.plan import Plan
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.scene.read import load_scene

pytestmark = needs_compiler

SAMPLES = 130


def sources(model, scene, samples=SAMPLES):
    rng = np.random.default_rng(len(model.name))
    arrays = dict(zip(("q", "qd", "qdd"), random_state(model, rng, samples), strict=True))
    return arrays | {"columns": rng.uniform(-2.0, 2.0, (samples, len(scene.columns)))}


def both(program, arrays, dtype=np.float64):
    samples = len(arrays["q"])
    widths = {name: values.shape[1] for name, values in arrays.items()}
    given = {name: values.astype(dtype) for name, values in arrays.items()}
    return [ready(program, widths, dtype)(given, samples).astype(float) for ready in (CompiledBlocks, NumpyBlocks)]


@pytest.mark.parametrize(
    "make",
    [
        lambda: (robot("gripper"), load_scene(ROBOTS / "gripper.toml")),
        pytest.param(lambda: (busy_robot(True), BUSY_SCENE), marks=pytest.mark.slow),
    ],
    ids=["mimic joints", "every effect"],
)
def test_every_program_of_a_plan(make):
    plan = Plan(*make())
    arrays = sources(plan.model, plan.scene)
    programs = [plan.torques(), plan.wrenches(joints=True), energy(plan), losses(plan), *map(plan.share, plan.effects)]
    assert len(programs) >= 7
    for program in programs:
        assert worst(*both(program, arrays)) <= 8 * EPS
    compiled, plain = both(laws(plan), arrays)
    for part in (slice(0, 3), slice(3, 6), slice(6, 7), slice(7, 10)):
        assert worst(compiled[:, part], plain[:, part]) <= 8 * EPS


@pytest.mark.parametrize(("name", "free"), [("gripper", False), ("satellite", True)])
def test_single_precision(name, free):
    model = robot(name, free)
    q, qd, qdd = random_state(model, np.random.default_rng(4), 1000)
    tau = inverse_dynamics(model, q, qd, qdd)
    back = np.finfo(np.float32).eps * np.linalg.cond(mass_matrix(model, q)).max()
    for executor in ("numpy", "compiled"):
        how = {"executor": executor, "dtype": np.float32}
        found, again = inverse_dynamics(model, q, qd, qdd, **how), forward_dynamics(model, q, qd, tau, **how)
        assert found.dtype == again.dtype == np.float32
        assert 1e-9 < worst(found, tau) <= 1e-6
        assert worst(again, forward_dynamics(model, q, qd, tau)) <= back


def test_output_arrays():
    model = robot("puma")
    state = random_state(model, np.random.default_rng(5), 240)
    right = inverse_dynamics(model, *state, executor="compiled")
    assert worst(right, inverse_dynamics(model, *state, executor="numpy")) <= 4 * EPS
    for out in (np.empty((240, 3)), np.empty((3, 240)).T, np.empty((240, 6))[:, ::2], np.empty((480, 3))[::-2]):
        assert inverse_dynamics(model, *state, executor="compiled", out=out) is out
        np.testing.assert_array_equal(bits(out), bits(right))
    cube = np.empty((3, 4, 3, 20)).T
    inverse_dynamics(model, *(x.reshape(20, 3, 4, 3) for x in state), executor="compiled", out=cube)
    np.testing.assert_array_equal(cube, right.reshape(20, 3, 4, 3))
    over = state[0].copy()
    inverse_dynamics(model, over, *state[1:], executor="compiled", out=over)
    np.testing.assert_array_equal(bits(over), bits(right))
