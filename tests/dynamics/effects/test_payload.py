"""Payloads against the same mass written into the description, and taken away again."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import busy_parts, busy_robot
from helpers.oracles import EPS, random_state, run, worst
from helpers.small_robots import body_numbers, joint, link, urdf

from robodyn.dynamics.effects import rigid_bodies
from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.mass import mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.robot.load import load
from robodyn.scene.parts import Payload
from robodyn.scene.scene import Scene


def _numbers(seed):
    m, com, six = body_numbers(np.random.default_rng(seed))
    return m, tuple(com), tuple(six)


@pytest.mark.parametrize("where", ["l0", "l1", "l3", "tool", "l6"])
def test_is_the_same_as_a_link_fixed_there(where):
    m, com, six = _numbers(3)
    merged = load(urdf(*busy_parts(), link("load", m, com, six), joint("carry", where, "load", "fixed")))
    model, scene = busy_robot(), Scene(payloads=(Payload(where, m, com, six),))
    state = random_state(model, np.random.default_rng(4), 20)
    assert worst(inverse_dynamics(model, *state, scene=scene), inverse_dynamics(merged, *state)) <= 8 * EPS
    assert worst(mass_matrix(model, state[0], scene=scene), mass_matrix(merged, state[0])) <= 8 * EPS
    wrenches = [run(Plan(*pair).wrenches(), Plan(*pair), *state) for pair in ((model, scene), (merged, Scene()))]
    assert worst(*wrenches) <= 8 * EPS


def test_is_reversible():
    """A load and its negative leave the robot as it was; so does a scene without it."""
    m, com, six = _numbers(5)
    model = busy_robot()
    state = random_state(model, np.random.default_rng(6), 20)
    both = Payload("tool", m, com, six), Payload("tool", -m, com, tuple(-x for x in six))
    bare = inverse_dynamics(model, *state)
    assert worst(inverse_dynamics(model, *state, scene=Scene(payloads=both)), bare) <= 16 * EPS
    inverse_dynamics(model, *state, scene=Scene(payloads=both[:1]))
    np.testing.assert_array_equal(inverse_dynamics(model, *state), bare)


def test_several_loads_add_up():
    model = busy_robot()
    state = random_state(model, np.random.default_rng(7), 20)
    loads = tuple(Payload(where, *_numbers(k)) for k, where in enumerate(("l1", "tool", "tool", "l5")))
    bare = inverse_dynamics(model, *state)
    apart = sum(inverse_dynamics(model, *state, scene=Scene(payloads=(one,))) - bare for one in loads)
    assert worst(inverse_dynamics(model, *state, scene=Scene(payloads=loads)) - bare, apart) <= 1e-14
    plan = Plan(model, Scene(payloads=loads))
    assert worst(run(plan.share(rigid_bodies.PAYLOAD), plan, *state), apart) <= 1e-14


def test_a_point_mass_hanging_from_a_hinge():
    model = load(urdf(link("base"), link("arm"), joint("j", "base", "arm", axis=(0, 1, 0))))
    scene = Scene(payloads=(Payload("arm", 2.0, (0.5, 0, 0)),))
    assert inverse_dynamics(model, [0.0], [0.0], [3.0], scene=scene)[0] == 2.0 * 0.25 * 3.0 - 2.0 * 9.81 * 0.5
    assert mass_matrix(model, [0.7], scene=scene)[0, 0] == 0.5
