"""Contacts that cannot do what is asked, that a falling robot does not need, or that carry a base: what is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run

import robodyn
from robodyn import Contact, ContactCost, Scene
from robodyn.errors import InputError, SceneError

STAND = str(ROBOTS / "quadruped_stand.csv")


@pytest.fixture(scope="module")
def robot():
    return robodyn.load(ROBOTS / "quadruped.urdf", moving_base=True)


@pytest.fixture(scope="module")
def scene():
    return robodyn.load_scene(ROBOTS / "quadruped_stand.toml")


@pytest.fixture(scope="module")
def some(robot, scene):
    """Every tenth sample of a quadruped that stands."""
    with robodyn.read_motion(STAND, robot, scene) as reader:
        (whole,) = reader.blocks()
    parts = {name: getattr(whole, name)[::10] for name in ("time", "q", "qd", "qdd")}
    return replace(whole, **parts, extra={name: values[::10] for name, values in whole.extra.items()}, sampling=None)


def test_four_feet_under_the_middle_bear_a_quarter_each(tmp_path):
    call = (str(ROBOTS / "quadruped.urdf"), STAND, "--scene", str(ROBOTS / "quadruped_stand.toml"))
    assert run("torques", *call, "--out", str(tmp_path / "out.csv")).status == 0
    first = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)[0]
    for leg in ("lf", "rf", "lh", "rh"):
        force = [first[f"f{axis}_{leg}"] for axis in "xyz"]
        assert force == pytest.approx([0.0, 0.0, 10 * 9.81 / 4], abs=1e-9 * 10 * 9.81)


def test_no_contact_is_on(robot, scene, some):
    """For a fifth of the second; the whole weight is missing then."""
    flying = tuple(replace(foot, on=((0.0, 0.4), (0.6, 2.0))) for foot in scene.contacts)
    result = robodyn.torques(robot, some, replace(scene, contacts=flying))
    assert result.constraints is not None
    (span,) = result.constraints.missing
    assert (span.kind, span.start, span.end) == ("fly", 0.5, 0.5)
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


def test_limits_that_no_forces_keep(robot, scene, some):
    """Knees of 16 N m keep them; of a tenth of what they need they cannot, and the first time is told."""
    keeping = replace(scene, contact_cost=ContactCost(within_limits=True))
    kept = robodyn.torques(robot, some, keeping)
    assert kept.constraints is not None
    assert kept.constraints.beyond_limits is None
    text = (ROBOTS / "quadruped.urdf").read_text().replace('effort="16"', 'effort="0.4"')
    weak = robodyn.load(text.encode(), moving_base=True)
    result = robodyn.torques(weak, some, keeping)
    assert result.constraints is not None
    assert result.constraints.beyond_limits == 0.0
    assert result.within_limits is False


def test_a_base_that_is_held_needs_no_feet(robot, scene, some):
    found = robodyn.torques(robot, some, replace(scene, held=True)).constraints
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
    with pytest.raises(SceneError, match="forces is 0 "):
        robodyn.inverse_dynamics(robot, q, 0.0, 0.0, scene=replace(scene, contact_cost=ContactCost(forces=0.0)))


FEET = tuple(Contact(leg, f"{leg}_foot", normal=(0.0, 0.0, 1.0)) for leg in ("lf", "rf", "lh", "rh"))
CROUCHED = np.hstack((0.0, 0.0, 0.28, 0.0, 0.0, 0.0, 1.0, (0.0, 0.68, -1.36) * 2, (0.0, -0.68, 1.36) * 2))


def crouching(robot, rows):
    still = np.zeros((rows, 18))
    return robodyn.motion(robot, np.arange(rows) * 0.1, np.tile(CROUCHED, (rows, 1)), still, still)


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (0.0, 0.0, 0.0)])
def test_nothing_is_missing_where_a_robot_falls(robot, gravity):
    """What rounding leaves of forces that cancel is nothing that contacts had to bear."""
    random, samples = np.random.default_rng(4), 12
    turn = random.normal(size=(samples, 4))
    q = np.hstack((random.normal(size=(samples, 3)), turn, random.normal(size=(samples, 12))))
    q[:, 3:7] /= np.linalg.norm(turn, axis=1, keepdims=True)
    qd, tau = random.normal(size=(samples, 18)), np.hstack((np.zeros((samples, 6)), random.normal(size=(samples, 12))))
    free = Scene(gravity=gravity, moving_base=True)
    qdd = robodyn.forward_dynamics(robot, q, qd, tau, scene=free)
    scene = Scene(gravity=gravity, moving_base=True, contacts=FEET)
    found = robodyn.torques(robot, robodyn.motion(robot, np.arange(samples) * 0.1, q, qd, qdd), scene)
    assert found.constraints.balanced
    assert found.constraints.missing == ()
    alone = robodyn.constraint_forces(robot, q, qd, qdd, scene=scene)
    assert np.abs(alone.tau - tau).max() <= 1e-11
    assert not any(wrench.any() for wrench in alone.wrenches.values())


def test_what_contacts_carry_is_not_left_to_the_base(robot):
    """The laws are checked against the forces that balance, not against the rounding that is left of them."""
    found = robodyn.torques(robot, crouching(robot, 11), Scene(moving_base=True, contacts=FEET))
    assert max(found.checks.first_law, found.checks.second_law, found.checks.power) <= 1e-12
    assert all(part.peak == part.rms == 0.0 for part in found.base_wrench)


def test_what_passive_knees_lack_is_told(robot):
    """The base of a robot on limp knees lacks little; the knees lack what bends them."""
    knees = tuple(f"{foot.name}_knee" for foot in FEET)
    found = robodyn.torques(robot, crouching(robot, 3), Scene(moving_base=True, contacts=FEET, passive=knees))
    lacks = {each.name: each.most.value for each in found.constraints.unbalanced}
    assert min(abs(lacks[knee]) for knee in knees) > 0.1
    assert sum("N m at the passive 'lf_knee', and 3 more" in caveat.text for caveat in found.caveats) == 1


@pytest.mark.parametrize(
    ("column", "said"),
    [(np.array((1.0, np.nan, 0.0)), "is not a number at 1 of 3 samples"), (np.ones(4), r"has the shape \(4,\)")],
)
def test_columns_of_contacts_fit_the_samples(robot, column, said):
    q = np.tile(CROUCHED, (3, 1))
    scene = Scene(moving_base=True, contacts=tuple(replace(foot, on="stands") for foot in FEET))
    with pytest.raises(InputError, match=said):
        robodyn.constraint_forces(robot, q, np.zeros(18), np.zeros(18), scene=scene, columns={"stands": column})
