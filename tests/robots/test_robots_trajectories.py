"""The trajectories of robots/: generated bit for bit, consistent with themselves, within the limits of their robots."""

from __future__ import annotations

import make_robots
import numpy as np
import pytest
from helpers.robot_files import FOLDER, FULL, MOTORS_ONLY, model, read_csv, stacked, torques
from helpers.sampled import sampled
from helpers.scene_files import read_scene

from robodyn.robot.urdf.description import load_description

MOVED_BY_JOINTS = sorted({**FULL, **MOTORS_ONLY})
PERIODIC = ["puma560_sweep", "puma_polish", "two_link_planar_swing"]
POINT_TO_POINT = sorted({*FULL, *MOTORS_ONLY} - {*PERIODIC, "delta_pick", "planar_3rrr_circle"})
KNOTS = 9


def _limits(name):
    return {joint.name: joint for joint in load_description(FOLDER / f"{(FULL | MOTORS_ONLY)[name]}.urdf").joints}


def _joints(table):
    return [column[3:] for column in table if column.startswith("qd_")]


@pytest.mark.parametrize("name", sampled(make_robots.TRAJECTORIES))
def test_regenerated_bit_for_bit(name):
    assert make_robots.text(make_robots.TRAJECTORIES[name]).encode() == (FOLDER / name).read_bytes()


@pytest.mark.parametrize("name", MOVED_BY_JOINTS)
def test_within_position_and_velocity_limits_and_every_joint_moves(name):
    table, limits = read_csv(name), _limits(name)
    for joint in _joints(table):
        q, qd = table[f"q_{joint}"], table[f"qd_{joint}"]
        assert np.abs(qd).max() <= limits[joint].limit.velocity
        assert np.abs(qd).max() >= 0.1 * limits[joint].limit.velocity
        if limits[joint].type != "continuous":
            assert limits[joint].limit.lower <= q.min()
            assert q.max() <= limits[joint].limit.upper


@pytest.mark.parametrize("name", sorted(set(FULL) - {"satellite_slew", "gripper_pick"}))
def test_within_effort_limits(name):
    table, limits, robot = read_csv(name), _limits(name), model(FULL[name])
    names = list(robot.names)[1:]
    q, qd, qdd = (stacked(table, [f"{level}_{joint}" for joint in names]) for level in ("q", "qd", "qdd"))
    tau = torques(robot, q, qd, qdd)
    if name == "puma560_sweep":
        tau += _friction_and_rotors(read_scene("puma560_motors"), names, qd, qdd)
    peaks = np.abs(tau).max(axis=0)
    efforts = np.array([limits[joint].limit.effort for joint in names])
    assert (peaks <= efforts).all(), dict(zip(names, zip(peaks, efforts, strict=True), strict=True))


def _friction_and_rotors(scene, names, qd, qdd):
    columns = []
    for i, joint in enumerate(names):
        rotor, friction = scene["rotor"][joint], scene["friction"][joint]
        forward, backward = friction["coulomb"]
        coulomb = np.where(qd[:, i] > 0, forward, np.where(qd[:, i] < 0, backward, 0))
        columns.append(rotor["gear"] ** 2 * rotor["inertia"] * qdd[:, i] + friction["viscous"] * qd[:, i] + coulomb)
    return np.column_stack(columns)


@pytest.mark.parametrize("name", PERIODIC)
def test_periodic_derivatives_are_those_of_the_fourier_series(name):
    table = read_csv(name)
    period = table["time"][-1]
    for joint in _joints(table):
        q, qd, qdd = (table[f"{level}_{joint}"][:-1] for level in ("q", "qd", "qdd"))
        w = 2j * np.pi * np.fft.rfftfreq(len(q), period / len(q))
        spectrum = np.where(np.arange(len(w)) <= 4, np.fft.rfft(q), 0)
        for given, power in ((qd, 1), (qdd, 2)):
            derived = np.fft.irfft(w**power * spectrum, len(q))
            np.testing.assert_allclose(derived, given, rtol=0, atol=1e-14 * np.abs(w[4]) ** power)
        np.testing.assert_allclose(np.fft.irfft(spectrum, len(q)), q, rtol=0, atol=1e-14)


def hermite_defect(h, f, fd, fdd):
    """f(t+h) - f(t-h) against the rule that is exact to degree 6 from both derivatives at three samples."""
    rule = h / 15 * (7 * fd[:-2] + 16 * fd[1:-1] + 7 * fd[2:]) + h * h / 15 * (fdd[:-2] - fdd[2:])
    return np.abs(f[2:] - f[:-2] - rule)


@pytest.mark.parametrize("name", POINT_TO_POINT)
def test_point_to_point_is_a_quintic_between_its_knots(name):
    """Both rules hold to rounding except across a knot, where only the jerk may jump."""
    table = read_csv(name)
    h = table["time"][1]
    for joint in _joints(table):
        q, qd, qdd = (table[f"{level}_{joint}"] for level in ("q", "qd", "qdd"))
        scale = np.abs(q).max()
        assert np.count_nonzero(hermite_defect(h, q, qd, qdd) > 1e-14 * scale) <= KNOTS
        simpson = np.abs(qd[2:] - qd[:-2] - h / 3 * (qdd[:-2] + 4 * qdd[1:-1] + qdd[2:]))
        assert np.count_nonzero(simpson > 1e-14 * scale / h) <= KNOTS
        assert hermite_defect(h, q, qd, qdd).max() <= 3e-4 * h * h * np.abs(qdd).max()


def test_waves_and_encoder_are_the_same_motion():
    waves, encoder = read_csv("puma_waves"), read_csv("puma_encoder")
    step = 2 * np.pi / 2**17
    np.testing.assert_array_equal(waves["t"][:200], encoder["t"][::5])
    for joint in ("waist", "shoulder", "elbow"):
        counts = encoder[joint] / step
        np.testing.assert_allclose(counts, np.round(counts), rtol=0, atol=1e-10)
        assert np.abs(encoder[joint][::5] - waves[joint][:200]).max() <= 0.5 * step * (1 + 1e-9)
