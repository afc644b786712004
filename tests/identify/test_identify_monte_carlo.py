"""Intervals of parameters and of torques of identified robots hold as often as they say.

Tuned on sines and on point-to-point moves of other seeds; trapezoids are told of, not tuned on.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.identified_logs import Bench, coloured, quintics, trapezoids, waves, white, write_log
from helpers.misfit_logs import deviation, with_bodies
from helpers.oracles import ROBOTS

import robodyn
from robodyn.identification.identify import identify
from robodyn.identification.log.log import read_log
from robodyn.identification.result import covariance
from robodyn.scene.scene import Friction, Scene

LEVEL = 1.96


def robot(name):
    return robodyn.load(path_of(name) if name == "ur5_robot" else ROBOTS / f"{name}.urdf")


def held(bench, noise, count, motion):
    """Which intervals hold the truth, of parameters, of torques on another motion and of peaks; and errors / spread."""
    other = np.stack([rows[::8, bench.base.independent] for rows in bench.rows(bench.filtered(motion))])
    true = other @ bench.beta
    peaks = np.abs(true).argmax(axis=1)
    joints = np.arange(len(other))
    parameters, torques, highest, errors = [], [], [], []
    for values, C in bench.logs(noise, count):
        errors.append(values - bench.beta)
        parameters.append(np.abs(errors[-1]) < LEVEL * np.sqrt(np.diag(C)))
        deviation = np.sqrt(np.einsum("jkr,rs,jks->jk", other, C, other, optimize=True))
        torques.append(np.abs(other @ errors[-1]) < LEVEL * deviation)
        highest.append(torques[-1][joints, peaks])
    spread = np.std(errors, axis=0) / np.sqrt(count)
    return np.mean(parameters), np.mean(torques), np.mean(highest), np.abs(np.mean(errors, axis=0) / spread)


def test_a_few_logs_of_a_small_robot():
    """Twenty-five logs: parameters of one log are held or not together, which makes 2 % of the share chance."""
    bench = Bench(robot("two_link_spatial"), waves, 21)
    parameters, torques, _, bias = held(bench, white, 25, quintics)
    assert 0.90 <= parameters <= 0.99
    assert 0.90 <= torques <= 0.99
    assert bias.max() < 4.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["two_link_spatial", "scara", "ur5_robot"])
def test_intervals_hold_the_truth(name):
    """Torques' noise is white or lies below 4 Hz, inside of the filter's band of 6 Hz."""
    found, logs = [], 15 if name == "ur5_robot" else 50
    for seed, (motion, other) in enumerate(((waves, quintics), (quintics, waves), (trapezoids, waves))):
        bench = Bench(robot(name), motion, 30 + seed)
        found += [held(bench, noise, logs, other) for noise in (white, coloured)]
    parameters, torques, peaks, bias = zip(*found, strict=True)
    assert 0.93 <= np.mean(parameters) <= 0.97
    assert 0.93 <= np.mean(torques) <= 0.97
    assert 0.92 <= np.mean(peaks) <= 0.98
    assert np.mean(np.concatenate(bias) > 3.0) < 0.02


@pytest.mark.slow
def test_the_whole_of_identify_with_noisy_positions(tmp_path):
    """Derivatives, outliers, choices and all, with 1e-5 rad of noise; torques by the covariance that is written.

    These are drawn to the description, so that their intervals are wide.
    """
    model = robot("two_link_spatial")
    scene = Scene(friction={name: Friction(0.5, 0.8, -0.8) for name in model.rates})
    rng = np.random.default_rng(41)
    time = 0.004 * np.arange(6000)
    states, other = waves(rng, time, model.n), waves(rng, time[:300] * 10.0, model.n)
    tau, true = (robodyn.inverse_dynamics(model, *each, scene=scene) for each in (states, other))
    torques = []
    for _ in range(8):
        q = states[0] + 1e-5 * rng.standard_normal(tau.shape)
        noisy = tau + 0.03 * np.sqrt((tau**2).mean(axis=0)) * rng.standard_normal(tau.shape)
        write_log(tmp_path / "log.csv", model, time, q, noisy)
        found = identify([read_log(str(tmp_path / "log.csv"), model)])
        calibrated = with_bodies(model, found.names, found.theta)
        off = robodyn.inverse_dynamics(calibrated, *other, scene=found.scene) - true
        torques.append(np.abs(off) < LEVEL * deviation(calibrated, found.scene, other, covariance(found)))
    assert np.mean(torques) >= 0.93
