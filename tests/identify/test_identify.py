"""What `identify` finds of logs whose truth is known; rows on even grids, their noise and their filter."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run
from helpers.identified_logs import quintics, waves, write_log

import robodyn
from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.identification.identify import identify
from robodyn.identification.log.log import noise_cutoff, read_log
from robodyn.identification.log.rows import convolved, filtered, kernel, rates, states
from robodyn.identification.model_selection import joint_motors
from robodyn.identification.parameters.regressor_columns import Gathered, Guess, Moments, RegressorColumns, gather
from robodyn.scene.scene import DEFAULT, CoupledMotor, Friction, Rotor, Scene, Spring
from robodyn.scene.uncertainty import Uncertainty, read_covariance

SPATIAL = ROBOTS / "two_link_spatial.urdf"
TIME = 0.005 * np.arange(2400)
KINDS = {"coulomb": "N m", "offset": "N m"} | {
    kind: "kg" if kind == "m" else "kg m" if kind[0] == "m" else "kg m^2" for kind in INERTIAL
}


def logged(path, robot, motion, scene, rng, *, noise=0.0, rates=True, time=TIME):
    """Write a log of a robot in a scene; return its model, the motion and the torques without noise."""
    model = robodyn.load(robot)
    states = motion(rng, time, model.n)
    tau = robodyn.inverse_dynamics(model, *states, scene=scene)
    noisy = tau + noise * np.sqrt((tau**2).mean(axis=0)) * rng.standard_normal(tau.shape)
    q, qd, qdd = states
    write_log(path, model, time, q, noisy, *((qd, qdd) if rates else ()))
    return model, states, tau


def friction(model, *values):
    return {name: Friction(*values) for name in model.rates}


def off_truth(found, scene):
    """Return how far base parameters are off the truth, by unit, in parts of the largest of a unit; none of breakaway.

    Breakaway is told of few samples, and not at all where signs of derived speeds are smoothed.
    """
    model = found.model
    zero = np.zeros(model.n)
    at = regressor(model, zero, zero, zero, scene=scene)
    true = dict(zip(at.names, at.theta.tolist(), strict=True))
    for name in model.rates:
        forward, backward = true[f"{name}.forward"], true[f"{name}.backward"]
        true |= {f"{name}.coulomb": (forward - backward) / 2, f"{name}.offset": (forward + backward) / 2}
        true[f"{name}.stribeck"] = true[f"{name}.coulomb"]
    base = found.base.base
    beta = base.values(np.array([true[name] for name in base.names]))
    kinds = [base.names[k].rpartition(".")[2] for k in base.independent]
    units = np.array([KINDS.get(kind, kind) for kind in kinds])
    own = [units == unit for unit in set(units) - {"stribeck"}]
    return max(np.abs(found.base.values - beta)[rows].max() / (np.abs(beta[rows]).max() or 1.0) for rows in own)


@pytest.mark.parametrize("name", ["scara", pytest.param("two_link_spatial", marks=pytest.mark.slow)])
def test_exact_logs_give_exact_base_parameters(name, tmp_path):
    robot = ROBOTS / f"{name}.urdf"
    names = robodyn.load(robot).rates
    scene = Scene(friction=friction(robodyn.load(robot), 0.5, 0.8, -0.6), rotor={each: Rotor(0.03) for each in names})
    model, _, _ = logged(tmp_path / "log.csv", robot, waves, scene, np.random.default_rng(1), time=TIME[:1000])
    found = identify([read_log(str(tmp_path / "log.csv"), model)])
    assert off_truth(found, scene) < 1e-10


@pytest.mark.parametrize(
    ("values", "bound"), [pytest.param((0.5,), 1e-6, marks=pytest.mark.slow), ((0.5, 0.8, -0.8), 1e-4)]
)
def test_positions_alone_give_what_their_derivatives_allow(values, bound, tmp_path):
    """Splines at 200 Hz of motions up to 1.2 Hz; dry friction is smoothed at turns."""
    scene = Scene(friction=friction(robodyn.load(SPATIAL), *values))
    model, _, _ = logged(
        tmp_path / "log.csv", SPATIAL, waves, scene, np.random.default_rng(1), rates=False, time=TIME[:1200]
    )
    assert off_truth(identify([read_log(str(tmp_path / "log.csv"), model)]), scene) < bound


@pytest.mark.slow
def test_the_files_make_the_torques_that_were_logged(tmp_path, monkeypatch):
    """Friction by direction, breakaway, rotors, a coupled motor: what is written explains another motion as the log."""
    monkeypatch.chdir(tmp_path)
    robot = ROBOTS / "puma560.urdf"
    model = robodyn.load(robot)
    wrist = dict.fromkeys(model.rates[4:], 1.0)
    scene = Scene(
        friction={**friction(model, 0.5, 0.8, -0.6), "elbow": Friction(0.5, 0.8, -0.8, 2.0, 0.2)},
        rotor={"waist": Rotor(0.3)},
        coupled=(CoupledMotor("wrist", wrist, 0.05, 1.0, Friction(0.6, 2.0, -2.0)),),
    )
    logged("log.csv", robot, waves, scene, np.random.default_rng(2), noise=0.01, time=0.005 * np.arange(3000))
    done = run("identify", str(robot), "log.csv", "--out", "found.urdf", "--scene-out", "found.toml")
    assert done.status == 0, done.err
    states = quintics(np.random.default_rng(3), TIME[:500], model.n)
    tau = robodyn.inverse_dynamics(model, *states, scene=scene)
    found = robodyn.load_scene("found.toml")
    off = robodyn.inverse_dynamics(robodyn.load("found.urdf"), *states, scene=found) - tau
    plain = robodyn.inverse_dynamics(model, *states) - tau
    assert np.linalg.norm(off) < 0.01 * np.linalg.norm(tau) < 0.1 * np.linalg.norm(plain)
    assert found.friction["elbow"].stribeck == pytest.approx(2.0, rel=0.2)
    (motor,) = found.coupled
    assert dict(motor.joints) == wrist
    assert motor.inertia == pytest.approx(0.05, rel=0.1)


def test_friction_that_grows_with_load(tmp_path, monkeypatch):
    """It is found at the joints that have it, told nowhere else, and its file makes the torques of another motion."""
    monkeypatch.chdir(tmp_path)
    robot = ROBOTS / "puma.urdf"
    model = robodyn.load(robot)
    some = {name: Friction(0.5, 1.0, -1.0, load=0.1) for name in model.rates[1:]}
    scene = Scene(friction={**friction(model, 0.5, 1.0, -1.0), **some})
    logged("log.csv", robot, waves, scene, np.random.default_rng(5), noise=0.01, time=TIME[:1000])
    outputs = ("--out", "found.urdf", "--scene-out", "found.toml", "--covariance", "found.json")
    done = run("identify", str(robot), "log.csv", *outputs)
    assert done.status == 0, done.err
    found = robodyn.load_scene("found.toml")
    known = Uncertainty(covariance=read_covariance("found.json"))
    assert found.friction[model.rates[0]].load == 0.0
    for name in some:
        assert found.friction[name].load == pytest.approx(0.1, rel=0.1)
    states = quintics(np.random.default_rng(6), TIME[:500], model.n)
    tau = robodyn.inverse_dynamics(model, *states, scene=scene)
    off = robodyn.inverse_dynamics(robodyn.load("found.urdf"), *states, scene=found) - tau
    assert np.linalg.norm(off) < 0.01 * np.linalg.norm(tau)
    calibrated = robodyn.load("found.urdf")
    motion = robodyn.motion(calibrated, TIME[:500], *states)
    bars = robodyn.torques(calibrated, motion, replace(found, uncertainty=known)).uncertainty
    assert {f"{name}.load" for name in some} <= set(bars.parameters)
    for joint, true in zip(bars.joints, np.abs(tau).max(axis=0), strict=True):
        assert abs(abs(joint.load.peak.value) - true) < 4.0 * joint.load.peak.standard_error


def test_springs_and_payloads_of_the_scene_are_known(tmp_path):
    model = robodyn.load(SPATIAL)
    scene = Scene(spring={model.rates[1]: Spring(20.0, 0.1)}, friction=friction(model, 0.5, 0.8, -0.8))
    logged(tmp_path / "log.csv", SPATIAL, waves, scene, np.random.default_rng(4), noise=0.01, time=TIME[:800])
    found = identify([read_log(str(tmp_path / "log.csv"), model, scene)], scene)
    assert found.held_out.relative_error < 0.01
    assert found.scene.spring == scene.spring


def test_units_do_not_count(tmp_path):
    """Torques, masses and friction of a robot a million times as heavy."""
    factor = 1e6
    scene = Scene(friction=friction(robodyn.load(SPATIAL), 0.5 * factor, 0.8 * factor, -0.6 * factor))
    entry = re.compile(r'((?:\bi[xyz]{2}|mass value)=")([^"]+)"')
    text = entry.sub(lambda found: f'{found[1]}{float(found[2]) * factor!r}"', SPATIAL.read_text())
    (tmp_path / "robot.urdf").write_text(text)
    model, _, _ = logged(
        *(tmp_path / "log.csv", tmp_path / "robot.urdf", waves, scene, np.random.default_rng(5)),
        noise=0.01,
        time=TIME[:800],
    )
    found = identify([read_log(str(tmp_path / "log.csv"), model)])
    assert found.held_out.relative_error < 0.01
    assert found.consistent


def test_what_is_kept_does_not_grow(tmp_path):
    kept = []
    for count in (2000, 4000):
        path = tmp_path / f"{count}.csv"
        time = 0.01 * np.arange(count)
        model, _, _ = logged(path, SPATIAL, waves, DEFAULT, np.random.default_rng(6), noise=0.01, time=time)
        regressor = RegressorColumns(model, DEFAULT, range(model.n), joint_motors(model), 0.0)
        guess = Guess(np.zeros(len(regressor.names)), np.ones(model.n), Moments(regressor))
        plain, weighted = Gathered(2, regressor), Gathered(2, regressor)
        gather(read_log(str(path), model), 2.0, (count / 200,), plain, weighted, guess)
        triangles = [each.R.nbytes for found in (plain, weighted) for fold in found.parts for each in fold]
        kept.append(sum(triangles) + sum(each.nbytes for each in guess.moments.columns))
    assert kept[0] == kept[1]


@pytest.mark.slow
def test_rounding_explains_no_torque(tmp_path):
    """Quarter turns that are no exact floats leave columns of 1e-17: at unit length they would be noise to fit with."""
    model, scene = robodyn.load(ROBOTS / "puma560.urdf"), Scene()
    rng, time = np.random.default_rng(11), TIME[:800]
    q, qd, qdd = waves(rng, time, model.n)
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene)
    tau += 0.05 * np.sqrt((tau**2).mean(axis=0)) * rng.standard_normal(tau.shape)
    found = []
    for factor in (1.0, 1.0 + 2.0**-52):
        write_log(tmp_path / "log.csv", model, time, factor * q, tau, qd, qdd)
        found.append(identify([read_log(str(tmp_path / "log.csv"), model)], cutoff=10.0))
    for first, second in (
        (found[0].theta, found[1].theta),
        (found[0].base.values, found[1].base.values),
        (found[0].base.standard_errors, found[1].base.standard_errors),
    ):
        assert np.abs(first - second).max() < 1e-10 * np.abs(first).max()


ARM = ROBOTS / "two_link_planar.urdf"
STEP = 0.004


def log_of(folder, time, q, tau, cutoff=None):
    write_log(folder / "log.csv", robodyn.load(ARM), time, q, tau)
    return read_log(str(folder / "log.csv"), robodyn.load(ARM), cutoff=cutoff)


def swing(time):
    return np.column_stack([np.sin(3.0 * time), 0.5 * np.cos(5.0 * time)])


def test_the_kernel_passes_and_stops():
    taps = kernel(20.0, STEP)
    assert taps.sum() == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_array_equal(taps, taps[::-1])
    time = STEP * np.arange(2000)
    for frequency, passes in ((5.0, 1.0), (14.0, 1.0), (20.0, 0.5), (26.0, 0.0), (60.0, 0.0)):
        wave = np.cos(2.0 * np.pi * frequency * time)[:, None]
        reach = len(taps) // 2
        np.testing.assert_allclose(convolved(wave, taps)[:, 0], passes * wave[reach:-reach, 0], atol=2e-4)


def test_derivatives_of_what_passes():
    time = STEP * np.arange(2000)
    w = 2.0 * np.pi * 2.0
    kernels = rates(kernel(20.0, STEP), STEP)
    reach = len(kernels[0]) // 2
    inner = time[reach:-reach]
    expected = np.sin(w * inner), w * np.cos(w * inner), -w * w * np.sin(w * inner)
    for taps, values in zip(kernels, expected, strict=True):
        found = convolved(np.sin(w * time)[:, None], taps)[:, 0]
        np.testing.assert_allclose(found, values, atol=1.5e-4 * np.abs(values).max())


@pytest.mark.parametrize("noise", [0.0, 1e-5])
def test_blocks_change_nothing(noise, tmp_path, monkeypatch):
    """Rows of a log in blocks of 100 samples are those of the log at once."""
    time = STEP * np.arange(2500)
    q = swing(time) + noise * np.random.default_rng(1).normal(size=(len(time), 2))
    log = log_of(tmp_path, time, q, np.cos(swing(time)), cutoff=12.0)
    assert log.noisy == bool(noise)
    whole = [np.concatenate(parts) for parts in zip(*filtered(log, 12.0, lambda s: s.qdd), strict=True)]
    monkeypatch.setattr("robodyn.identification.log.rows._ROWS", 100)
    parts = [np.concatenate(parts) for parts in zip(*filtered(log, 12.0, lambda s: s.qdd), strict=True)]
    for one, other in zip(whole, parts, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12 * np.abs(one).max())
    if not noise:
        exact = -np.array([9.0, 25.0]) * swing(whole[0])
        np.testing.assert_allclose(whole[1], exact, atol=5e-4 * np.abs(exact).max())


def test_uneven_stamps_are_put_on_a_grid(tmp_path):
    rng = np.random.default_rng(2)
    time = STEP * (np.arange(2000) + rng.uniform(-0.3, 0.3, 2000))
    log = log_of(tmp_path, time, swing(time), swing(time))
    assert not log.even
    found = list(log.blocks())
    stamps = np.concatenate([each.time for each in found])
    np.testing.assert_allclose(np.diff(stamps), log.step, rtol=1e-9)
    np.testing.assert_allclose(np.concatenate([each.q for each in found]), swing(stamps), atol=1e-6)
    np.testing.assert_allclose(np.concatenate([each.tau for each in found]), swing(stamps), atol=2e-4)


def test_no_window_reaches_over_a_gap(tmp_path):
    time = STEP * np.concatenate([np.arange(1000), np.arange(1100, 2000)])
    log = log_of(tmp_path, time, swing(time), swing(time), cutoff=12.0)
    assert [each.begins for each in states(log, 12.0)] == [True, True]
    stamps = np.concatenate([rows.time for rows in filtered(log, 12.0, lambda s: s.q)])
    reach = STEP * (len(kernel(12.0, STEP)) // 2)
    assert not ((stamps > 999 * STEP - reach + 1e-9) & (stamps < 1100 * STEP + reach - 1e-9)).any()


def test_noise_sets_the_cutoff():
    """Motion below 3 Hz and white noise: the cutoff lies between; lines of a converter do not count."""
    rng = np.random.default_rng(3)
    time = 0.001 * np.arange(20000)
    tau = 10.0 * np.sin(2.0 * np.pi * np.outer(time, [0.5, 1.0, 3.0])) @ np.ones((3, 2))
    noisy = tau + 0.1 * rng.normal(size=tau.shape)
    assert 3.0 <= noise_cutoff(noisy, 0.001) <= 12.0
    assert noise_cutoff(noisy + 3.0 * np.sin(2.0 * np.pi * 180.0 * time)[:, None], 0.001) <= 12.0
