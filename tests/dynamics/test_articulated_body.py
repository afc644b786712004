"""Forward dynamics by articulated bodies: shared coordinates, costs, refusals; long chains, wide scales, odd bodies."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, EVERY_EFFECT, busy_robot
from helpers.example_robots import real
from helpers.oracles import EPS, frictionless, random_state, robot, run, worst
from helpers.small_robots import (
    body_numbers,
    built,
    chain,
    chain_parts,
    joint,
    link,
    numbers,
    random_tree,
    random_tree_parts,
    urdf,
)

import robodyn
from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.forward import acceleration_program, forward_dynamics
from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.dynamics.plan import Plan, applied, loads
from robodyn.errors import InputError
from robodyn.robot.load import load
from robodyn.scene.scene import DEFAULT, Rotor, Scene
from robodyn.solids.inertia.laws import Inertia


def _agrees(model, seed, scene=DEFAULT):
    """Torques of the accelerations are the torques, within what rounding of M qdd allows."""
    q, qd, tau = random_state(model, np.random.default_rng(seed), 20)
    qdd = forward_dynamics(model, q, qd, tau, scene=scene, executor="numpy")
    M = mass_matrix(model, q, scene=scene)
    called_for = (np.abs(M) @ np.abs(qdd)[..., None]).max()
    assert worst(inverse_dynamics(model, q, qd, qdd, scene=scene), tau, max(called_for, np.abs(tau).max())) <= 1e-14


def _chain(*joints, moving_base=False):
    """Full inertias, one after another on joints that are placed askew but for what is given of them."""
    rng = np.random.default_rng(6)
    parts = [link(f"l{k}", *body_numbers(rng), rng.uniform(-3, 3, 3)) for k in range(len(joints) + 1)]
    askew = {"axis": (0.48, 0.6, 0.64), "xyz": (0.3, 0.2, 0.1), "rpy": (1.0, -0.5, 2.0)}
    parts += [joint(f"j{k}", f"l{k}", f"l{k + 1}", **askew | each) for k, each in enumerate(joints)]
    return built(*parts, moving_base=moving_base)


def _nearly_parallel(angle, axis):
    return _chain(*({"axis": axis, "rpy": (angle, 0.7 * k, 0)} for k in range(3)))


def _with_tip(skew, ratio):
    parts = chain_parts(10, skew)
    moments = (ratio / 400, 0, 0, ratio * 1.015 / 12, 0, ratio * 1.015 / 12)
    parts[-2] = link("l10", ratio, (0.5, 0, 0), moments)
    return built(*parts)


IN_THE_MIDDLE = {}, {"kind": "floating"}, {"kind": "prismatic"}
ANGLES = 0.0, 1e-12, 2e-6, np.pi - 1e-9
TREES = {
    "a body that falls free of a fixed one": lambda: _chain(*IN_THE_MIDDLE),
    "a body that falls free of a moving one": lambda: _chain(*IN_THE_MIDDLE, moving_base=True),
    "planar joints": lambda: _chain({"kind": "planar"}, {"kind": "planar", "axis": (0.6, 0, 0.8)}),
    **{f"axes nearly parallel, {x}": lambda x=x: _nearly_parallel(x, (0, 0, 1)) for x in ANGLES},
    **{f"skew axes nearly parallel, {x}": lambda x=x: _nearly_parallel(x, (0.48, 0.6, 0.64)) for x in ANGLES},
    "a chain with a light tip": lambda: _with_tip(False, 1e-12),
    "a skew chain": lambda: _with_tip(True, 1.0),
    "a skew chain with a heavy tip": lambda: _with_tip(True, 1e12),
    "a random tree": lambda: random_tree(0, 9),
    "a random tree that floats": lambda: random_tree(1, 9, moving_base=True),
}


@pytest.mark.parametrize("name", TREES)
def test_round_trips(name):
    _agrees(TREES[name](), 7)


def test_a_rotor_far_heavier_than_the_links():
    model = random_tree(3, 6, kinds=("revolute",))
    _agrees(model, 13, Scene(rotor=dict.fromkeys(model.joint_names, Rotor(1e9))))


MIMICS = {
    "siblings": {4: (3, -1.5)},
    "a follower beyond its leader": {3: (1, 2.0)},
    "a follower before its leader": {2: (5, -0.7)},
    "three on one branch": {2: (1, 0.5), 5: (1, -2.0)},
    "branches that meet at the base": {4: (1, 1.0), 6: (1, -1.0), 7: (6, 3.0)},
    "pairs across each other": {3: (1, 0.8), 5: (2, -1.2), 7: (4, 2.0)},
    "pairs within each other": {6: (1, 0.9), 5: (2, 1.1), 4: (3, -1.3)},
}


def _mimicking(followers, moving_base=False):
    """A tree of skew joints: 1-2-5 and 1-3, 1-4 on one side, 6-7 on the other."""
    rng = np.random.default_rng(10)
    parents = {1: 0, 2: 1, 3: 1, 4: 1, 5: 2, 6: 0, 7: 6}
    parts = [link(f"l{k}", *body_numbers(rng), rng.uniform(-3, 3, 3)) for k in range(8)]
    for k, parent in parents.items():
        more = '<dynamics damping="0.3" friction="0.2"/>'
        if k in followers:
            leader, ratio = followers[k]
            more += f'<mimic joint="j{leader}" multiplier="{numbers([ratio])}" offset="0.1"/>'
        placed = {"axis": rng.normal(size=3), "xyz": rng.uniform(-1, 1, 3), "rpy": rng.uniform(-3, 3, 3)}
        parts.append(joint(f"j{k}", f"l{parent}", f"l{k}", ("revolute", "prismatic")[k % 2], **placed, more=more))
    return built(*parts, moving_base=moving_base)


@pytest.mark.parametrize(("name", "free"), [(name, k % 2 == 1) for k, name in enumerate(MIMICS)])
def test_shared_coordinates(name, free):
    model = _mimicking(MIMICS[name], free)
    assert model.n == 7 - len(MIMICS[name]) + 6 * free
    _agrees(model, 11, Scene(rotor={"j4": Rotor(0.3), "j1": Rotor(0.2, 2.0), "j2": Rotor(0.1)} if free else {}))


BASE, HINGE = link("l0"), joint("j1", "l0", "l1")
SINGULAR = {
    "a massless leaf": ([BASE, link("l1"), HINGE], "j1"),
    "a massless slide": (
        [BASE, link("l1", 1, (0.1, 0, 0)), link("l2"), HINGE, joint("j2", "l1", "l2", "prismatic")],
        "j2",
    ),
    "a point on the axis": ([BASE, link("l1", 2, (0.3, 0.6, 0.9)), joint("j1", "l0", "l1", axis=(1, 2, 3))], "j1"),
    "a massless finger of two": (
        [
            *(link(f"l{k}") for k in range(3)),
            joint("j1", "l0", "l1"),
            joint("j2", "l0", "l2", more='<mimic joint="j1" multiplier="2"/>'),
        ],
        "j1",
    ),
}


@pytest.mark.parametrize("name", SINGULAR)
def test_names_the_joint_that_nothing_resists(name):
    parts, culprit = SINGULAR[name]
    model = built(*parts)
    for q in (0.3, np.full((5, model.n), 0.4)):
        with pytest.raises(InputError) as caught:
            forward_dynamics(model, q, 0.1, 0.2)
        assert str(caught.value) == (
            f'joint "{culprit}" moves nothing that has inertia, so its acceleration is not defined '
            "(give a link that it carries mass and inertia, or the joint a rotor)"
        )
    assert np.isfinite(forward_dynamics(model, 0.3, 0.1, 0.2, scene=Scene(rotor={culprit: Rotor(0.1)}))).all()


def test_a_point_that_two_axes_meet_is_refused_where_they_meet():
    """Two coaxial turns of a point mass resist at most one acceleration."""
    parts = [link(f"l{k}") for k in range(3)] + [link("l3", 1.0, (0.5, 0, 0))]
    parts += [joint("j1", "l0", "l1"), joint("j2", "l1", "l2", axis=(0, 1, 0)), joint("j3", "l2", "l3")]
    model = built(*parts)
    q = np.tile([0.3, 1.0, 0.2], (5, 1))
    assert np.isfinite(forward_dynamics(model, q, 0.0, 1.0)).all()
    q[3, 1] = 0.0
    with pytest.raises(InputError, match=r"sample 3 has no finite accelerations: hardly anything resists \"j[13]\""):
        forward_dynamics(model, q, 0.0, 1.0)


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


slow = pytest.mark.slow
LARGE = {
    "two joints": lambda: chain(2),
    "forty joints": lambda: chain(40, True),
    "a hundred equal ones": pytest.param(lambda: chain(100), marks=slow),
    "a hundred of every kind": pytest.param(lambda: random_tree(40, 100, branching=3), marks=slow),
    "masses that fall by twenty-four decades": lambda: chain(9, skew=True, taper=1e-3),
    "masses that rise by as many": lambda: chain(9, skew=True, taper=1e3),
}


@pytest.mark.parametrize("make", LARGE.values(), ids=LARGE)
def test_every_torque_and_wrench_against_sixty_digits(make):
    model = make()
    state = _states(model, 42)
    plan = Plan(model, Scene())
    tau, wrenches = _exact(model, *state)
    assert worst(inverse_dynamics(model, *state), tau) <= 1e-14
    found = run(plan.wrenches(joints=True), plan, *state)[:, model.n :].reshape(wrenches.shape)
    assert worst(found[:, :, 0], wrenches[:, :, 0]) <= 1e-14
    assert worst(found[:, :, 1], wrenches[:, :, 1]) <= 1e-14


def test_small_torques_beside_large_ones():
    model = chain(9, skew=True, taper=1e-3)
    state = _states(model, 42)
    expected = next(_exact(model, *state))
    assert np.max(np.abs(inverse_dynamics(model, *state) - expected) / np.abs(expected)) <= 1e-12


def _exact(model, *states):
    """Torques (N, n) and wrenches (N, joints, 2, 3) by the same recursion in 60 digits, and not from rounded sums."""
    plan, found = Plan(model, Scene()), []
    with mpmath.workdps(60):
        for row in zip(*states, strict=True):
            sample = Sample(model, *(tuple(mpmath.mpf(x) for x in part.tolist()) for part in row))
            terms = applied(plan.effects, sample, Scene())
            inertias = tuple(Inertia(*(x * mpmath.mpf(1) for x in body)) for body in terms.inertias)
            found.append(loads(sample, replace(terms, inertias=inertias)))
    return (np.array(part, dtype=float) for part in zip(*found, strict=True))


def _states(model, seed):
    return random_state(model, np.random.default_rng(seed), 2)


def test_a_base_a_thousand_kilometres_away():
    """A world link carries the robot by a fixed joint: not one bit of tau changes."""
    parts = random_tree_parts(np.random.default_rng(47), 8)
    here = load(urdf(link("world"), *parts, joint("mount", "world", "l0", "fixed")))
    there = load(urdf(link("world"), *parts, joint("mount", "world", "l0", "fixed", xyz=(-7e5, 3e5, 1e6))))
    state = _states(here, 48)
    np.testing.assert_array_equal(inverse_dynamics(there, *state), inverse_dynamics(here, *state))


def test_non_unit_axes_are_normalised_with_a_note():
    arm = link("arm", 2, (0.5, 0.1, 0.2), (0.1, 0, 0, 0.2, 0, 0.3))
    for axis in ((0, 3, 4), (0, 3e-200, 4e-200), (0, 3e29, 4e29)):
        model = built(link("base"), arm, joint("j", "base", "arm", axis=axis))
        assert worst(model.bodies[1].joint.axis, [0, 0.6, 0.8]) <= 2 * EPS
        assert any("length" in note for note in model.notes)
    unit = built(link("base"), arm, joint("j", "base", "arm", axis=(0, 0.6, 0.8)))
    assert not unit.notes


def test_a_massless_leaf_feels_nothing():
    model = built(link("base"), link("leaf"), joint("j", "base", "leaf"))
    assert not inverse_dynamics(model, *_states(model, 53)).any()
    assert not mass_matrix(model, [0.3]).any()
    assert Plan(model, Scene()).torques().size == 0


@pytest.mark.parametrize(
    ("inertia", "why"),
    [
        ((0.1, 0, 0, 0.1, 0, -0.2), "a principal moment of inertia is negative (-0.2 kg m^2)"),
        ((0.1, 0, 0, 0.2, 0, 0.5), "principal moments 0.1 + 0.2 < 0.5 kg m^2 break the triangle inequality"),
    ],
)
def test_unphysical_inertia_is_computed_and_noted(inertia, why):
    model = built(link("base"), link("arm", 2, (0.5, 0, 0), inertia), joint("j", "base", "arm"))
    noted = [note for note in model.notes if "computed as given" in note]
    assert noted == [f'link "arm" (line 4): {why}; computed as given']
    tau = inverse_dynamics(model, [0.0], [0.0], [1.0])
    assert worst(tau, [2 * 0.25 + inertia[5]]) <= EPS
