"""What is said where contacts cannot do what is asked: nothing on, limits that cannot be kept, wrong numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS

import robodyn
from robodyn import Contact, ContactCost
from robodyn.errors import SceneError

STAND = str(ROBOTS / "quadruped_stand.csv")


@pytest.fixture(scope="module")
def robot():
    return robodyn.load(ROBOTS / "quadruped.urdf", moving_base=True)


@pytest.fixture(scope="module")
def scene():
    return robodyn.load_scene(ROBOTS / "quadruped_stand.toml")


def test_no_contact_is_on(robot, scene):
    """For a fifth of the second; the whole weight is missing then."""
    flying = tuple(replace(foot, on=((0.0, 0.4), (0.6, 2.0))) for foot in scene.contacts)
    result = robodyn.torques(robot, STAND, replace(scene, contacts=flying))
    assert result.constraints is not None
    (span,) = result.constraints.missing
    assert (span.kind, span.start, span.end) == ("fly", 0.41, 0.59)
    assert span.force.value == pytest.approx(10.0 * 9.81, rel=0.05)
    assert result.within_limits is None
    assert any("no contact is on" in warning for warning in result.warnings)


BLOCK = b"""<robot name="block"><link name="block"><inertial><origin xyz="0 0 0.2"/><mass value="3"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
SOLE = ((0.1, 0.05, 0.0), (0.1, -0.05, 0.0), (-0.1, -0.05, 0.0), (-0.1, 0.05, 0.0))


def test_centre_of_pressure_of_a_block_that_is_pushed():
    """A push of F at the height h moves the centre of pressure by F h / W towards where it points."""
    block = robodyn.load(BLOCK, moving_base=True)
    push = robodyn.ExternalWrench("block", (4.0, -2.0, 0.0), point=(0.0, 0.0, 0.3), frame="world")
    scene = robodyn.Scene(moving_base=True, contacts=(Contact("sole", "block", SOLE),), wrenches=(push,))
    q, still = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (30, 1)), np.zeros((30, 6))
    motion = robodyn.motion(block, np.arange(30.0), q, still, still)
    found = robodyn.torques(block, motion, scene).constraints
    assert found is not None
    (sole,) = found.contacts
    expected = np.array([4.0, -2.0, 0.0]) * 0.3 / (3.0 * 9.81)
    assert sole.centre == pytest.approx(expected, abs=1e-12)
    assert sole.margin is not None
    assert sole.margin.value == pytest.approx(0.05 - abs(expected[1]), abs=1e-12)
    assert found.least_friction is not None


def test_limits_that_no_forces_keep(robot, scene):
    """Knees of 16 N m keep them; of a tenth of what they need they cannot, and the first time is told."""
    keeping = replace(scene, contact_cost=ContactCost(within_limits=True))
    kept = robodyn.torques(robot, STAND, keeping)
    assert kept.constraints is not None
    assert kept.constraints.beyond_limits is None
    text = (ROBOTS / "quadruped.urdf").read_text().replace('effort="16"', 'effort="0.4"')
    weak = robodyn.load(text.encode(), moving_base=True)
    result = robodyn.torques(weak, STAND, keeping)
    assert result.constraints is not None
    assert result.constraints.beyond_limits == 0.0
    assert result.within_limits is False


def test_a_base_that_is_held_needs_no_feet(robot, scene):
    found = robodyn.torques(robot, STAND, replace(scene, held=True)).constraints
    assert found is not None
    assert found.balanced
    assert max(foot.force.value for foot in found.contacts) == 0.0


@pytest.mark.parametrize(
    ("contact", "said"),
    [
        (Contact("f", "lf_foot", ()), "'f' has no points"),
        (Contact("f", "lf_foot", ((0.0, np.nan, 0.0),)), "'f' has numbers that are not finite"),
        (Contact("f", "lf_foot", friction=np.nan), "'f' has a friction of nan"),
        (Contact("f", "lf_foot", friction=-0.1), "'f' has a friction of -0.1"),
        (Contact("f", "lf_foot", normal=(0.0, 0.0, 0.0)), "'f' has a normal without a direction"),
        (Contact("f", "foot"), "the robot has no link 'foot'"),
    ],
)
def test_contacts_made_in_python(robot, scene, contact, said):
    q = np.r_[np.zeros(6), 1.0, np.zeros(12)]
    with pytest.raises(SceneError) as caught:
        robodyn.inverse_dynamics(robot, q, 0.0, 0.0, scene=replace(scene, contacts=(contact,)))
    assert said in str(caught.value)


def test_costs_made_in_python(robot, scene):
    q = np.r_[np.zeros(6), 1.0, np.zeros(12)]
    with pytest.raises(SceneError, match="forces is 0 "):
        robodyn.inverse_dynamics(robot, q, 0.0, 0.0, scene=replace(scene, contact_cost=ContactCost(forces=0.0)))
