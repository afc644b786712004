"""Shares add up to the whole and scale as their effects do; those without coefficients change no program."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.example_robots import real
from helpers.oracles import golden_model, random_state, robot, run, worst
from helpers.robot_files import FOLDER

from robodyn.dynamics.effects import rigid_bodies
from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.inverse import inverse_dynamics, mass_runner
from robodyn.dynamics.plan import EFFECTS, Plan
from robodyn.scene.read import load_scene
from robodyn.scene.scene import CoupledMotor, ExternalWrench, Friction, Immersed, Payload, Rotor, Scene, Spring

SAMPLES = 20


def _columns(scene, rng):
    return {name: rng.normal(size=SAMPLES) for name in scene.columns}


SPINNING = {**BUSY_SCENE.rotor, "slide": Rotor(3e-4, -40.0, (0.0, 1.0, 0.2), "tool")}
COUPLED_TOO = replace(
    BUSY_SCENE,
    rotor=SPINNING,
    coupled=(CoupledMotor("m", {"j1": 1.0, "j2": -0.5}, 1e-3, 20.0, Friction(0.3)),),
    friction={**BUSY_SCENE.friction, "j4": replace(BUSY_SCENE.friction["j4"], load=0.1)},
)
SYSTEMS = {
    "busy and coupled": lambda: (busy_robot(), COUPLED_TOO),
    "busy and free": lambda: (busy_robot(True), BUSY_SCENE),
    "gripper": lambda: (robot("gripper"), load_scene(FOLDER / "gripper.toml")),
    "anymal": lambda: (real("anymal", True), Scene()),
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_shares_sum_to_tau(name):
    model, scene = SYSTEMS[name]()
    rng = np.random.default_rng(6)
    state, columns = random_state(model, rng, SAMPLES), _columns(scene, rng)
    tau = inverse_dynamics(model, *state, scene=scene, columns=columns)
    plan = Plan(model, scene)
    table = np.column_stack([*columns.values()]) if columns else None
    shares = {effect.name: run(plan.share(effect), plan, *state, table) for effect in plan.effects}
    assert worst(sum(shares.values()), tau) <= 1e-13
    for share_name, share in shares.items():
        assert share.any() == (share_name != "mimic")


def test_every_effect_is_on_in_the_busy_scene():
    assert [effect.name for effect in Plan(busy_robot(True), COUPLED_TOO).effects] == [
        effect.name for effect in EFFECTS
    ]


SCALES = [1e-8, 1e150]


@pytest.mark.parametrize("scale", SCALES)
def test_coriolis_is_quadratic(scale):
    """By subtraction of gravity the slowest would have errors of 1e-1; its own program has none."""
    model = golden_model("tree15_bf2_skew0.3")
    q, qd, _ = random_state(model, np.random.default_rng(7), 20)
    plan = Plan(model, Scene())
    share, still = plan.share(rigid_bodies.CORIOLIS), np.zeros_like(qd)
    unit = run(share, plan, q, qd, still)
    found = run(share, plan, q, scale * qd, still) / scale / scale
    assert worst(found, unit) <= 1e-15


NOTHING = {
    "viscous friction": Scene(friction={"shoulder": Friction()}),
    "coulomb friction": Scene(friction={"shoulder": Friction(stribeck=0.0)}),
    "load friction": Scene(friction={"shoulder": Friction(load=0.0)}),
    "rotor inertia": Scene(rotor={"elbow": Rotor(0.0, -50.0), "waist": Rotor(1e-3, 0.0)}),
    "rotor across its joint": Scene(rotor={"elbow": Rotor(0.0, 50.0, (1.0, 0.0, 0.0))}),
    "idle motor": Scene(coupled=(CoupledMotor("m", {"elbow": 1.0, "waist": 0.5}),)),
    "joint spring": Scene(spring={"elbow": Spring(0.0, 0.7)}),
    "payload": Scene(payloads=(Payload("flange", 0.0, (0.3, 0.2, 0.1)),)),
    "external wrench": Scene(wrenches=(ExternalWrench("flange", point=(1, 2, 3), frame="base"),)),
    "fluid": Scene(immersed=(Immersed("flange", 0.0, (1, 2, 3)), Immersed("wrist")), fluid_density=1000.0),
    "fluid of no density": Scene(immersed=(Immersed("flange", 0.1, (1, 2, 3), (1, 1, 1)),)),
}
WHY = {
    "viscous friction": "no joint has damping",
    "coulomb friction": "no joint has Coulomb friction",
    "rotor inertia": "neither the scene nor a transmission has a rotor inertia",
    "coupled motor": "the scene has no coupled motor",
    "gyroscopic moment": "the scene says no rotor's axis",
    "joint spring": "the scene has no spring",
    "limit spring": "the scene has no springs at joint limits",
    "payload": "the scene has no payload",
    "external wrench": "the scene has no external wrench",
    "fluid": "the scene has no fluid",
    "load friction": "no joint has friction that grows with load",
    "moving base": "the base is fixed",
    "mimic": "no joint mimics another",
}


@cache
def programs(scene):
    model = robot("puma560")
    plan = Plan(model, scene)
    return plan.torques(), acceleration_program(plan), mass_runner(model, scene).program


@pytest.mark.parametrize("name", NOTHING)
def test_programs_are_the_same_and_say_why(name):
    """Where the scene replaces no friction, which the PUMA's description has not either, and no rotor."""
    model = robot("puma560")
    assert programs(NOTHING[name]) == programs(Scene())
    verdicts = {effect.name: verdict for effect, verdict in Plan(model, NOTHING[name]).verdicts}
    for other, reason in WHY.items():
        assert verdicts[other] == (False, reason)


