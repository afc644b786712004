"""First and second derivatives of dynamics against differences with 100 digits, Pinocchio and closed forms; the
Coriolis matrix, which makes the Coriolis torques, and M' - 2 C, which is skew-symmetric."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, EVERY_EFFECT, busy_robot
from helpers.exact_rates import exact_rates
from helpers.example_robots import kinds, real
from helpers.oracles import EPS, ROBOTS, frictionless, random_state, robot, tangent, worst
from helpers.pinocchio_robots import PinocchioRobot
from helpers.robot_catalogue import names
from helpers.sampled import sampled

import robodyn
from robodyn.dynamics.derivatives import forward_dynamics_derivatives, inverse_derivatives, inverse_dynamics_derivatives
from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.inverse import coriolis_matrix, mass_runner
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError, SceneError
from robodyn.robot.load import load
from robodyn.scene.scene import ExternalWrench, Friction, Loop, Scene

SAMPLES = 2
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
    found = inverse_dynamics_derivatives(model, q, qd, qdd, scene=EVERY_EFFECT, columns=columns, executor="numpy")
    assert max(map(worst, found, expected)) <= 1e-14
    assert (found.dqdd == np.swapaxes(found.dqdd, -1, -2)).all()


@bases
def test_every_effect_of_forward_dynamics(moving_base):
    model, q, qd, _, columns = busy_state(moving_base)
    tau = np.random.default_rng(6).uniform(-5, 5, (SAMPLES, model.n))
    program = acceleration_program(Plan(model, EVERY_EFFECT))
    sources = {"q": q, "qd": qd, "tau": tau, "columns": np.column_stack(list(columns.values()))}
    expected = thirds(exact_rates(program, directions(model, q, "tau"), sources), model.n)
    condition = np.linalg.cond(robodyn.mass_matrix(model, q, scene=EVERY_EFFECT)).max()
    found = forward_dynamics_derivatives(model, q, qd, tau, scene=EVERY_EFFECT, columns=columns, executor="numpy")
    assert max(map(worst, found, expected)) <= 8 * EPS * condition
    assert (found.dtau == np.swapaxes(found.dtau, -1, -2)).all()


@bases
@pytest.mark.parametrize("path", kinds())
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


def test_friction_has_a_slope_where_it_is_smooth():
    model = robot("pendulum")
    (name,) = model.joint_names
    for slip, slope in ((0.0, 0.0), (1e-200, 0.0), (1e-150, 0.5 / 1e-150), (0.1, 0.5 / 0.1)):
        scene = Scene(friction={name: Friction(0.0, 0.5, -0.5)}, slip_speed=slip)
        found = inverse_dynamics_derivatives(model, [0.0], [0.0], [0.0], scene=scene)
        assert found.dqd[0, 0] == pytest.approx(slope, rel=1e-15)


PUSHED = Scene(wrenches=(ExternalWrench("spindle", ("push", 0.0, 2.0), (0.0, "twist", 0.0)),))


@pytest.mark.parametrize("executor", ["numpy", "compiled"])
def test_shapes_and_out(executor):
    model = robot("scara")
    state, n, more = random_state(model, np.random.default_rng(5), SAMPLES), model.n, {"executor": executor}
    whole = inverse_dynamics_derivatives(model, *state, **more)
    assert whole.dq.shape == (SAMPLES, n, n)
    one = inverse_dynamics_derivatives(model, *(x[0] for x in state), **more)
    assert max(map(worst, one, (x[0] for x in whole))) <= 8 * EPS
    out = np.empty((SAMPLES, 3, n, n), order="F")
    given = inverse_dynamics_derivatives(model, *state, out=out, **more)
    assert all(np.shares_memory(x, out) for x in given)
    assert all((a == b).all() for a, b in zip(given, whole, strict=True))
    in_32 = inverse_dynamics_derivatives(model, *state, dtype=np.float32, **more)
    assert in_32.dq.dtype == np.float32
    assert max(map(worst, in_32, whole)) <= 1e-5


def test_refusals():
    model, q, qd, qdd, _ = busy_state(False)
    with pytest.raises(InputError, match="needs columns"):
        inverse_dynamics_derivatives(model, q, qd, qdd, scene=EVERY_EFFECT)
    with pytest.raises(InputError, match="out has shape"):
        inverse_dynamics_derivatives(model, q, qd, qdd, out=np.empty((SAMPLES, model.n, model.n)))
    with pytest.raises(SceneError, match="loop"):
        inverse_dynamics_derivatives(model, q, qd, qdd, scene=Scene(loops=(Loop("l", "tool"),)))


@pytest.mark.parametrize(
    ("name", "executor"),
    [("busy", "numpy"), ("scara", "compiled"), pytest.param("busy, free", "numpy", marks=pytest.mark.slow)],
)
def test_dense_form(name, executor):
    """Every entry to the last bit; those left out are zero, or are given on the other side of the diagonal of M."""
    model, scene = (robot(name), PUSHED) if name == "scara" else (busy_robot("free" in name), BUSY_SCENE)
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


def exact(model, state, scene, columns):
    """The four tensors, by differences of the program of first derivatives."""
    names = ("q", "qd", "qdd")
    sources = {**dict(zip(names, state, strict=True)), "columns": np.column_stack([*columns.values(), state[1][:, :0]])}
    n, program = model.n, inverse_derivatives(Plan(model, scene))
    ways = [*tangent(model, state[0]), *({("qd", i): 1} for i in range(n))]
    rates = exact_rates(program, ways, sources).astype(float).reshape(-1, 3, n, n, 2, n)
    by_q, by_qd = rates[..., 0, :], rates[..., 1, :]
    return by_q[:, 0], by_q[:, 1], by_qd[:, 1], by_q[:, 2]


def twice(model, state, scene, columns, **options):
    return robodyn.inverse_dynamics_second_derivatives(model, *state, scene=scene, columns=columns, **options)


@pytest.mark.slow
def test_every_effect():
    model, rng = busy_robot(), np.random.default_rng(8)
    state, columns = random_state(model, rng, 1), {name: rng.uniform(-1, 1, 1) for name in EVERY_EFFECT.columns}
    found = twice(model, state, EVERY_EFFECT, columns, executor="numpy")
    assert max(map(worst, found, exact(model, state, EVERY_EFFECT, columns))) <= 1e-14
    assert worst(found.q_q, np.swapaxes(found.q_q, -1, -2)) <= 1e-14


def test_a_free_base():
    """A pendulum that hangs from a body that turns: turns do not commute, and the order is that of the indices."""
    model, rng = robot("double_pendulum", moving_base=True), np.random.default_rng(4)
    state = random_state(model, rng, 1)
    found = twice(model, state, Scene(), {}, executor="numpy")
    assert max(map(worst, found, exact(model, state, Scene(), {}))) <= 1e-14


@pytest.mark.parametrize("executor", ["numpy", "compiled"])
def test_an_arm(executor):
    """d^2 tau / dqd dqd is twice Christoffel's symbols, which follow from dM / dq alone."""
    model, rng = robot("two_link_spatial"), np.random.default_rng(9)
    state, scene = random_state(model, rng, 2), frictionless(model)
    found = twice(model, state, scene, {}, executor=executor)
    dM = found.qdd_q
    symbols = (dM + np.swapaxes(dM, -1, -2) - np.moveaxis(dM, -1, -3)) / 2
    assert worst(found.qd_qd, 2 * symbols, 2 * np.abs(dM).max()) <= 16 * EPS
    assert worst(found.q_q, exact(model, state, scene, {})[0]) <= 1e-13


