"""Derivatives of dynamics against differences with 100 digits, Pinocchio and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, EVERY_EFFECT, busy_robot
from helpers.exact_rates import exact_rates
from helpers.example_robots import LARGE_ONES, VARIANTS, cases, real
from helpers.oracles import EPS, frictionless, random_state, robot, tangent, worst
from helpers.oracles import ROBOTS as FOLDER
from helpers.pinocchio_robots import PinocchioRobot
from helpers.sampled import sampled

import robodyn
from robodyn.dynamics.derivatives import forward_dynamics_derivatives, inverse_dynamics_derivatives
from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError, SceneError
from robodyn.robot.load import load
from robodyn.scene.parts import Friction, Loop
from robodyn.scene.read import load_scene
from robodyn.scene.scene import Scene

SAMPLES = 2
EXECUTORS = ("numpy", "compiled")
bases = pytest.mark.parametrize(
    "moving_base", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["fixed", "free"]
)


def busy_state(moving_base):
    model, rng = busy_robot(moving_base), np.random.default_rng(5)
    return (
        model,
        *random_state(model, rng, SAMPLES),
        {name: rng.uniform(-1, 1, SAMPLES) for name in EVERY_EFFECT.columns},
    )


def directions(model, q, last):
    return [*tangent(model, q), *({(source, i): 1} for source in ("qd", last) for i in range(model.n))]


def thirds(rates, n):
    """The three matrices that stand beside each other."""
    return np.moveaxis(rates.astype(float).reshape(len(rates), n, 3, n), 2, 0)


@bases
def test_every_effect_of_inverse_dynamics(moving_base):
    model, q, qd, qdd, columns = busy_state(moving_base)
    program = Plan(model, EVERY_EFFECT).torques()
    sources = {"q": q, "qd": qd, "qdd": qdd, "columns": np.column_stack(list(columns.values()))}
    expected = thirds(exact_rates(program, directions(model, q, "qdd"), sources), model.n)
    for executor in EXECUTORS:
        found = inverse_dynamics_derivatives(model, q, qd, qdd, scene=EVERY_EFFECT, columns=columns, executor=executor)
        assert max(map(worst, found, expected)) <= 1e-14, executor
        assert (found.dqdd == np.swapaxes(found.dqdd, -1, -2)).all(), executor


@bases
def test_every_effect_of_forward_dynamics(moving_base):
    model, q, qd, _, columns = busy_state(moving_base)
    tau = np.random.default_rng(6).uniform(-5, 5, (SAMPLES, model.n))
    program = acceleration_program(Plan(model, EVERY_EFFECT))
    sources = {"q": q, "qd": qd, "tau": tau, "columns": np.column_stack(list(columns.values()))}
    expected = thirds(exact_rates(program, directions(model, q, "tau"), sources), model.n)
    condition = np.linalg.cond(robodyn.mass_matrix(model, q, scene=EVERY_EFFECT)).max()
    for executor in EXECUTORS:
        found = forward_dynamics_derivatives(model, q, qd, tau, scene=EVERY_EFFECT, columns=columns, executor=executor)
        assert max(map(worst, found, expected)) <= 8 * EPS * condition, executor
        assert (found.dtau == np.swapaxes(found.dtau, -1, -2)).all(), executor


@bases
@pytest.mark.parametrize("path", sampled(cases(leave_out=VARIANTS), 7))
def test_pinocchio(path, moving_base):
    model, rng = load(path, moving_base=moving_base), np.random.default_rng(len(path.name))
    other, (q, qd, qdd) = PinocchioRobot(path, free=moving_base), random_state(model, rng, 2)
    found = inverse_dynamics_derivatives(model, q, qd, qdd, scene=frictionless(model))
    expected = [other.derivatives(model, *sample) for sample in zip(q, qd, qdd, strict=True)]
    largest = np.abs(robodyn.inverse_dynamics(model, q, qd, qdd, scene=frictionless(model))).max(initial=0)
    for k, each in enumerate(("dq", "dqd")):
        other_rates = np.array([pair[k] for pair in expected])
        assert worst(getattr(found, each), other_rates, max(np.abs(other_rates).max(initial=0), largest)) <= 1e-12, each
    assert worst(found.dqdd, other.mass_matrices(model, q)) <= 1e-12


@bases
@pytest.mark.parametrize("path", sampled(cases(leave_out=LARGE_ONES), 5))
def test_forward_undoes_inverse(path, moving_base):
    """M d qdd = -d tau, at the accelerations that the torques make."""
    model, rng = load(path, moving_base=moving_base), np.random.default_rng(len(path.name))
    q, qd, qdd = random_state(model, rng, 2)
    scene = frictionless(model)
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene)
    M = robodyn.mass_matrix(model, q, scene=scene)
    if not model.n or np.linalg.cond(M).max() > 1e9:
        pytest.skip("the mass matrix of this robot leaves no digits, or there is none")
    forward = forward_dynamics_derivatives(model, q, qd, tau, scene=scene)
    inverse = inverse_dynamics_derivatives(model, q, qd, qdd, scene=scene)
    for a, b in ((forward.dq, inverse.dq), (forward.dqd, inverse.dqd)):
        largest = max(each.max(initial=0) for each in (np.abs(b), np.abs(M) @ np.abs(a), np.abs(tau)))
        assert worst(M @ a, -b, largest) <= 1e-11
    assert worst(M @ forward.dtau, np.broadcast_to(np.eye(model.n), M.shape), np.linalg.cond(M).max()) <= 1e-13


def scenes():
    """Every robot of robots/ with the scenes of trees named after it, its base fixed and free, where that goes."""
    trees = [scene for scene in sorted(FOLDER.glob("*.toml")) if not load_scene(scene).constraint_names]
    for scene in (None, *trees):
        for path in sorted(FOLDER.glob("*.urdf")):
            if scene is None or scene.stem.startswith(f"{path.stem}_"):
                for moving_base in (False, True):
                    kind = "free" if moving_base else "fixed"
                    yield pytest.param(path, scene, moving_base, id=f"{(scene or path).stem}-{kind}")


OF_A_FREE_BASE = ("composite_throw", "satellite_deploy")
"""Scenes that do not fit a fixed base."""


@pytest.mark.slow
@pytest.mark.parametrize(("path", "scene_path", "moving_base"), list(scenes()))
def test_robots_and_scenes(path, scene_path, moving_base):
    model, scene = load(path, moving_base=moving_base), Scene() if scene_path is None else load_scene(scene_path)
    if not model.n or (scene_path and scene_path.stem in OF_A_FREE_BASE and not moving_base):
        pytest.skip("nothing moves, or the scene is of a free base")
    rng = np.random.default_rng(0)
    state, columns = random_state(model, rng, 2), {name: rng.uniform(-1, 1, 2) for name in scene.columns}
    found = inverse_dynamics_derivatives(model, *state, scene=scene, columns=columns)
    names = ("q", "qd", "qdd")
    sources = {**dict(zip(names, state, strict=True)), "columns": np.column_stack([*columns.values(), state[1][:, :0]])}
    program = Plan(model, scene).torques()
    expected = thirds(exact_rates(program, directions(model, state[0], "qdd"), sources), model.n)
    tau = robodyn.inverse_dynamics(model, *state, scene=scene, columns=columns)
    for a, b in zip(found, expected, strict=True):
        assert worst(a, b, max(np.abs(b).max(), np.abs(tau).max())) <= 32 * EPS


def test_a_pendulum():
    """tau = m l^2 qdd + d qd + m g l cos q."""
    model = robot("pendulum")
    q = np.linspace(-3, 3, 7)[:, None]
    found = inverse_dynamics_derivatives(
        model, q, 0.0, 0.0, scene=Scene(friction={model.joint_names[0]: Friction(0.3)})
    )
    weight = robodyn.inverse_dynamics(model, [[0.0]], 0.0, 0.0, scene=frictionless(model))[0, 0]
    assert worst(found.dq[:, 0, 0], -weight * np.sin(q[:, 0])) <= 8 * EPS
    assert (found.dqd == 0.3).all()


def test_friction_has_a_slope_where_it_is_smooth():
    model = robot("pendulum")
    (name,) = model.joint_names
    for slip, slope in ((0.0, 0.0), (1e-200, 0.0), (1e-150, 0.5 / 1e-150), (0.1, 0.5 / 0.1)):
        scene = Scene(friction={name: Friction(0.0, 0.5, -0.5)}, slip_speed=slip)
        found = inverse_dynamics_derivatives(model, [0.0], [0.0], [0.0], scene=scene)
        assert found.dqd[0, 0] == pytest.approx(slope, rel=1e-15)


@pytest.mark.parametrize("executor", EXECUTORS)
def test_shapes_and_out(executor):
    model, q, qd, qdd, columns = busy_state(False)
    whole = inverse_dynamics_derivatives(model, q, qd, qdd, scene=EVERY_EFFECT, columns=columns, executor=executor)
    n = model.n
    assert whole.dq.shape == (SAMPLES, n, n)
    single = {name: values[0] for name, values in columns.items()}
    one = inverse_dynamics_derivatives(
        model, q[0], qd[0], qdd[0], scene=EVERY_EFFECT, columns=single, executor=executor
    )
    assert one.dq.shape == (n, n)
    assert max(map(worst, one, (x[0] for x in whole))) <= 8 * EPS
    for order in "CF":
        out = np.empty((SAMPLES, 3, n, n), order=order)
        given = inverse_dynamics_derivatives(
            model, q, qd, qdd, scene=EVERY_EFFECT, columns=columns, executor=executor, out=out
        )
        assert all(np.shares_memory(x, out) for x in given)
        assert all((a == b).all() for a, b in zip(given, whole, strict=True))
    in_32 = inverse_dynamics_derivatives(model, q, qd, qdd, scene=EVERY_EFFECT, columns=columns, dtype=np.float32)
    assert in_32.dq.dtype == np.float32
    assert max(map(worst, in_32, whole)) <= 1e-5


@pytest.mark.slow
@pytest.mark.parametrize(("name", "bound"), [("ur5_robot", 1e-5), ("anymal", 1e-4)])
def test_single_precision_of_free_robots(name, bound):
    """At rest, d tau / dq of ANYmal's base is the small rest of large weights."""
    model = real(name, True)
    q = random_state(model, np.random.default_rng(7), 20)[0].astype(np.float32)
    for executor in EXECUTORS:
        whole, in_32 = (
            inverse_dynamics_derivatives(model, q, 0, 0, executor=executor, dtype=x) for x in (np.float64, np.float32)
        )
        assert max(map(worst, in_32, whole)) <= bound


