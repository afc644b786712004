"""External wrenches in every frame against the virtual work that they do, with Jacobians from Pinocchio."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import busy_parts, busy_robot
from helpers.oracles import EPS, frictionless, random_state, run, worst
from helpers.pinocchio_robots import PinocchioRobot
from helpers.small_robots import urdf

from robodyn.dynamics.effects import forces
from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.plan import Plan
from robodyn.programs.vectors import cross
from robodyn.robot.kinematics import motions, poses
from robodyn.scene.scene import ExternalWrench, Scene

FORCE, MOMENT, POINT = (1.0, -2.0, 3.0), (0.4, 0.5, -0.6), (0.1, -0.3, 0.2)
SAMPLES = 10


def _axes(model, frame, q, link_rotation):
    if frame == "base":
        still = np.zeros(model.n)
        return poses(model.parents, motions(model, q, still, still))[0].R
    return link_rotation if frame == "link" else np.eye(3)


@pytest.mark.parametrize("moving_base", [False, True], ids=["fixed", "free"])
@pytest.mark.parametrize("frame", ["link", "base", "world"])
@pytest.mark.parametrize("where", ["tool", "l6", "l0"])
def test_is_minus_jacobian_transpose_times_wrench(where, frame, moving_base):
    model = busy_robot(moving_base)
    other = PinocchioRobot(urdf(*busy_parts()), free=moving_base)
    state = random_state(model, np.random.default_rng(12), SAMPLES)
    wrench = ExternalWrench(where, FORCE, MOMENT, POINT, frame)
    plan = Plan(model, Scene(wrenches=(wrench,)))
    share = run(plan.share(forces.EXTERNAL), plan, *state)
    for tau, q in zip(share, state[0], strict=True):
        J, rotation = other.point_jacobian(model, q, where, POINT)
        axes = _axes(model, frame, q, rotation)
        expected = -J.T @ np.concatenate((axes @ FORCE, axes @ MOMENT))
        assert worst(tau, expected, np.abs(FORCE).max()) <= 1e-14


def test_the_base_carries_it():
    """Robot and wrench at rest without gravity: the ground pushes back with the same wrench about the base's origin."""
    model = busy_robot()
    wrench = ExternalWrench("tool", FORCE, MOMENT, POINT, "base")
    plan = Plan(model, frictionless(model, gravity=(0.0, 0.0, 0.0), wrenches=(wrench,)))
    q = random_state(model, np.random.default_rng(13), 1)[0]
    still = np.zeros((1, model.n))
    base = run(plan.wrenches(), plan, q, still, still)[0, model.n :]
    place = model.links["tool"]
    pose = poses(model.parents, motions(model, q[0], still[0], still[0]))[place.body]
    point = pose.p + pose.R @ (place.p + place.R @ POINT)
    assert worst(base[:3], -np.array(FORCE)) <= 4 * EPS
    assert worst(base[3:], -np.array(MOMENT) - cross(point, np.array(FORCE))) <= 8 * EPS


def test_columns_drive_it_sample_by_sample():
    model = busy_robot()
    state = random_state(model, np.random.default_rng(14), SAMPLES)
    push, twist = np.random.default_rng(15).normal(size=(2, SAMPLES))
    moving = Scene(wrenches=(ExternalWrench("tool", ("push", 1.0, "push"), (0.0, "twist", 2.0), POINT),))
    assert moving.columns == ("push", "twist")
    tau = inverse_dynamics(model, *state, scene=moving, columns={"twist": twist, "push": push})
    for k in range(SAMPLES):
        constant = ExternalWrench("tool", (push[k], 1.0, push[k]), (0.0, twist[k], 2.0), POINT)
        one = inverse_dynamics(model, *(x[k] for x in state), scene=Scene(wrenches=(constant,)))
        assert worst(tau[k], one) <= 8 * EPS
