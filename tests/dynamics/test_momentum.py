"""Momenta, poses and Jacobians against Pinocchio, the work of wrenches, and each other in the frames of links."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.busy_robot import busy_parts, busy_robot
from helpers.oracles import EPS, random_state, robot, worst
from helpers.peers import pin
from helpers.pinocchio_robots import PinocchioRobot
from helpers.small_robots import chain, urdf

import robodyn
from robodyn.errors import InputError
from robodyn.programs.vectors import cross
from robodyn.robot.kinematics import motions, poses
from robodyn.scene.scene import ExternalWrench, Rotor, Scene, Spring

WEIGHTLESS = Scene(gravity=(0.0, 0.0, 0.0))


def test_against_pinocchio():
    model = busy_robot(True)
    other = PinocchioRobot(urdf(*busy_parts()), free=True)
    q, qd, qdd = random_state(model, np.random.default_rng(0), 3)
    found = robodyn.momenta(model, q, qd, about="com", scene=Scene(rotor={"j2": Rotor(0.0)}))
    for k in range(3):
        position, v, _ = other.state(model, q[k], qd[k], qdd[k])
        pin.computeCentroidalMomentum(other.model, other.data, position, v)
        assert worst(found.com[k], other.data.com[0]) <= 1e-14
        assert worst(found.linear[k], other.data.hg.linear) <= 1e-14
        assert worst(found.angular[k], other.data.hg.angular) <= 2e-14
        assert worst(found.kinetic[k], pin.computeKineticEnergy(other.model, other.data, position, v)) <= 1e-14
        weight = pin.computePotentialEnergy(other.model, other.data, position)
        assert worst(found.potential[k], weight, 10 * found.mass * (1 + np.abs(q[k, :3]).max())) <= 1e-14


@pytest.mark.parametrize("free", [False, True])
def test_in_the_frame_of_a_link(free):
    model = busy_robot(free)
    (q,), (qd,), (qdd,) = random_state(model, np.random.default_rng(2), 1)
    name = list(model.links)[-1]
    body, R, p = model.links[name]
    where = poses(model.parents, motions(model, q, qd, qdd))[body]
    R, p = where.R @ R, where.p + where.R @ p
    point = np.array([0.3, -0.1, 0.7])
    ground, link = robodyn.momenta(model, q, qd), robodyn.momenta(model, q, qd, about=point, frame=name)
    assert worst(R @ link.com + p, ground.com) <= 1e-14
    assert worst(R @ link.linear, ground.linear) <= 1e-14
    scale = np.abs(ground.angular).max()
    assert worst(R @ link.angular, ground.angular - cross(p + R @ point, ground.linear), scale) <= 2e-14
    assert (link.kinetic, link.potential) == (ground.kinetic, ground.potential)


def test_rotors_and_springs_store_energy_of_their_kind():
    model = chain(2)
    bare = robodyn.momenta(model, [0.2, 0.4], [1.0, 3.0], scene=WEIGHTLESS)
    scene = Scene(gravity=WEIGHTLESS.gravity, rotor={"j2": Rotor(0.02, 10.0)}, spring={"j1": Spring(50.0, 0.1)})
    found = robodyn.momenta(model, [0.2, 0.4], [1.0, 3.0], scene=scene)
    assert worst(found.kinetic, bare.kinetic + 0.5 * 2.0 * 9.0) <= 4 * EPS
    assert worst(found.potential, 0.5 * 50 * 0.1**2) <= 8 * EPS
    assert bare.potential == 0.0
    assert np.array_equal(found.angular, bare.angular)


@pytest.mark.parametrize(
    ("how", "line"),
    [
        ({"frame": "spindel"}, "did you mean 'spindle'"),
        ({"about": "middle"}, "momentum about 'middle'"),
        ({"about": [1, 2]}, "is no point"),
        ({"about": [np.nan, 0, 0]}, "is no point"),
    ],
)
def test_what_is_refused(how, line):
    with pytest.raises(InputError, match=line):
        robodyn.momenta(robot("scara"), [0.0] * 3, **how)


def test_without_mass_there_is_no_mass_centre():
    with pytest.raises(InputError, match="the robot has no mass"):
        robodyn.momenta(robodyn.load(b'<robot name="r"><link name="l"/></robot>'), [])


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


def test_what_is_no_link_or_point():
    model = robot("puma560")
    for link, point, says in (("elbo", (0.0, 0.0, 0.0), "no link 'elbo'"), ("forearm", (1.0, 2.0), "is no point")):
        with pytest.raises(InputError, match=says):
            robodyn.jacobian(model, np.zeros(model.nq), link, point)