def test_the_threads_agree():
    model, q, qd, qdd, columns = busy_state(True)
    many = [np.resize(x, (3000, x.shape[1])) for x in (q, qd, qdd)]
    more = {name: np.resize(x, 3000) for name, x in columns.items()}
    one, two = (
        inverse_dynamics_derivatives(model, *many, scene=EVERY_EFFECT, columns=more, executor="compiled", threads=k)
        for k in (1, 2)
    )
    assert all((a == b).all() for a, b in zip(one, two, strict=True))


def test_refusals():
    model, q, qd, qdd, _ = busy_state(False)
    with pytest.raises(InputError, match="needs columns"):
        inverse_dynamics_derivatives(model, q, qd, qdd, scene=EVERY_EFFECT)
    with pytest.raises(InputError, match="out has shape"):
        inverse_dynamics_derivatives(model, q, qd, qdd, out=np.empty((SAMPLES, model.n, model.n)))
    with pytest.raises(SceneError, match="loop"):
        inverse_dynamics_derivatives(model, q, qd, qdd, scene=Scene(loops=(Loop("l", "tool"),)))


ROBOTS = {
    "busy": (busy_robot(False), BUSY_SCENE),
    "busy, free": (busy_robot(True), BUSY_SCENE),
    "puma": (robot("puma560"), Scene()),
}


