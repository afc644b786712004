"""Friction, rotors and springs: what they add at each joint, by their formulas."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import busy_robot
from helpers.oracles import EPS, frictionless, random_state, robot, worst
from helpers.small_robots import built, joint, link

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.mass import mass_matrix
from robodyn.scene.parts import Friction, Rotor, Spring
from robodyn.scene.scene import Scene

GEARED = (
    '<transmission name="t"><joint name="j"/><actuator name="m">'
    "<mechanicalReduction>{}</mechanicalReduction>{}</actuator></transmission>"
)


def hinge(dynamics="", transmission="", kind="revolute"):
    """A massless hinge: its torque is what the joint itself adds."""
    parts = [link("base"), link("arm"), joint("j", "base", "arm", kind, more=dynamics)]
    return built(*parts, *([transmission] if transmission else []))


def tau(model, q=0.0, qd=0.0, qdd=0.0, **scene):
    return float(inverse_dynamics(model, [q], [qd], [qdd], scene=Scene(**scene))[0])


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "continuous"])
def test_friction_of_the_description(kind):
    model = hinge('<dynamics damping="3" friction="5"/>', kind=kind)
    assert [tau(model, qd=qd) for qd in (2.0, -2.0, 1e-300, -1e-300)] == [11.0, -11.0, 5.0, -5.0]
    assert tau(model, qd=0.0) == tau(model, qd=-0.0) == 0.0


def test_the_scene_replaces_the_friction_of_the_description():
    model = hinge('<dynamics damping="3" friction="5"/>')
    assert tau(model, qd=2.0, friction={"j": Friction(viscous=1.0)}) == 2.0
    assert tau(model, qd=2.0, friction={"j": Friction()}) == 0.0


def test_coulomb_friction_at_rest_is_zero_among_samples_that_move():
    model = hinge('<dynamics friction="5"/>')
    qd = np.array([[1.0], [0.0], [-0.0], [-1.0]])
    assert inverse_dynamics(model, np.zeros((4, 1)), qd, 0).ravel().tolist() == [5.0, 0.0, 0.0, -5.0]


def test_asymmetric_coulomb_friction():
    friction = {"j": Friction(forward=0.4, backward=-0.35)}
    values = [tau(hinge(), qd=qd, friction=friction) for qd in (3.0, -3.0, 0.0)]
    assert worst(values, [0.4, -0.35, 0.0]) <= EPS
    one_sided = {"j": Friction(forward=0.4)}
    assert [tau(hinge(), qd=qd, friction=one_sided) for qd in (3.0, -3.0)] == [0.4, 0.0]


@pytest.mark.parametrize("qd", [1e-9, 0.01, 0.05, -0.05, 0.2, -3.0, 40.0])
def test_stribeck_friction(qd):
    friction = {"j": Friction(0.1, 0.4, -0.35, 0.6, 0.05)}
    coulomb = 0.4 if qd > 0 else -0.35
    excess = (0.6 * np.sign(qd) - coulomb) * np.exp(-((qd / 0.05) ** 2))
    assert worst(tau(hinge(), qd=qd, friction=friction), 0.1 * qd + coulomb + excess) <= 4 * EPS


def test_stribeck_friction_at_rest_is_zero():
    assert tau(hinge(), qd=0.0, friction={"j": Friction(0.1, 0.4, -0.35, 0.6, 0.05)}) == 0.0


@pytest.mark.parametrize("gear", [62.6, -62.6, 1.0])
def test_rotor_inertia(gear):
    expected = gear * gear * 2e-4 * 3.0
    assert tau(hinge(), qd=9.0, qdd=3.0, rotor={"j": Rotor(2e-4, gear)}) == expected
    assert tau(hinge(transmission=GEARED.format(gear, "")), qdd=3.0, rotor={"j": Rotor(2e-4)}) == expected
    assert tau(hinge(transmission=GEARED.format(-7, "")), qdd=3.0, rotor={"j": Rotor(2e-4, gear)}) == expected
    geared = hinge(transmission=GEARED.format(gear, "<rotorInertia>2e-4</rotorInertia>"))
    assert tau(geared, qdd=3.0) == expected
    assert mass_matrix(geared, [0.0])[0, 0] == gear * gear * 2e-4


def test_rotor_without_gear_turns_with_the_joint():
    assert tau(hinge(), qdd=3.0, rotor={"j": Rotor(0.5)}) == 1.5
    assert tau(hinge(transmission=GEARED.format(30, "")), qdd=3.0) == 0.0


def test_rotor_inertia_is_on_the_diagonal_of_the_mass_matrix():
    model = robot("puma560")
    q = random_state(model, np.random.default_rng(1), 10)[0]
    scene = Scene(rotor={"elbow": Rotor(2e-4, -53.7)})
    added = np.zeros((6, 6))
    added[2, 2] = 53.7**2 * 2e-4
    assert worst(mass_matrix(model, q, scene=scene), mass_matrix(model, q) + added) <= EPS


def test_spring():
    spring = {"j": Spring(12.0, 0.1)}
    assert tau(hinge(), q=0.1, spring=spring) == 0.0
    assert tau(hinge(), q=0.6, spring=spring) == 12.0 * (0.6 - 0.1)
    assert tau(hinge(), q=-0.4, spring=spring) == 12.0 * (-0.4 - 0.1)


AT_FOLLOWER = [{"spring": Spring(2.0, -0.2)}, {"rotor": Rotor(5e-4, 12.0)}, {"friction": Friction(1.0, 2.0, -1.0)}]


@pytest.mark.parametrize("scene", AT_FOLLOWER, ids=lambda scene: next(iter(scene)))
def test_at_a_mimic_joint_is_reflected_onto_its_master(scene):
    """The follower moves by -2.5 q + 0.3; the work of its own torque is done by the master."""
    model = busy_robot()
    (table, value), *_ = scene.items()
    rng = np.random.default_rng(2)
    state = random_state(model, rng, 30)
    bare = frictionless(model)
    with_it = Scene(**{"friction": bare.friction} | {table: dict(getattr(bare, table)) | {"follower": value}})
    added = inverse_dynamics(model, *state, scene=with_it) - inverse_dynamics(model, *state, scene=bare)
    k = model.rates.index("finger")
    q, qd, qdd = (x[:, k] for x in state)
    own = {
        "spring": 2.0 * (-2.5 * q + 0.3 + 0.2),
        "rotor": 144 * 5e-4 * -2.5 * qdd,
        "friction": -2.5 * qd + np.where(-2.5 * qd > 0, 2.0, -1.0),
    }[table]
    expected = np.zeros_like(added)
    expected[:, k] = -2.5 * own
    assert worst(added, expected, 100.0) <= 4 * EPS
