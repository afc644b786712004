"""The proof that two texts describe the same dynamics: what it sees, and what it lets pass."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.clean_arm import INERTIA, arm

from robodyn.checks.fixes import SAME, change_of_dynamics, unproven


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('ixx="0.01"', 'ixx="0.0100000001"'),
        ('xyz="0.4 0 0"', 'xyz="0.4 1e-12 0"'),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 1 1e-12"/>'),
        ('<mass value="2"/>', '<mass value="2.000000000001"/>'),
        ('<link name="base"/>', f'<link name="base"><inertial><mass value="1"/>{INERTIA}</inertial></link>'),
        ('type="revolute"', 'type="prismatic"'),
    ],
)
def test_the_proof_sees_small_changes_of_the_dynamics(old: str, new: str) -> None:
    assert unproven(arm().encode(), arm().replace(old, new, 1).encode()) is not None


@pytest.mark.parametrize(
    ("old", "new"), [('effort="30"', 'effort="31"'), ('"0 1 0"', '"0 7 0"'), ("  <link", "\n<link")]
)
def test_the_proof_lets_pass_what_is_no_dynamics(old: str, new: str) -> None:
    assert unproven(arm().encode(), arm().replace(old, new, 1).encode()) is None


@pytest.mark.parametrize("seed", range(8))
def test_what_rounding_makes_of_the_same_dynamics_is_below_the_bound(seed: int) -> None:
    random = np.random.default_rng(seed)
    axes, factors = random.normal(size=(2, 3)), 10 ** random.uniform(-3, 3, size=2)
    shoulder, elbow = (" ".join(map(repr, axis.tolist())) for axis in axes)
    scaled = [" ".join(map(repr, axis.tolist())) for axis in axes * factors[:, None]]
    before, after = arm(shoulder=shoulder, elbow=elbow), arm(shoulder=scaled[0], elbow=scaled[1])
    assert change_of_dynamics(before.encode(), after.encode()) <= SAME


def test_other_joints_are_other_dynamics() -> None:
    renamed = arm().replace("elbow", "knee").encode()
    assert unproven(arm().encode(), renamed) == "it changes the dynamics by inf of the largest torque"


def test_a_robot_without_mass_has_the_same_dynamics_as_itself() -> None:
    assert unproven(b'<robot name="a"><link name="b"/></robot>', b'<robot name="a"> <link name="b"/></robot>') is None
