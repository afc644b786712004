"""What a sample costs, as counts of operations: upper bounds, and what is absent costs nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.example_robots import real
from helpers.oracles import frictionless, robot
from helpers.small_robots import body_numbers, built, chain, chain_parts, joint, link, random_tree

from robodyn.dynamics.plan import EFFECTS, Plan
from robodyn.scene.parts import ExternalWrench, Friction, Payload, Rotor, Spring
from robodyn.scene.scene import Scene

MOVING_AND_AT_REST = {
    "ur5_robot": (371, 131),
    "panda": (891, 258),
    "anymal": (1020, 304),
    "talos_reduced": (3777, 1082),
    "scara": (45, 0),
    "puma": (221, 55),
    "puma560": (409, 132),
    "cylindrical": (40, 0),
    "two_link_planar": (36, 22),
    "two_link_spatial": (41, 3),
}


def at_rest(model):
    return frozenset((source, i) for source in ("qd", "qdd") for i in range(model.n))


def size(model, scene=None, zero_columns=frozenset()):
    return Plan(model, frictionless(model) if scene is None else scene, zero_columns).torques().size


def own(name):
    return real(name) if name in ("ur5_robot", "panda", "anymal", "talos_reduced") else robot(name)


@pytest.mark.parametrize("name", MOVING_AND_AT_REST)
def test_upper_bounds(name):
    model = own(name)
    moving, resting = MOVING_AND_AT_REST[name]
    assert size(model) <= moving
    assert size(model, zero_columns=at_rest(model)) <= resting


@pytest.mark.parametrize("name", MOVING_AND_AT_REST)
def test_rest_constant_speed_and_no_gravity_are_cheaper(name):
    model = own(name)
    steady = frozenset(("qdd", i) for i in range(model.n))
    assert size(model, zero_columns=at_rest(model)) < size(model, zero_columns=steady) < size(model)
    assert size(model, frictionless(model, gravity=(0.0, 0.0, 0.0))) <= size(model)
    assert size(model, frictionless(model, gravity=(0.0, 0.0, 0.0)), at_rest(model)) == 0


def test_planar_chains_are_cheaper_than_skew_ones():
    planar, skew = size(chain(8)), size(chain(8, skew=True))
    assert 2 * planar < skew


def test_operations_grow_linearly():
    """Ten more links cost the same wherever they are added."""
    counts = [size(chain(n, skew=True)) for n in (10, 20, 30, 40)]
    assert counts[1] - counts[0] == counts[2] - counts[1] == counts[3] - counts[2]


def test_a_full_body_costs_more_than_a_plain_or_a_massless_one():
    def tip(text):
        return size(built(*chain_parts(3, skew=True), text, joint("j4", "l3", "l4", xyz=(1, 0, 0), rpy=(1.0, 0, 0))))

    full = tip(link("l4", *body_numbers(np.random.default_rng(0))))
    plain = tip(link("l4", 1, (0, 0, 0.3), (0.1, 0, 0, 0.2, 0, 0.3)))
    centred = tip(link("l4", 1, (0, 0, 0), (0.1, 0, 0, 0.1, 0, 0.1)))
    assert tip(link("l4")) < centred < plain < full
    assert tip(link("l4")) == size(chain(3, skew=True))


def test_a_massless_leaf_is_free_wherever_it_hangs():
    parts = [*chain_parts(3, skew=True), link("tool"), joint("t", "l3", "tool", axis=(0.6, 0, 0.8), rpy=(1, 2, 3))]
    assert size(built(*parts)) == size(chain(3, skew=True))


SCENES = {
    "payload": Scene(payloads=(Payload("flange", 2.5, (0, 0, 0.1)),)),
    "viscous friction": Scene(friction={"waist": Friction(viscous=2.0)}),
    "coulomb friction": Scene(friction={"waist": Friction(forward=2.0, backward=-2.0)}),
    "rotor inertia": Scene(rotor={"elbow": Rotor(1e-4, 50.0)}),
    "joint spring": Scene(spring={"elbow": Spring(10.0, 0.1)}),
    "external wrench": Scene(wrenches=(ExternalWrench("flange", (1, 2, 3)),)),
}
NOTHING = {
    "payload": Scene(payloads=(Payload("flange", 0.0, (0, 0, 0.1)),)),
    "viscous friction": Scene(friction={"waist": Friction()}),
    "coulomb friction": Scene(friction={"waist": Friction()}),
    "rotor inertia": Scene(rotor={"elbow": Rotor(0.0, 50.0)}),
    "joint spring": Scene(spring={"elbow": Spring(0.0, 0.1)}),
    "external wrench": Scene(wrenches=(ExternalWrench("flange"),)),
}


@pytest.mark.parametrize("name", SCENES)
def test_an_absent_effect_costs_nothing(name):
    model = robot("puma560")
    assert size(model, SCENES[name]) >= size(model, Scene())
    assert size(model, NOTHING[name]) == size(model, Scene())
    assert Plan(model, NOTHING[name]).torques() == Plan(model, Scene()).torques()
    effect = next(effect for effect in EFFECTS if effect.name == name)
    assert Plan(model, SCENES[name]).without(effect).size == size(model, Scene())


@pytest.mark.parametrize("name", [name for name in SCENES if name != "payload"])
def test_a_present_effect_costs_something(name):
    """A payload alone may cost nothing: it only changes the numbers of a body that has mass."""
    model = robot("puma560")
    assert size(model, SCENES[name]) > size(model, Scene())


def test_a_payload_on_a_body_of_full_inertia_is_free():
    model = random_tree(2, 4)
    loaded = Scene(payloads=(Payload("l4", 1.0, (0.1, 0.2, 0.3)),))
    assert size(model, loaded) == size(model, Scene())


def test_friction_at_rest_is_free():
    model = robot("puma560")
    scene = replace(Scene(), friction={name: Friction(1.0, 2.0, -2.0, 3.0) for name in model.joint_names})
    assert size(model, scene, at_rest(model)) == size(model, Scene(), at_rest(model))