@pytest.mark.parametrize(
    ("name", "executor"),
    [
        *((name, "numpy") for name in ROBOTS),
        *((name, "compiled") for name in ("busy", "puma")),
        pytest.param("busy, free", "compiled", marks=pytest.mark.slow),
    ],
)
def test_dense_form(name, executor):
    """Every entry to the last bit; those left out are zero, or are given on the other side of the diagonal of M."""
    model, scene = ROBOTS[name]
    rng = np.random.default_rng(3)
    state, columns = random_state(model, rng, 40), {each: rng.uniform(-1, 1, 40) for each in scene.columns}
    found = robodyn.inverse_dynamics_derivative_entries(model, *state, scene=scene, columns=columns, executor=executor)
    expected = robodyn.inverse_dynamics_derivatives(model, *state, scene=scene, columns=columns, executor=executor)
    for matrix, other in zip(found.dense(), expected, strict=True):
        np.testing.assert_array_equal(matrix, other)
    assert found.values.shape == (40, len(found.row))
    assert (found.row <= found.column)[found.matrix == 2].all()
    assert len(set(zip(found.matrix, found.row, found.column, strict=True))) == len(found.row)
    assert found.values.any(axis=0).mean() > 0.9


def test_branches_do_not_meet():
    """Legs of a body that stands still: no entry joins two of them."""
    model = real("solo12")
    entries = robodyn.inverse_dynamics_derivative_entries(model, np.zeros(model.nq), 0.0, 0.0)
    leg = np.array([name[:2] for name in model.joint_names])
    assert (leg[entries.row] == leg[entries.column]).all()
    assert len(entries.row) == 4 * (9 + 9 + 6)
