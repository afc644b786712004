"""The PUMA 560 of robots/ with its motors against everything that others printed for it, to the printed digits."""

from __future__ import annotations

import math
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest
from helpers.oracles import frictionless, golden_model, reference, robot, run, worst
from helpers.robot_files import FOLDER

from robodyn.dynamics.effects import rigid_bodies
from robodyn.dynamics.inverse import bias_forces, inverse_dynamics
from robodyn.dynamics.mass import coriolis_matrix, mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.scene.parts import ExternalWrench, Payload
from robodyn.scene.read import load_scene
from robodyn.scene.scene import Scene

PRINTED = reference("published_checks")["puma560_rtb"]
QN = [0, math.pi / 4, math.pi, 0, math.pi / 4, 0]
NAMED = {
    "qn": QN,
    "qz": [0] * 6,
    "qr": [0, math.pi / 2, -math.pi / 2, 0, 0, 0],
    "qs": [0, 0, -math.pi / 2, 0, 0, 0],
    "[0,pi/4,-pi,1,pi/4,0]": [0, math.pi / 4, -math.pi, 1, math.pi / 4, 0],
    "[0,pi/2,-pi,1,pi/2,0]": [0, math.pi / 2, -math.pi, 1, math.pi / 2, 0],
}
GRAVITY = {0: 0.0, "9.81/6": 9.81 / 6}
MODEL = robot("puma560")
MOTORS = load_scene(FOLDER / "puma560_motors.toml")
SMOOTH = replace(frictionless(MODEL), rotor=MOTORS.rotor)


def _agrees(found, printed, decimals=4):
    """Each number within half a unit of its last printed decimal; zeros at the end of a number were not kept."""
    exponents = [-Decimal(repr(value)).as_tuple().exponent for value in np.ravel(printed).tolist()]
    unit = 10.0 ** -np.maximum(exponents, decimals).reshape(np.shape(printed))
    return (np.abs(found - np.array(printed)) <= 0.50001 * unit).all()


def _rates(value):
    return np.full(6, float(value)) if np.ndim(value) == 0 else np.array(value, dtype=float)


def _scene(case):
    scene = MOTORS
    if "gravity" in case:
        scene = replace(scene, gravity=(0.0, 0.0, -GRAVITY[case["gravity"]]))
    tip = case.get("fext_by_tip_on_env_in_link6_frame(f,m)")
    if tip:
        force, moment = tuple(-x for x in tip[:3]), tuple(-x for x in tip[3:])
        scene = replace(scene, wrenches=(ExternalWrench("flange", force, moment),))
    return scene


def _label(case):
    return "-".join(str(case[key]) for key in ("q", "q_deg", "qd", "qdd", "gravity") if key in case)


@pytest.mark.parametrize("case", PRINTED["cases"], ids=_label)
def test_torques(case):
    q = np.radians(case["q_deg"]) if "q_deg" in case else NAMED[case["q"]]
    qd, qdd = _rates(case.get("qd", 0)), _rates(case.get("qdd", 0))
    tau = inverse_dynamics(MODEL, q, qd, qdd, scene=_scene(case))
    assert _agrees(tau, case.get("tau", case.get("gravload")))


@pytest.mark.parametrize("q", ["qn", "[0,pi/4,-pi,1,pi/4,0]"])
def test_inertia_matrix(q):
    assert _agrees(mass_matrix(MODEL, NAMED[q], scene=MOTORS), PRINTED[f"inertia({q})"])


def test_inertia_torque():
    qdd = np.array([1.0, 2, 3, 1, 2, 3])
    assert _agrees(mass_matrix(MODEL, QN, scene=MOTORS) @ qdd, PRINTED["itorque(qn,[1,2,3,1,2,3])"])
    weightless = replace(MOTORS, gravity=(0.0, 0.0, 0.0))
    assert _agrees(inverse_dynamics(MODEL, QN, 0, qdd, scene=weightless), PRINTED["itorque(qn,[1,2,3,1,2,3])"])


def test_acceleration_of_given_torques():
    qd, tau = [0.1, 0.2, 0.8, 0.2, 0.5, 1.0], [1.0, 3.2, 1.8, 0.1, 0.7, 4.6]
    bias = bias_forces(MODEL, QN, qd, scene=MOTORS)
    qdd = np.linalg.solve(mass_matrix(MODEL, QN, scene=MOTORS), tau - bias)
    assert _agrees(qdd, PRINTED["accel(qn,qd=[0.1,0.2,0.8,0.2,0.5,1.0],tau=[1.0,3.2,1.8,0.1,0.7,4.6])"])


def test_coriolis_matrix():
    C = coriolis_matrix(MODEL, QN, [1.0, 2, 3, 1, 2, 3], scene=SMOOTH)
    assert _agrees(C, PRINTED["coriolis(qn,qd=[1,2,3,1,2,3])"])


