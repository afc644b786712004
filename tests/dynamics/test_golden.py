"""Every golden case: torques, their gravity and Coriolis parts, M, every joint wrench and the base reaction."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import golden_model, reference, run, worst

from robodyn.dynamics.effects.rigid_bodies import CORIOLIS, GRAVITY
from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.dynamics.plan import Plan
from robodyn.scene.scene import Scene

MODELS = reference("golden_inverse_dynamics")["models"]
CASES = [(name, k) for name, model in MODELS.items() for k in range(len(model["cases"]))]
TOLERANCE = 1e-12


assert len(CASES) == 36


@pytest.fixture(scope="module", params=CASES, ids=lambda case: f"{case[0]}-{case[1]}")
def case(request):
    name, k = request.param
    numbers = MODELS[name]["cases"][k]
    model = golden_model(name)
    assert list(model.joint_names) == MODELS[name]["joint_names"]
    scene = Scene(gravity=tuple(numbers["gravity"]))
    return model, scene, numbers, [numbers["q"], numbers["qd"], numbers["qdd"]]


def _scale(numbers):
    """The largest torque of the case, or where every torque is zero the largest of a joint's moments."""
    parts = [numbers[key] for key in ("tau", "tau_gravity", "tau_coriolis")]
    wrenches = [[*w["f"], *w["n"]] for w in numbers["joint_wrench_on_child_at_joint_origin_in_link_frame"]]
    return max(np.abs(parts).max(), 0.0) or np.abs(wrenches).max()


def test_tau(case):
    model, scene, numbers, state = case
    assert worst(inverse_dynamics(model, *state, scene=scene), numbers["tau"], _scale(numbers)) <= TOLERANCE


@pytest.mark.parametrize(("effect", "key"), [(GRAVITY, "tau_gravity"), (CORIOLIS, "tau_coriolis")])
def test_parts_from_their_own_programs(case, effect, key):
    model, scene, numbers, state = case
    plan = Plan(model, scene)
    own = np.abs(numbers[key]).max()
    assert worst(run(plan.share(effect), plan, *state)[0], numbers[key], own or _scale(numbers)) <= TOLERANCE


def test_mass_matrix(case):
    model, scene, numbers, (q, _, _) = case
    M = mass_matrix(model, q, scene=scene)
    assert worst(M, numbers["M"]) <= 1e-14
    np.testing.assert_array_equal(M, M.T)


def test_wrenches_of_joints_and_base(case):
    model, scene, numbers, state = case
    plan = Plan(model, scene)
    out = run(plan.wrenches(joints=True), plan, *state)[0]
    tau, base, joints = out[: model.n], out[model.n : model.n + 6], out[model.n :].reshape(-1, 2, 3)
    assert worst(tau, numbers["tau"], _scale(numbers)) <= TOLERANCE
    wanted = numbers["joint_wrench_on_child_at_joint_origin_in_link_frame"]
    expected = dict(zip(MODELS[model.name]["joint_names"], wanted, strict=True))
    assert len(joints) == len(model.bodies) == len(expected) + 1
    forces = [expected[body.joint.name]["f"] for body in model.bodies[1:]]
    moments = [expected[body.joint.name]["n"] for body in model.bodies[1:]]
    assert worst(joints[1:, 0], forces) <= TOLERANCE
    assert worst(joints[1:, 1], moments, np.abs([*moments, *forces]).max()) <= TOLERANCE
    reaction = numbers["base_reaction"]
    assert worst(base[:3], reaction["force"]) <= TOLERANCE
    assert worst(base[3:], reaction["moment_about_base_origin"], np.abs([*moments, *forces]).max()) <= TOLERANCE
    np.testing.assert_array_equal(run(plan.wrenches(), plan, *state)[0], out[: model.n + 6])
