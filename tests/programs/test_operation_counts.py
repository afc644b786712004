"""What a sample costs, as counts of operations: upper bounds, and what is absent costs nothing."""

from __future__ import annotations

import pytest
from helpers.example_robots import real
from helpers.oracles import frictionless, robot
from helpers.small_robots import chain

from robodyn.dynamics.function import KINDS
from robodyn.dynamics.plan import EFFECTS, Plan
from robodyn.scene.scene import ExternalWrench, Friction, Payload, Rotor, Scene, Spring


def at_rest(model):
    return frozenset((source, i) for source in ("qd", "qdd") for i in range(model.n))


def size(model, scene=None, zero_columns=frozenset()):
    return Plan(model, frictionless(model) if scene is None else scene, zero_columns).torques().size


@pytest.mark.parametrize("name", ["panda", "anymal", "puma560", "two_link_spatial"])
def test_rest_constant_speed_and_weightlessness_are_cheaper(name):
    """How many operations there are is in the documentation, and tested with it."""
    model = real(name) if name in ("panda", "anymal") else robot(name)
    steady = frozenset(("qdd", i) for i in range(model.n))
    weightless = frictionless(model, gravity=(0.0, 0.0, 0.0))
    whole = size(model)
    assert size(model, zero_columns=at_rest(model)) < size(model, zero_columns=steady) < whole
    assert size(model, weightless) <= whole
    assert size(model, weightless, at_rest(model)) == 0


def test_rows_of_derivatives_go_the_shorter_way():
    a_plan = Plan(robot("puma"), Scene())
    most = {"coriolis_matrix": 289, "inverse_dynamics_derivatives": 674, "forward_dynamics_derivatives": 1093}
    for kind, count in most.items():
        assert KINDS[kind].program(a_plan).size <= count


def test_operations_grow_linearly():
    """Ten more links cost the same wherever they are added, and less than half where all axes are parallel."""
    assert 2 * size(chain(8)) < size(chain(8, skew=True))
    counts = [size(chain(n, skew=True)) for n in (10, 20, 30, 40)]
    assert counts[1] - counts[0] == counts[2] - counts[1] == counts[3] - counts[2]


SCENES = {
    "payload": Scene(payloads=(Payload("flange", 2.5, (0, 0, 0.1)),)),
    "viscous friction": Scene(friction={"waist": Friction(viscous=2.0)}),
    "coulomb friction": Scene(friction={"waist": Friction(forward=2.0, backward=-2.0)}),
    "rotor inertia": Scene(rotor={"elbow": Rotor(1e-4, 50.0)}),
    "joint spring": Scene(spring={"elbow": Spring(10.0, 0.1)}),
    "external wrench": Scene(wrenches=(ExternalWrench("flange", (1, 2, 3)),)),
}
FREE = ("payload",)
"""It only changes the numbers of a body that has mass."""
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
    bare = size(model, Scene())
    assert size(model, SCENES[name]) > bare or name in FREE
    assert Plan(model, NOTHING[name]).torques() == Plan(model, Scene()).torques()
    effect = next(effect for effect in EFFECTS if effect.name == name)
    assert Plan(model, SCENES[name]).without(effect).size == bare
    scene = Scene(friction={name: Friction(1.0, 2.0, -2.0, 3.0) for name in model.joint_names})
    assert size(model, scene, at_rest(model)) == size(model, Scene(), at_rest(model)), "friction at rest is free"
