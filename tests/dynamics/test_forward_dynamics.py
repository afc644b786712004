"""The Python interface of forward dynamics: shapes, errors, executors, and what a sample costs."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, EVERY_EFFECT, busy_robot
from helpers.compiled_programs import bits, needs_compiler
from helpers.example_robots import real
from helpers.factorised import forward_by_factorisation
from helpers.oracles import EPS, frictionless, golden_model, random_state, robot, worst
from helpers.small_robots import built, chain, chain_parts, link, random_tree

import robodyn
from robodyn.dynamics.forward import acceleration_program, forward_dynamics
from robodyn.dynamics.inverse import bias_forces, inverse_dynamics
from robodyn.dynamics.mass import mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.programs.run.multiprecision import Multiprecision
from robodyn.scene.parts import ExternalWrench, Friction, Immersed, Payload, Rotor, Spring
from robodyn.scene.scene import Scene

MODEL = golden_model("puma560_corke")
STATE = random_state(MODEL, np.random.default_rng(5), 3000)


@pytest.mark.parametrize("moving_base", [False, True])
@pytest.mark.parametrize(("scene", "times"), [(BUSY_SCENE, 16), (EVERY_EFFECT, 128)], ids=["busy", "motors"])
def test_it_undoes_inverse_dynamics_with_every_effect(moving_base, scene, times):
    model, rng = busy_robot(moving_base), np.random.default_rng(1)
    q, qd, qdd = random_state(model, rng, 20)
    more = {"scene": scene, "columns": {name: rng.normal(size=20) for name in scene.columns}}
    tau = inverse_dynamics(model, q, qd, qdd, **more)
    cond = np.linalg.cond(mass_matrix(model, q, scene=scene)).max()
    assert worst(robodyn.forward_dynamics(model, q, qd, tau, **more), qdd) <= times * EPS * cond
    assert worst(forward_by_factorisation(model, q, qd, tau, **more), qdd) <= times * EPS * cond
    assert worst(inverse_dynamics(model, q, qd, forward_dynamics(model, q, qd, tau, **more), **more), tau) <= 1e-14


def test_shapes():
    q = np.full((2, 3, 4, 6), 0.3)
    assert forward_dynamics(MODEL, q, 0, 0).shape == (2, 3, 4, 6)
    assert forward_dynamics(MODEL, q[0, 0, 0], 0, 0).shape == (6,)
    assert forward_dynamics(MODEL, q[0], q, q[0, 0, 0]).shape == (2, 3, 4, 6)
    assert forward_dynamics(MODEL, q[:0], 0, 0).shape == (0, 3, 4, 6)
    assert forward_by_factorisation(MODEL, q[0], 0, q).shape == (2, 3, 4, 6)


WRONG = {
    "q has 5 columns, the robot has 6": ([0] * 5, 0, 0),
    "qd has 7 columns, the robot has 6": (0, [0] * 7, 0),
    "tau has 1 columns, the robot has 6": (0, 0, [0]),
    "the shapes do not go together": (np.zeros((2, 6)), np.zeros((3, 6)), 0),
}


@pytest.mark.parametrize("message", WRONG)
def test_wrong_shapes(message):
    with pytest.raises(InputError, match=message):
        forward_dynamics(MODEL, *WRONG[message])


def test_wrong_arguments():
    with pytest.raises(InputError, match="out has shape"):
        forward_dynamics(MODEL, *STATE, out=np.empty((2, 6)))
    with pytest.raises(InputError, match="there is no executor 'gpu'"):
        forward_dynamics(MODEL, *STATE, executor="gpu")
    with pytest.raises(InputError, match="dtype int64 is not offered"):
        forward_dynamics(MODEL, *STATE, dtype=np.int64)
    with pytest.raises(InputError, match="the quaternion of base is zero"):
        forward_dynamics(busy_robot(True), 0, 0, 0)


def test_numbers_that_are_not_finite_pass_through():
    """As in inverse dynamics, they spoil their own sample and no other."""
    q, qd, tau = (x[:9].copy() for x in STATE)
    right = forward_dynamics(MODEL, q, qd, tau)
    tau[4, 2] = np.nan
    found = forward_dynamics(MODEL, q, qd, tau)
    assert np.isnan(found[4]).any()
    np.testing.assert_array_equal(np.delete(found, 4, axis=0), np.delete(right, 4, axis=0))


@needs_compiler
def test_neither_threads_nor_layout_nor_company_change_a_bit():
    right = forward_dynamics(MODEL, *STATE, executor="compiled", threads=1)
    cond = np.linalg.cond(mass_matrix(MODEL, STATE[0])).max()
    assert worst(right, forward_dynamics(MODEL, *STATE, executor="numpy")) <= EPS * cond
    out = np.empty_like(right, order="C")
    assert forward_dynamics(MODEL, *STATE, executor="compiled", threads=3, out=out) is out
    np.testing.assert_array_equal(bits(out), bits(right))
    part = forward_dynamics(MODEL, *(np.asfortranarray(x[1000:1009]) for x in STATE), executor="compiled")
    np.testing.assert_array_equal(bits(part), bits(right[1000:1009]))


def test_the_multiprecision_executor():
    plan = Plan(MODEL, Scene())
    sources = dict(zip(("q", "qd", "tau"), (x[:3] for x in STATE), strict=True))
    found = Multiprecision(acceleration_program(plan), digits=40)(sources, 3).astype(float)
    assert (
        worst(found, forward_dynamics(MODEL, *sources.values()))
        <= 4 * EPS * np.linalg.cond(mass_matrix(MODEL, STATE[0][:3])).max()
    )


BOUNDS = {"ur5_robot": (691, 1174), "panda": (1607, 2417), "anymal": (1674, 3896), "talos_reduced": (7506, 9804)}


@pytest.mark.parametrize("name", BOUNDS)
def test_upper_bounds_of_operations(name):
    """With a fixed base and a free one."""
    for free, bound in zip((False, True), BOUNDS[name], strict=True):
        model = real(name, free)
        assert acceleration_program(Plan(model, frictionless(model))).size <= bound


ABSENT = {
    "viscous and Coulomb friction": {"friction": {"elbow": Friction(0.1, 0.2, -0.3)}},
    "rotor": {"rotor": {"elbow": Rotor(0.1)}},
    "spring": {"spring": {"elbow": Spring(2.0, 0.1)}},
    "external wrench": {"wrenches": (ExternalWrench("flange", (1.0, 2.0, 3.0)),)},
    "fluid": {"immersed": (Immersed("flange", 0.1, (0, 0, 0), (1, 1, 1)),), "fluid_density": 1000.0},
}
NOTHING = {
    "viscous and Coulomb friction": {"friction": {"elbow": Friction()}},
    "rotor": {"rotor": {"elbow": Rotor(0.0, -50.0)}},
    "spring": {"spring": {"elbow": Spring(0.0, 0.7)}},
    "external wrench": {"wrenches": (ExternalWrench("flange", point=(1, 2, 3)),)},
    "fluid": {"immersed": (Immersed("flange", 0.0, (1, 2, 3)),), "fluid_density": 1000.0},
}


def _size(model, zero_columns=frozenset(), **scene):
    bare = frictionless(model)
    friction = {**bare.friction, **scene.pop("friction", {})}
    return acceleration_program(Plan(model, Scene(friction=friction, **scene), zero_columns)).size


@pytest.mark.parametrize("name", ABSENT)
def test_an_absent_effect_costs_no_operation(name):
    model = robot("puma560")
    assert _size(model, **NOTHING[name]) == _size(model) < _size(model, **ABSENT[name])


def test_a_payload_costs_what_its_link_would_cost_with_its_mass():
    model = robot("puma560")
    heavier = _size(model, payloads=(Payload("flange", 1.0, (0.1, 0.2, 0.3), (1, 0.1, 0.1, 1, 0.1, 1)),))
    assert _size(model, payloads=(Payload("flange", 0.0, (0.3, 0.2, 0.1)),)) == _size(model) < heavier


def test_rest_weightlessness_and_no_torque_are_cheaper():
    model = robot("puma560")
    names = {source: frozenset((source, i) for i in range(6)) for source in ("qd", "tau")}
    weightless = {"gravity": (0.0, 0.0, 0.0)}
    assert _size(model, names["qd"]) < _size(model)
    assert _size(model, names["tau"]) < _size(model)
    assert _size(model, **weightless) < _size(model)
    assert _size(model, names["qd"] | names["tau"], **weightless) == 0


@pytest.mark.parametrize("name", NOTHING)
def test_zero_coefficients_leave_every_bit(name):
    model = robot("puma560")
    state = random_state(model, np.random.default_rng(1), 100)
    scene = {**NOTHING[name], "friction": frictionless(model).friction}
    found = forward_dynamics(model, *state, scene=Scene(**scene))
    np.testing.assert_array_equal(found, forward_dynamics(model, *state, scene=frictionless(model)))


SAMPLES = 10


def _residuals(model, seed, solve=forward_dynamics):
    """Of torques of a motion, normwise; of any torques, of the largest entry of |M| |qdd| + |bias| + |tau|."""
    q, qd, given = random_state(model, np.random.default_rng(seed), SAMPLES)
    tau = inverse_dynamics(model, q, qd, given)
    back = inverse_dynamics(model, q, qd, solve(model, q, qd, tau))
    M, bias = mass_matrix(model, q), bias_forces(model, q, qd)
    qdd = solve(model, q, qd, given)
    called_for = (np.abs(M) @ np.abs(qdd)[..., None])[..., 0] + np.abs(bias) + np.abs(given)
    off = np.abs(inverse_dynamics(model, q, qd, qdd) - given)
    return worst(back, tau), (off.max(axis=1) / called_for.max(axis=1)).max()


LONG = [pytest.param(100, skew, marks=pytest.mark.slow) for skew in (False, True)]


@pytest.mark.parametrize(("n", "skew"), [(2, False), (10, False), (2, True), (30, True), *LONG])
def test_chains(n, skew):
    assert max(_residuals(chain(n, skew), n)) <= 1e-14


@pytest.mark.slow
def test_a_hundred_joints_of_every_kind():
    assert max(_residuals(random_tree(40, 100, branching=3), 41)) <= 1e-14


def _with_tip(n, skew, ratio):
    """A chain of equal links, the last of which is `ratio` times as heavy."""
    parts = chain_parts(n, skew)
    moments = (ratio / 400, 0, 0, ratio * 1.015 / 12, 0, ratio * 1.015 / 12)
    parts[-2] = link(f"l{n}", ratio, (0.5, 0, 0), moments)
    return built(*parts)


RATIOS = [1e-12, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9, 1e12]
LONG_CHAIN = [pytest.param(100, False, ratio, marks=pytest.mark.slow) for ratio in (1e-12, 1e12)]


@pytest.mark.parametrize(
    ("n", "skew", "ratio"), [*product((2, 10), (False, True), RATIOS), *LONG_CHAIN, (30, True, 1e12)]
)
def test_tips(n, skew, ratio):
    assert max(_residuals(_with_tip(n, skew, ratio), n)) <= 1e-14


@pytest.mark.parametrize("taper", [10.0**-1.5, 10.0**1.5])
@pytest.mark.parametrize("skew", [False, True], ids=["planar", "skew"])
def test_tapering_chains(taper, skew):
    """Twelve decades from the first of nine links to the last."""
    assert max(_residuals(chain(9, skew, taper=taper), 42)) <= 1e-14


def test_a_straight_chain_moves_as_well_as_a_bent_one():
    model = chain(30)
    tau = np.random.default_rng(2).uniform(-3, 3, (SAMPLES, model.n))
    qdd = forward_dynamics(model, np.zeros_like(tau), 0.0, tau)
    called_for = (np.abs(mass_matrix(model, np.zeros(model.n))) @ np.abs(qdd.T)).max()
    assert worst(inverse_dynamics(model, 0 * tau, 0.0, qdd), tau, called_for) <= 1e-14


@pytest.mark.parametrize("scale", [1e-75, 1e-8, 1e8, 1e75])
def test_scales_of_torque(scale):
    """At rest without gravity qdd is linear in tau."""
    model, weightless = random_tree(43), Scene(gravity=(0.0, 0.0, 0.0), friction={})
    q, _, tau = random_state(model, np.random.default_rng(44), 10)
    qdd = forward_dynamics(model, q, 0.0, tau, scene=weightless)
    assert worst(forward_dynamics(model, q, 0.0, scale * tau, scene=weightless) / scale, qdd) <= 64 * EPS


def test_single_precision():
    model = random_tree(45, 6)
    q, qd, tau = random_state(model, np.random.default_rng(46), 100)
    exact = forward_dynamics(model, q, qd, tau)
    found = forward_dynamics(model, q, qd, tau, dtype=np.float32)
    assert found.dtype == np.float32
    assert 1e-9 < worst(found, exact) <= np.finfo(np.float32).eps * np.linalg.cond(mass_matrix(model, q)).max()
