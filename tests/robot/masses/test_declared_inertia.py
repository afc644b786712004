"""What a description declares: of a link by the rotation law, of the whole robot against Pinocchio."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.oracles import ROBOTS
from helpers.peers import pin
from helpers.pinocchio_robots import PinocchioRobot

from robodyn.errors import InputError
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.load import assemble, load_description
from robodyn.robot.masses.declared import link_inertia, robot_inertia
from robodyn.solids.inertia.solids import box

EPS = np.finfo(float).eps
REAL = ("panda", "anymal", "talos_full_v2")
OWN = ("gripper", "satellite", "puma560", "meshed_arm")

BOXES = """<robot name="boxes">
<link name="base"><inertial><origin xyz="0 0 0.1"/><mass value="3"/>{}</inertial></link>
<link name="upper"><inertial><origin xyz="0.2 0 0" rpy="0.1 0.2 0.3"/><mass value="2"/>{}</inertial></link>
<link name="fore"><inertial><origin xyz="0.1 0 0.02"/><mass value="1"/>{}</inertial></link>
<link name="tip"><inertial><origin xyz="0 0.05 0"/><mass value="0.5"/>{}</inertial></link>
<link name="frame"/>
<joint name="slide" type="prismatic"><parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/>
  <axis xyz="0 1 0"/><limit lower="-0.1" upper="0.2" effort="1" velocity="1"/></joint>
<joint name="turn" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.3" rpy="0 0 0.5"/>
  <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="twin" type="revolute"><parent link="fore"/><child link="tip"/><origin xyz="0.1 0 0"/><axis xyz="1 0 0"/>
  <limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="turn" multiplier="-2" offset="0.25"/></joint>
<joint name="stick" type="fixed"><parent link="tip"/><child link="frame"/></joint>
</robot>"""
SIZES = ((0.3, 0.2, 0.1), (0.4, 0.1, 0.05), (0.2, 0.1, 0.1), (0.05, 0.1, 0.02))
MASSES = (3.0, 2.0, 1.0, 0.5)


def solids():
    return [box(*size, mass=mass) for size, mass in zip(SIZES, MASSES, strict=True)]


def boxes_text():
    tensors = np.array([np.diag(solid.inertia) for solid in solids()]).tolist()
    texts = [f'<inertia ixx="{x!r}" ixy="0" ixz="0" iyy="{y!r}" iyz="0" izz="{z!r}"/>' for x, y, z in tensors]
    return BOXES.format(*texts).encode()


def boxes():
    return load_description(boxes_text())


def normwise(found, expected, limit):
    np.testing.assert_allclose(found, expected, rtol=0, atol=limit * np.abs(expected).max())


def test_positions_by_order_and_by_name_and_what_links_say():
    found, again = (robot_inertia(boxes(), at) for at in ([0.15, -0.3], {"turn": -0.3, "slide": 0.15}))
    assert found.body.inertia.tolist() == again.body.inertia.tolist()
    assert found.body.mass == 6.5
    assert found.at == again.at == {"slide": 0.15, "turn": -0.3}
    assert found.count == 5
    assert [link.name for link in found.links] == ["base", "upper", "fore", "tip"]
    assert found.warnings == ()
    whole = sum((link.placed for link in found.links[1:]), found.links[0].placed)
    normwise(whole.inertia, found.body.inertia, 4 * EPS)
    normwise(whole.com, found.body.com, 4 * EPS)


def test_a_link_is_turned_by_its_origin():
    found = link_inertia(boxes(), "upper")
    R = rotation_from_rpy(0.1, 0.2, 0.3)
    normwise(found.body.inertia, R @ solids()[1].inertia @ R.T, 4 * EPS)
    assert (found.body.mass, found.body.com.tolist(), found.line) == (2, [0.2, 0, 0], 3)
    assert found.faults == ()
    assert found.validity.slack == pytest.approx(2 * 0.05**2 / (0.4**2 + 0.1**2), rel=16 * EPS)


def source(name):
    return boxes_text() if name == "boxes" else ROBOTS / f"{name}.urdf" if name in OWN else path_of(name)


@pytest.mark.parametrize(
    "name", ["boxes", *OWN[:2], *(pytest.param(name, marks=pytest.mark.slow) for name in (*OWN[2:], *REAL))]
)
def test_pinocchio_agrees_at_random_configurations(name):
    description = load_description(source(name))
    model, theirs = assemble(description), PinocchioRobot(source(name), free=True)
    rng = np.random.default_rng(7)
    for q in rng.uniform(-2, 2, (3, model.nq)):
        position, *_ = theirs.state(model, q, np.zeros(model.n), np.zeros(model.n))
        pin.ccrba(theirs.model, theirs.data, position, np.zeros(theirs.model.nv))
        found = robot_inertia(description, q).body
        assert found.mass == pytest.approx(theirs.data.Ig.mass, rel=8 * EPS)
        reach = np.abs([link.placed.com for link in robot_inertia(description, q).links]).max()
        np.testing.assert_allclose(found.com, theirs.data.com[0], rtol=0, atol=64 * EPS * reach)
        normwise(found.inertia, theirs.data.Ig.inertia, 128 * EPS)


def test_limits_and_faults_are_warned_of():
    found = robot_inertia(boxes(), {"slide": 0.5, "turn": -0.9})
    assert set(found.warnings) == {
        "joint 'twin' at 2.05 rad is above its upper limit 1",
        "joint 'slide' at 0.5 m is above its upper limit 0.2",
    }
    text = BOXES.format(*['<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="3"/>'] * 4)
    (first, *_) = robot_inertia(load_description(text.encode())).warnings
    assert first == "link 'base' (line 2): principal moments 1 + 1 < 3 kg m^2 break the triangle inequality"


def test_no_mass():
    description = load_description(b'<robot name="r"><link name="a"/></robot>')
    with pytest.raises(InputError, match="the robot has no mass"):
        robot_inertia(description)
    with pytest.raises(InputError, match="link 'a' has no <inertial>"):
        link_inertia(description, "a")


def test_a_floating_joint_inside_the_robot():
    text = BOXES.format(*['<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'] * 4)
    text = text.replace('<joint name="turn" type="revolute">', '<joint name="turn" type="floating">')
    text = text.replace('<mimic joint="turn" multiplier="-2" offset="0.25"/>', "")
    description = load_description(text.encode())
    still = robot_inertia(description)
    assert still.at["turn_qw"] == 1
    turned = robot_inertia(description, {"turn_x": 0.1, "turn_qz": 1.0, "turn_qw": 0.0})
    R = rotation_from_rpy(0, 0, 0.5)
    centre = sum(link.body.mass * link.placed.com for link in still.links) / 6.5
    np.testing.assert_allclose(still.body.com, centre, rtol=0, atol=4 * EPS)
    upper = next(link for link in turned.links if link.name == "upper")
    expected = R @ ([0.1, 0, 0] + rotation_from_rpy(0, 0, np.pi) @ [0.2, 0, 0]) + [0, 0, 0.3]
    np.testing.assert_allclose(upper.placed.com, expected, rtol=0, atol=4 * EPS)
    with pytest.raises(InputError, match="quaternion of joint 'turn' is zero"):
        robot_inertia(description, {"turn_qw": 0.0})