def test_payload():
    printed = PRINTED["payload_added_properly_2.5kg_at_[0,0,0.1]_link6"]
    loaded = replace(MOTORS, payloads=(Payload("flange", 2.5, (0, 0, 0.1)),))
    assert _agrees(inverse_dynamics(MODEL, QN, 0, 0, scene=loaded), printed["gravload(qn)"])
    assert _agrees(np.diag(mass_matrix(MODEL, QN, scene=loaded)), printed["M_diag(qn)_with_motor"], 8)


OTHERS_PRINTED = reference("published_checks")
g = 9.81


@pytest.mark.parametrize(("q", "expected"), [((0, 0), (2, 0.5)), ((0, np.pi / 2), (1.5, 0)), ((np.pi / 2, 0), (0, 0))])
def test_two_links_of_the_robotics_toolbox(q, expected):
    """Its arm turns upwards with q, ours downwards about +y."""
    tau = -inverse_dynamics(golden_model("twolink_rtb"), -np.array(q), 0, 0)
    assert worst(tau, g * np.array(expected), 2 * g) <= 1e-15


def test_two_links_with_a_force_at_the_tip():
    up = ExternalWrench("link2", (0, 0, 1), point=(1, 0, 0), frame="base")
    tau = inverse_dynamics(golden_model("twolink_rtb"), 0, 0, 0, scene=Scene(gravity=(0, 0, 0), wrenches=(up,)))
    assert tuple(tau) == tuple(OTHERS_PRINTED["twolink_rtb"]["tip force 1 N up, g=0 -> tau"]) == (2, 1)


class TestModernRobotics:
    """Its first screw has length sqrt 2: our q1 is sqrt 2 times its theta1, its tau1 sqrt 2 times ours."""

    P = OTHERS_PRINTED["modern_robotics_3link"]
    model = golden_model("mr_3link")
    stretch = np.array([np.sqrt(2), 1, 1])
    weight = Scene(gravity=tuple(P["g"]))

    def ours(self, key):
        return self.stretch * self.P[key]

    @property
    def tip(self):
        """The tool's frame is turned by 90 degrees about y from the last link's; its wrench acts on the environment."""
        m, f = np.array(self.P["Ftip_by_tip_on_env(m,f)"]).reshape(2, 3)
        turn = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
        force, moment = tuple(-turn @ f), tuple(-turn @ m)
        return ExternalWrench("link3", force, moment, point=(0.39225, 0.01615, 0.000159))

    def printed(self, key, found, decimals=8):
        return np.abs(found - np.array(self.P[key])).max() <= 0.51 * 10.0**-decimals

    def test_inverse_dynamics(self):
        scene = replace(self.weight, wrenches=(self.tip,))
        tau = inverse_dynamics(self.model, self.ours("q"), self.ours("qd"), self.ours("qdd"), scene=scene)
        assert self.printed("InverseDynamics", self.stretch * tau)

    @pytest.mark.parametrize(
        ("key", "effect"), [("GravityForces", rigid_bodies.GRAVITY), ("VelQuadraticForces", rigid_bodies.CORIOLIS)]
    )
    def test_parts(self, key, effect):
        plan = Plan(self.model, self.weight)
        share = run(plan.share(effect), plan, self.ours("q"), self.ours("qd"), self.ours("qdd"))[0]
        assert self.printed(key, self.stretch * share, 7)

    def test_end_effector_forces(self):
        scene = Scene(gravity=(0, 0, 0), wrenches=(self.tip,))
        tau = inverse_dynamics(self.model, self.ours("q"), 0, 0, scene=scene)
        assert self.printed("EndEffectorForces", self.stretch * tau)

    def test_mass_matrix(self):
        M = mass_matrix(self.model, self.ours("q")) * np.outer(self.stretch, self.stretch)
        assert self.printed("MassMatrix", M, 6)

    def test_forward_dynamics_backwards(self):
        qdd = self.stretch * self.P["ForwardDynamics(tau=[.5,.6,.7])"]
        scene = replace(self.weight, wrenches=(self.tip,))
        tau = inverse_dynamics(self.model, self.ours("q"), self.ours("qd"), qdd, scene=scene)
        assert worst(self.stretch * tau, [0.5, 0.6, 0.7]) <= 1e-6

    def test_computed_torque(self):
        theta, rate, wanted = np.array(self.P["q"]), np.array(self.P["qd"]), np.ones(3)
        error = wanted - theta
        push = 1.3 * error + 1.2 * (0.2 + error) + 1.1 * (np.array([2, 1.2, 2]) - rate) + 0.1
        tau = inverse_dynamics(self.model, self.ours("q"), self.ours("qd"), self.stretch * push, scene=self.weight)
        assert self.printed("ComputedTorque", self.stretch * tau)
