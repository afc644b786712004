"""Long chains, wide scales, far places, odd axes, massless and unphysical bodies."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from helpers.oracles import EPS, random_state, run, worst
from helpers.small_robots import built, chain, joint, link, random_tree, random_tree_parts, urdf

from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.dynamics.plan import Plan, applied, loads
from robodyn.robot.load import load
from robodyn.scene.scene import Scene
from robodyn.solids.inertia.laws import Inertia

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
