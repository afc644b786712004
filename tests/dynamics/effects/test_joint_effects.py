"""Friction, rotors and springs: what they add at each joint, by their formulas."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import busy_parts, busy_robot
from helpers.oracles import EPS, frictionless, random_state, run, worst
from helpers.small_robots import body_numbers, built, joint, link, urdf

from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.robot.load import load
from robodyn.scene.scene import Friction, Immersed, Payload, Rotor, Scene, Spring

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
    assert tau(model, qd=2.0, friction={"j": Friction(viscous=1.0)}) == 2.0
    qd = np.array([[1.0], [0.0], [-0.0], [-1.0]])
    assert inverse_dynamics(model, np.zeros((4, 1)), qd, 0).ravel().tolist() == [8.0, 0.0, 0.0, -8.0]


def test_asymmetric_coulomb_friction():
    friction = {"j": Friction(forward=0.4, backward=-0.35)}
    values = [tau(hinge(), qd=qd, friction=friction) for qd in (3.0, -3.0, 0.0)]
    assert worst(values, [0.4, -0.35, 0.0]) <= EPS
    one_sided = {"j": Friction(forward=0.4)}
    assert [tau(hinge(), qd=qd, friction=one_sided) for qd in (3.0, -3.0)] == [0.4, 0.0]


@pytest.mark.parametrize("qd", [1e-9, 0.05, -0.05, 40.0])
def test_stribeck_friction(qd):
    friction = {"j": Friction(0.1, 0.4, -0.35, 0.6, 0.05)}
    coulomb = 0.4 if qd > 0 else -0.35
    excess = (0.6 * np.sign(qd) - coulomb) * np.exp(-((qd / 0.05) ** 2))
    assert worst(tau(hinge(), qd=qd, friction=friction), 0.1 * qd + coulomb + excess) <= 4 * EPS


@pytest.mark.parametrize("gear", [62.6, -62.6, 1.0])
def test_rotor_inertia(gear):
    expected = gear * gear * 2e-4 * 3.0
    assert tau(hinge(), qd=9.0, qdd=3.0, rotor={"j": Rotor(2e-4, gear)}) == expected
    assert tau(hinge(transmission=GEARED.format(gear, "")), qdd=3.0, rotor={"j": Rotor(2e-4)}) == expected
    assert tau(hinge(transmission=GEARED.format(-7, "")), qdd=3.0, rotor={"j": Rotor(2e-4, gear)}) == expected
    geared = hinge(transmission=GEARED.format(gear, "<rotorInertia>2e-4</rotorInertia>"))
    assert tau(geared, qdd=3.0) == expected
    assert tau(hinge(), qdd=3.0, rotor={"j": Rotor(0.5)}) == 1.5
    assert mass_matrix(geared, [0.0])[0, 0] == gear * gear * 2e-4


def test_spring():
    spring = {"j": Spring(12.0, 0.1)}
    assert tau(hinge(), q=0.1, spring=spring) == 0.0
    assert tau(hinge(), q=0.6, spring=spring) == 12.0 * (0.6 - 0.1)
    assert tau(hinge(), q=-0.4, spring=spring) == 12.0 * (-0.4 - 0.1)


AT_FOLLOWER = [{"spring": Spring(2.0, -0.2)}, {"rotor": Rotor(5e-4, 12.0)}, {"friction": Friction(1.0, 2.0, -1.0)}]


@pytest.mark.parametrize("scene", AT_FOLLOWER, ids=lambda scene: next(iter(scene)))
def test_at_a_mimic_joint_is_reflected_onto_its_master(scene):
    """The follower moves by -2.5 q + 0.3; the work of its own torque is done by the leader."""
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


def _numbers(seed):
    m, com, six = body_numbers(np.random.default_rng(seed))
    return m, tuple(com), tuple(six)


@pytest.mark.parametrize("where", ["l0", "tool", "l6"])
def test_is_the_same_as_a_link_fixed_there(where):
    m, com, six = _numbers(3)
    merged = load(urdf(*busy_parts(), link("load", m, com, six), joint("carry", where, "load", "fixed")))
    model, scene = busy_robot(), Scene(payloads=(Payload(where, m, com, six),))
    state = random_state(model, np.random.default_rng(4), 20)
    assert worst(inverse_dynamics(model, *state, scene=scene), inverse_dynamics(merged, *state)) <= 8 * EPS
    assert worst(mass_matrix(model, state[0], scene=scene), mass_matrix(merged, state[0])) <= 8 * EPS
    wrenches = [run(Plan(*pair).wrenches(), Plan(*pair), *state) for pair in ((model, scene), (merged, Scene()))]
    assert worst(*wrenches) <= 8 * EPS


WATER = 1000.0


def test_a_body_of_waters_density_weighs_nothing():
    """Buoyancy is the weight of the displaced water at its centre: a payload of that mass, upside down."""
    model = busy_robot(True)
    q = random_state(model, np.random.default_rng(1), 20)[0]
    volume, centre = 1.3e-3, (0.1, -0.2, 0.3)
    still = Scene(gravity=(1.0, 2.0, -9.0))
    bare = inverse_dynamics(model, q, 0, 0, scene=still)
    scene = Scene(
        still.gravity,
        payloads=(Payload("tool", WATER * volume, centre),),
        immersed=(Immersed("tool", volume, centre),),
        fluid_density=WATER,
    )
    assert worst(inverse_dynamics(model, q, 0, 0, scene=scene), bare) <= 16 * EPS


def test_drag_of_a_swinging_paddle():
    model = built(link("base"), link("paddle"), joint("j", "base", "paddle", axis=(0, 0, 1)))
    area, arm = (0.3, 0.5, 0.7), 0.8
    scene = Scene(immersed=(Immersed("paddle", 0.0, (arm, 0, 0), area),), fluid_density=WATER)
    for qd in (2.0, -2.0, 0.0):
        tau = inverse_dynamics(model, [0.4], [qd], [0.0], scene=scene)[0]
        assert worst(tau, 0.5 * WATER * area[1] * abs(qd * arm) * (qd * arm) * arm) <= 4 * EPS


def test_drag_sees_the_velocity_relative_to_the_stream():
    model = built(link("base"), link("hull"), joint("j", "base", "hull", "prismatic", axis=(1, 0, 0)))
    scene = Scene(immersed=(Immersed("hull", drag_area=(0.2, 0, 0)),), fluid_density=WATER, fluid_velocity=(1.5, 9, 9))
    for qd in (-1.0, 0.0, 1.5, 4.0):
        tau = inverse_dynamics(model, [0.0], [qd], [0.0], scene=scene)[0]
        assert worst(tau, 0.1 * WATER * abs(qd - 1.5) * (qd - 1.5), WATER) <= 4 * EPS
