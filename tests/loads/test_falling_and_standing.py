"""A robot that falls freely with contacts on, and what is left of a base's wrench when contacts carry it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.oracles import ROBOTS

import robodyn
from robodyn import Contact, Scene
from robodyn.errors import InputError

FEET = tuple(Contact(leg, f"{leg}_foot", normal=(0.0, 0.0, 1.0)) for leg in ("lf", "rf", "lh", "rh"))
KNEES = (0.0, 0.68, -1.36) * 2 + (0.0, -0.68, 1.36) * 2


@pytest.fixture(scope="module")
def quadruped():
    return robodyn.load(ROBOTS / "quadruped.urdf", moving_base=True)


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (0.0, 0.0, 0.0)])
def test_nothing_is_missing_where_a_robot_falls(quadruped, gravity):
    """What rounding leaves of forces that cancel is nothing that contacts had to bear."""
    random, samples = np.random.default_rng(4), 50
    turn = random.normal(size=(samples, 4))
    q = np.hstack((random.normal(size=(samples, 3)), turn, random.normal(size=(samples, 12))))
    q[:, 3:7] /= np.linalg.norm(turn, axis=1, keepdims=True)
    qd, tau = random.normal(size=(samples, 18)), np.hstack((np.zeros((samples, 6)), random.normal(size=(samples, 12))))
    free = Scene(gravity=gravity, moving_base=True)
    qdd = robodyn.forward_dynamics(quadruped, q, qd, tau, scene=free)
    scene = Scene(gravity=gravity, moving_base=True, contacts=FEET)
    found = robodyn.torques(quadruped, robodyn.motion(quadruped, np.arange(samples) * 0.1, q, qd, qdd), scene)
    assert found.constraints.balanced
    assert found.constraints.missing == ()
    alone = robodyn.constraint_forces(quadruped, q, qd, qdd, scene=scene)
    assert np.abs(alone.tau - tau).max() <= 1e-11
    assert not any(wrench.any() for wrench in alone.wrenches.values())


def test_what_contacts_carry_is_not_left_to_the_base(quadruped):
    """The laws are checked against the forces that balance, not against the rounding that is left of them."""
    q = np.tile(np.hstack((0.0, 0.0, 0.28, 0.0, 0.0, 0.0, 1.0, KNEES)), (11, 1))
    still = np.zeros((11, 18))
    motion = robodyn.motion(quadruped, np.arange(11) * 0.1, q, still, still)
    found = robodyn.torques(quadruped, motion, Scene(moving_base=True, contacts=FEET))
    assert max(found.checks.first_law, found.checks.second_law, found.checks.power) <= 1e-12
    assert all(part.peak == part.rms == 0.0 for part in found.base_wrench)


def test_what_passive_knees_lack_is_told(quadruped):
    """The base of a robot on limp knees lacks little; the knees lack what bends them."""
    q = np.tile(np.hstack((0.0, 0.0, 0.28, 0.0, 0.0, 0.0, 1.0, KNEES)), (3, 1))
    still, knees = np.zeros((3, 18)), tuple(f"{foot.name}_knee" for foot in FEET)
    scene = Scene(moving_base=True, contacts=FEET, passive=knees)
    found = robodyn.torques(quadruped, robodyn.motion(quadruped, np.arange(3) * 0.1, q, still, still), scene)
    lacks = {each.name: each.most.value for each in found.constraints.unbalanced}
    assert min(abs(lacks[knee]) for knee in knees) > 0.1
    assert sum("N m at the passive 'lf_knee', and 3 more" in caveat.text for caveat in found.caveats) == 1


@pytest.mark.parametrize(
    ("column", "said"),
    [(np.array((1.0, np.nan, 0.0)), "is not a number at 1 of 3 samples"), (np.ones(4), r"has the shape \(4,\)")],
)
def test_columns_of_contacts_fit_the_samples(quadruped, column, said):
    q = np.tile(np.hstack((0.0, 0.0, 0.28, 0.0, 0.0, 0.0, 1.0, KNEES)), (3, 1))
    scene = Scene(moving_base=True, contacts=tuple(replace(foot, on="stands") for foot in FEET))
    with pytest.raises(InputError, match=said):
        robodyn.constraint_forces(quadruped, q, np.zeros(18), np.zeros(18), scene=scene, columns={"stands": column})
