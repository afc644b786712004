"""`robodyn.momenta`: about any point and in any frame, against Pinocchio, closed forms and itself."""

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
from robodyn.scene.parts import Rotor, Spring
from robodyn.scene.scene import Scene

STILL = Scene(gravity=(0.0, 0.0, 0.0))


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


def test_about_a_point_and_back():
    """L_a - L_b = (b - a) x p for points of one frame, and the parts add up to the whole."""
    model = robot("puma560")
    q, qd, _ = random_state(model, np.random.default_rng(1), 5)
    whole = robodyn.momenta(model, q, qd)
    points = np.array([[0.0, 0, 0], [1, -2, 0.5], [-3, 0.25, 4]])
    for point in points:
        moved = robodyn.momenta(model, q, qd, about=point)
        assert worst(moved.angular, whole.angular - np.cross(point, whole.linear)) <= 16 * EPS
    own = robodyn.momenta(model, q, qd, about="com")
    assert (
        worst(own.angular, whole.angular - np.cross(whole.com, whole.linear), np.abs(whole.angular).max()) <= 16 * EPS
    )


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


def test_a_pendulum_in_closed_form():
    """One link of mass 1 with its centre at 0.5 turns about a fixed hinge: p = m r qd, L = I qd, T = I qd^2 / 2."""
    model = chain(1)
    found = robodyn.momenta(model, [np.pi / 3], [2.0], scene=Scene(gravity=(0.0, -9.81, 0.0)))
    body = model.bodies[1].inertia
    c, s = np.cos(np.pi / 3), np.sin(np.pi / 3)
    assert worst(found.com, [0.5 * c, 0.5 * s, 0]) <= 4 * EPS
    assert worst(found.linear, [-body.m * s, body.m * c, 0]) <= 4 * EPS
    assert worst(found.angular, [0, 0, 2 * body.I[2, 2]]) <= 4 * EPS
    assert worst(found.kinetic, 2 * body.I[2, 2]) <= 4 * EPS
    assert worst(found.potential, body.m * 9.81 * 0.5 * s) <= 4 * EPS
    assert found.mass == body.m


def test_rotors_and_springs_store_energy_of_their_kind():
    model = chain(2)
    bare = robodyn.momenta(model, [0.2, 0.4], [1.0, 3.0], scene=STILL)
    scene = Scene(gravity=STILL.gravity, rotor={"j2": Rotor(0.02, 10.0)}, spring={"j1": Spring(50.0, 0.1)})
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
