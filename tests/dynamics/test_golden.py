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