def test_robots_with_many_joints_are_refused(monkeypatch):
    monkeypatch.setattr("robodyn.dynamics.derivatives.MOST_BEFORE", 10)
    with pytest.raises(InputError, match=r"more than 100000 operations \(those of its first need \d{3}\)"):
        robodyn.inverse_dynamics_second_derivatives(robodyn.load(ROBOTS / "puma.urdf"), np.zeros(3), 0.0, 0.0)


PAYLOADS = Scene(gravity=(0.0, 0.0, 0.0), payloads=BUSY_SCENE.payloads)


@pytest.fixture(params=["busy", "satellite", *sampled(names(), 7)])
def name(request):
    return request.param


@pytest.fixture(params=[False, True], ids=["fixed", "free"])
def case(name, request):
    return (busy_robot(request.param), PAYLOADS) if name == "busy" else (robot(name, request.param), Scene())


def test_it_makes_the_coriolis_torques(case):
    model, scene = case
    q, qd, _ = random_state(model, np.random.default_rng(1), SAMPLES)
    C = coriolis_matrix(model, q, qd, scene=scene)
    bias, rest = (robodyn.bias_forces(model, q, x, scene=_without_friction(model, scene)) for x in (qd, 0.0))
    assert worst((C @ qd[..., None])[..., 0], bias - rest, (np.abs(C) @ np.abs(qd[..., None])).max(initial=0)) <= 1e-13


def test_passivity(case):
    model, scene = case
    q, qd, _ = random_state(model, np.random.default_rng(2), SAMPLES)
    C, n = coriolis_matrix(model, q, qd, scene=scene), model.n
    rates = exact_rates(mass_runner(model, scene).program, [_along(model, q, qd)], {"q": q})[..., 0].astype(float)
    skew = rates.reshape(SAMPLES, n, n) - 2 * C
    assert worst(skew, -np.swapaxes(skew, -1, -2), np.abs(C).max(initial=0)) <= 1e-13


def _without_friction(model, scene):
    return replace(frictionless(model), gravity=scene.gravity, payloads=scene.payloads)


def _along(model, q, qd):
    out = {}
    for speed, way in zip(qd.T, tangent(model, q), strict=True):
        for entry, rate in way.items():
            out[entry] = out.get(entry, 0.0) + rate * speed
    return out
