"""Poses and Jacobians of links against differences and virtual work."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import busy_robot
from helpers.oracles import random_state, robot, worst

import robodyn
from robodyn.errors import InputError
from robodyn.scene.parts import ExternalWrench
from robodyn.scene.scene import Scene

POINT = (0.1, -0.2, 0.3)
bases = pytest.mark.parametrize("free", [False, True], ids=["fixed", "free"])


@bases
def test_a_wrench_does_the_work_of_the_jacobian(free):
    model, rng = busy_robot(free), np.random.default_rng(1)
    q, _, _ = random_state(model, rng, 5)
    force, moment = (2.0, -1.0, 0.5), (0.3, 0.4, -0.2)
    wrench = ExternalWrench("tool", force, moment, POINT, "world")
    with_it, without = (
        robodyn.inverse_dynamics(model, q, 0.0, 0.0, scene=scene) for scene in (Scene(wrenches=(wrench,)), Scene())
    )
    J = robodyn.jacobian(model, q, "tool", POINT)
    expected = np.einsum("kri,r->ki", J, [*moment, *force])
    assert worst(without - with_it, expected, np.abs(with_it).max()) <= 1e-14


def test_velocities_are_rates_of_poses():
    model, rng, step = robot("puma560"), np.random.default_rng(2), 1e-6
    q, qd, _ = random_state(model, rng, 4)
    link = list(model.links)[-1]
    ahead, here, behind = (robodyn.forward_kinematics(model, q + sign * step * qd, link) for sign in (1, 0, -1))
    w, v = np.split(np.einsum("kri,ki->kr", robodyn.jacobian(model, q, link), qd), 2, axis=1)
    assert worst((ahead.p - behind.p) / (2 * step), v) <= 1e-8
    spin = np.einsum("kij,klj->kil", (ahead.R - behind.R) / (2 * step), here.R)
    assert worst(np.stack((spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]), -1), w) <= 1e-8


def test_what_is_no_link_or_point():
    model = robot("puma560")
    for link, point, says in (("elbo", (0.0, 0.0, 0.0), "no link 'elbo'"), ("forearm", (1.0, 2.0), "is no point")):
        with pytest.raises(InputError, match=says):
            robodyn.jacobian(model, np.zeros(model.nq), link, point)
