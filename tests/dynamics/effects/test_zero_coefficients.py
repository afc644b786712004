"""An effect whose coefficients are zero leaves the programs as they were, and says why it is off."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from helpers.busy_robot import busy_robot
from helpers.oracles import random_state, robot

from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.inverse import inverse_dynamics, mass_runner
from robodyn.dynamics.plan import Plan
from robodyn.scene.scene import CoupledMotor, ExternalWrench, Friction, Immersed, Payload, Rotor, Scene, Spring

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