def test_zero_gravity_is_no_gravity():
    model = robot("puma560")
    q, qd, qdd = random_state(model, np.random.default_rng(1), 50)
    weightless = Scene(gravity=(0.0, -0.0, 0.0))
    assert not inverse_dynamics(model, q, 0, 0, scene=weightless).any()
    verdicts = {effect.name: verdict for effect, verdict in Plan(model, weightless).verdicts}
    assert verdicts["gravity"] == (False, "gravity is zero")
    small = inverse_dynamics(model, q, qd, qdd, scene=Scene(gravity=(0, 0, -1e-300)))
    np.testing.assert_array_equal(inverse_dynamics(model, q, qd, qdd, scene=weightless), small)


def test_a_motion_that_is_zero_throughout_changes_no_bit():
    """Zero columns are folded away; with one sample that moves they are not, and the others come out alike."""
    model = busy_robot()
    q, qd, qdd = random_state(model, np.random.default_rng(2), 40)
    qd[:, 1] = qdd[:, 0] = qdd[:, 3] = 0.0
    folded = inverse_dynamics(model, q, qd, qdd)
    moving = [np.vstack((x, np.ones_like(x[:1]))) for x in (q, qd, qdd)]
    np.testing.assert_array_equal(inverse_dynamics(model, *moving)[:-1], folded)


def test_verdicts_of_a_robot_at_rest():
    model = busy_robot()
    still = frozenset((source, i) for source in ("qd", "qdd") for i in range(model.n))
    verdicts = {effect.name: verdict for effect, verdict in Plan(model, Scene(), still).verdicts}
    assert verdicts["inertia"] == (False, "no joint accelerates")
    assert verdicts["coriolis"] == (False, "nothing moves")
    assert verdicts["viscous friction"] == (False, "no damped joint moves")
    assert verdicts["coulomb friction"] == (False, "no joint with Coulomb friction moves")
    assert verdicts["rotor inertia"] == (False, "no joint with a rotor accelerates")
    assert verdicts["mimic"] == (True, "1 joints follow others (follower)")
    assert verdicts["gravity"] == (True, "gravity is (0, 0, -9.81) m/s^2")
