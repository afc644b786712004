"""Golden cases: torques, their parts, M, wrenches of joints and the base; the PUMA 560 as others printed it."""

from __future__ import annotations

import math
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest
from helpers.oracles import frictionless, golden_model, reference, robot, run, worst
from helpers.robot_files import FOLDER

import robodyn
from robodyn.dynamics.effects.rigid_bodies import CORIOLIS, GRAVITY
from robodyn.dynamics.inverse import bias_forces, inverse_dynamics, mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.scene.read import load_scene
from robodyn.scene.scene import ExternalWrench, Payload, Scene

MODELS = reference("golden_inverse_dynamics")["models"]
CASES = [(name, k) for name, model in MODELS.items() for k in range(len(model["cases"]))]
TOLERANCE = 1e-12
assert len(CASES) == 36


@pytest.mark.parametrize(("name", "k"), CASES)
def test_golden_numbers(name, k):
    model, numbers = golden_model(name), MODELS[name]["cases"][k]
    assert list(model.joint_names) == MODELS[name]["joint_names"]
    scene, state = Scene(gravity=tuple(numbers["gravity"])), [numbers["q"], numbers["qd"], numbers["qdd"]]
    plan, expected = Plan(model, scene), numbers["joint_wrench_on_child_at_joint_origin_in_link_frame"]
    forces, moments = ([each[part] for each in expected] for part in "fn")
    # the largest torque of the case, or where every torque is zero the largest of a joint's moments
    largest = max(np.abs(numbers[key]).max() for key in ("tau", "tau_gravity", "tau_coriolis"))
    scale = largest or np.abs([*forces, *moments]).max()
    assert worst(inverse_dynamics(model, *state, scene=scene), numbers["tau"], scale) <= TOLERANCE
    for effect, key in ((GRAVITY, "tau_gravity"), (CORIOLIS, "tau_coriolis")):
        own = np.abs(numbers[key]).max() or scale
        assert worst(run(plan.share(effect), plan, *state)[0], numbers[key], own) <= TOLERANCE
    M = mass_matrix(model, state[0], scene=scene)
    assert worst(M, numbers["M"]) <= 1e-14
    np.testing.assert_array_equal(M, M.T)
    out = run(plan.wrenches(joints=True), plan, *state)[0]
    tau, base, joints = out[: model.n], out[model.n : model.n + 6], out[model.n :].reshape(-1, 2, 3)
    assert worst(tau, numbers["tau"], scale) <= TOLERANCE
    order = [model.joint_names.index(body.joint.name) for body in model.bodies[1:]]
    largest = np.abs([*moments, *forces]).max()
    assert worst(joints[1:, 0], np.array(forces)[order]) <= TOLERANCE
    assert worst(joints[1:, 1], np.array(moments)[order], largest) <= TOLERANCE
    assert worst(base[:3], numbers["base_reaction"]["force"]) <= TOLERANCE
    assert worst(base[3:], numbers["base_reaction"]["moment_about_base_origin"], largest) <= TOLERANCE
    np.testing.assert_array_equal(run(plan.wrenches(), plan, *state)[0], out[: model.n + 6])


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
WEAK = {0: 0.0, "9.81/6": 9.81 / 6}
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
        scene = replace(scene, gravity=(0.0, 0.0, -WEAK[case["gravity"]]))
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


def test_matrices_accelerations_and_a_payload():
    def torques(qdd, scene):
        return inverse_dynamics(MODEL, QN, 0, qdd, scene=scene)

    weightless = replace(MOTORS, gravity=(0.0, 0.0, 0.0))
    loaded = replace(MOTORS, payloads=(Payload("flange", 2.5, (0, 0, 0.1)),))
    M, steps = mass_matrix(MODEL, QN, scene=MOTORS), np.array([1.0, 2, 3, 1, 2, 3])
    qd, tau = [0.1, 0.2, 0.8, 0.2, 0.5, 1.0], [1.0, 3.2, 1.8, 0.1, 0.7, 4.6]
    other, payload = "[0,pi/4,-pi,1,pi/4,0]", PRINTED["payload_added_properly_2.5kg_at_[0,0,0.1]_link6"]
    for found, printed in (
        (M, PRINTED["inertia(qn)"]),
        (mass_matrix(MODEL, NAMED[other], scene=MOTORS), PRINTED[f"inertia({other})"]),
        (M @ steps, PRINTED["itorque(qn,[1,2,3,1,2,3])"]),
        (torques(steps, weightless), PRINTED["itorque(qn,[1,2,3,1,2,3])"]),
        (
            np.linalg.solve(M, tau - bias_forces(MODEL, QN, qd, scene=MOTORS)),
            PRINTED["accel(qn,qd=[0.1,0.2,0.8,0.2,0.5,1.0],tau=[1.0,3.2,1.8,0.1,0.7,4.6])"],
        ),
        (robodyn.coriolis_matrix(MODEL, QN, steps, scene=SMOOTH), PRINTED["coriolis(qn,qd=[1,2,3,1,2,3])"]),
        (torques(0, loaded), payload["gravload(qn)"]),
    ):
        assert _agrees(found, printed)
    assert _agrees(np.diag(mass_matrix(MODEL, QN, scene=loaded)), payload["M_diag(qn)_with_motor"], 8)
