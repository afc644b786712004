"""Closed chains that pass places at which the loops lose hold of passive joints, and joints that nothing drives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS

import robodyn

SPEED = 2.2
FLAT = 0.5 * np.pi / SPEED
"""s, when the parallelogram's cranks are in line with its coupler: a quarter of a turn after standing upright."""


def four_bar():
    return robodyn.load(ROBOTS / "four_bar.urdf"), robodyn.load_scene(ROBOTS / "four_bar_lift.toml")


WAYS = {"left": 1.0, "right": 1.0, "top": -1.0}


def turning(model, scene, time, state, coordinates=tuple(WAYS)):
    """The cranks turn by the state, an angle and its derivatives; all three angles are given, or some."""
    parts = ({name: WAYS[name] * (of + 0.0 * time) for name in coordinates} for of in state)
    return robodyn.motion(model, time, *parts, scene=scene)


@pytest.mark.parametrize("coordinates", [("left", "right", "top"), ("left",)], ids=len)
@pytest.mark.parametrize("samples", [31, 301, 4001])
def test_times_of_singular_passages(samples, coordinates):
    """Every half turn from the first on, to a thousandth of a step; and no green verdict over them."""
    model, scene = four_bar()
    time = np.linspace(0.0, 3.0, samples)
    result = robodyn.torques(model, turning(model, scene, time, (SPEED * time, SPEED, 0.0), coordinates), scene)
    assert result.constraints is not None
    assert result.constraints.singular == pytest.approx([FLAT, 3.0 * FLAT], abs=0.02 * 3.0 / (samples - 1))
    assert result.within_limits is None
    assert sum("lose hold of passive joints at 0.71" in warning for warning in result.warnings) == 1
    assert not any("open loop" in warning for warning in result.warnings)


def test_a_sample_at_the_place_itself():
    """Nothing is divided through; the torque is taken from beside the place, and told not to be determined."""
    model, scene = four_bar()
    time, found = FLAT * np.linspace(0.9, 1.1, 11), []
    motion = turning(model, scene, time, (SPEED * time, SPEED, 0.0))
    assert np.isfinite(robodyn.inverse_dynamics(model, motion.q, motion.qd, motion.qdd, scene=scene)).all()
    result = robodyn.torques(model, motion, scene, sinks=[lambda time, rows: found.append(rows)])
    tau = found[0][:, 0]
    assert tau[5] == pytest.approx(0.5 * (tau[4] + tau[6]), rel=1e-12)
    assert abs(result.joints[0].peak) <= 16.2
    assert result.constraints is not None
    assert result.constraints.singular == pytest.approx([FLAT], rel=1e-9)
    assert result.within_limits is None


def test_passive_joints_that_nothing_drives():
    """A motion that the drives cannot make is told: which joint, how much and when; it is the open tree's torque."""
    model = robodyn.load(ROBOTS / "puma560.urdf")
    scene = replace(robodyn.Scene(), passive=("elbow",))
    motion = ROBOTS / "puma560_sweep.csv"
    free = {joint.name: joint for joint in robodyn.torques(model, str(motion)).joints}
    result = robodyn.torques(model, str(motion), scene)
    assert result.constraints is not None
    (elbow,) = result.constraints.unbalanced
    assert (elbow.name, elbow.unit) == ("elbow", "N m")
    assert elbow.most.value == pytest.approx(free["elbow"].peak, rel=1e-12)
    assert elbow.most.time == free["elbow"].peak_time
    assert result.constraints.undriven == ("elbow",)
    assert result.within_limits is None
    assert any("nothing drives 'elbow', and the motion takes 11.2 N m there" in said for said in result.warnings)


def test_a_robot_that_first_rests_at_a_singular_place():
    """It lies flat for more than the samples that are worked on at a time; then its torques are those of any motion."""
    model, scene = four_bar()
    time = 1e-3 * np.arange(7000)
    s = np.clip((time - 5.0) / 2.0, 0.0, 1.0)
    angle = 0.5 * np.pi * (1.0 - 0.5 * s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
    rate = -0.25 * np.pi * 15.0 * (s * (1.0 - s)) ** 2
    second = -0.25 * np.pi * 15.0 * (s * (1.0 - s) * (1.0 - 2.0 * s))
    motion, found, late = turning(model, scene, time, (angle, rate, second)), [], 6000
    result = robodyn.torques(model, motion, scene, sinks=[lambda time, rows: found.append(rows)])
    expected = robodyn.inverse_dynamics(model, motion.q[late:], motion.qd[late:], motion.qdd[late:], scene=scene)
    tau = np.concatenate(found)[late:, 0]
    np.testing.assert_allclose(tau, expected[:, 0], rtol=0, atol=1e-12 * np.abs(expected).max())
    assert result.constraints is not None
    assert (result.constraints.rank, result.constraints.freedoms, result.constraints.undriven) == (2, 1, ())
    assert result.constraints.singular[0] == 0.0
    assert {each.name for each in result.constraints.unbalanced} == {"right", "top"}
    assert all(each.most.time < 5.02 for each in result.constraints.unbalanced)
    assert not any("energy balance" in said for said in result.warnings)
