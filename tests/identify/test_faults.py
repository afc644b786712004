"""Injected faults are found, alone and in pairs, within their stated errors; gross ones, and nothing in noise."""

from __future__ import annotations

import json
import re
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np
import polars
import pytest
from helpers.command_line import ROBOTS, run
from helpers.example_robots import path_of
from helpers.faulty_logs import Bench
from helpers.identified_logs import waves, write_log

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.identification.faults.compare import channels, evidence_of, rerouted
from robodyn.identification.faults.faults import OWN, ROTOR, explain
from robodyn.identification.log.log import read_log
from robodyn.robot.load import load
from robodyn.scene.scene import Friction, Scene

ROBOT = ROBOTS / "puma.urdf"
JOINTS = {"gain": 1, "offset": 0, "viscous": 2, "coulomb": 1, "rotor": 0, "delay": 2, "payload": None}
SIGMAS = 4.5
"""All estimates of a test lie within so many standard errors: of 3000 normal ones one in 50 such tests would not."""


@pytest.fixture(scope="module")
def bench():
    return Bench(ROBOTS / "puma560.urdf")


@pytest.fixture(scope="module")
def arm():
    """Return one of three joints, which tell no payload apart from their rotors and gains."""
    return Bench(ROBOTS / "puma.urdf")


def of(bench, *kinds):
    return [(kind, JOINTS[kind], 0.0 if kind == "payload" else bench.size(kind, JOINTS[kind])) for kind in kinds]


def check_found(bench, faults, tau):
    found = explain(bench.evidence(tau))
    told = {(fault.effect.kind, fault.effect.joint): fault for fault in found.faults}
    truth = bench.truth(faults)
    assert {(kind, j) for kind, j, _ in faults} <= set(told)
    for fault in told.values():  # one log in a hundred tells one that is not there, hardly beyond noise
        errors = np.sqrt(np.diag(fault.covariance))
        off = np.abs(fault.values - truth[list(fault.effect.places)])
        assert (off <= SIGMAS * errors).all() or not fault.certain, fault
    return found


@pytest.mark.parametrize("kind", JOINTS)
def test_each_fault_alone(bench, kind):
    rng = np.random.default_rng([*JOINTS].index(kind))
    faults = of(bench, kind)
    found = check_found(bench, faults, bench.injected(faults) + bench.noise(rng, "white", 0.02))
    fault, j = found.faults[0], JOINTS[kind]
    assert fault.effect.kind == kind
    assert fault.shares[1 if j is None else j] > 0.8


PAIRS = [*combinations(JOINTS, 2)]
QUICK, SLOW = ("gain", "payload"), PAIRS[::3]


@pytest.mark.parametrize("pair", [QUICK, *(pytest.param(pair, marks=pytest.mark.slow) for pair in SLOW)], ids="-".join)
def test_faults_in_pairs(bench, pair):
    rng = np.random.default_rng(PAIRS.index(pair))
    faults = of(bench, *pair)
    check_found(bench, faults, bench.injected(faults) + bench.noise(rng, "band", 0.02))


def test_without_noise_faults_are_exact(bench):
    """But a delay, which is found by splines through the filtered samples."""
    faults = of(bench, "gain", "offset", "viscous", "coulomb", "rotor", "payload")
    found = explain(bench.evidence(bench.injected(faults)))
    truth = bench.truth(faults)
    told = sorted(found.told)
    scale = np.maximum(np.abs(truth), 1.0)
    np.testing.assert_allclose((found.theta / scale)[told], (truth / scale)[told], atol=1e-9)


@pytest.mark.parametrize("kind", ["white", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("band", "red"))])
def test_noise_alone_tells_nothing(bench, kind):
    tau = bench.tau + bench.noise(np.random.default_rng(3), kind)
    assert explain(bench.evidence(tau)).faults == ()


@pytest.mark.parametrize("faults", [(), ("gain", "payload")])
def test_exchanged_torques_are_found(arm, faults):
    tau = arm.injected(of(arm, *faults)) + arm.noise(np.random.default_rng(2), "white")
    right = channels(arm.evidence(tau[:, [0, 2, 1]]))
    assert right.source == (0, 2, 1)
    assert right.sign == (1, 1, 1)
    assert right.exchanged == [(1, 2)]
    as_meant = arm.evidence(tau).measured
    found = rerouted(arm.evidence(tau[:, [0, 2, 1]]), right).measured
    np.testing.assert_allclose(found, as_meant, rtol=0.0, atol=1e-14 * np.abs(as_meant).max())


@pytest.mark.parametrize("j", range(3))
def test_a_wrong_sign_is_found(arm, j):
    tau = arm.injected(of(arm, "coulomb", "viscous")) + arm.noise(np.random.default_rng(2), "white")
    tau[:, j] *= -1.0
    right = channels(arm.evidence(tau))
    assert right.reversed == [j]
    assert right.exchanged == []


def test_a_sign_is_told_by_friction_alone(bench):
    """The wrist hardly carries anything; friction that drives would be one with the wrong sign."""
    tau = bench.tau.copy()
    tau[:, 5] -= 0.5 * np.sign(bench.qd[:, 5])
    assert channels(bench.evidence(tau)).reversed == [5]


@pytest.mark.parametrize("kinds", [("delay",), ("payload",), ("gain", "offset")])
def test_nothing_gross_is_found_where_nothing_is(arm, kinds):
    tau = arm.injected(of(arm, *kinds)) + arm.noise(np.random.default_rng(2), "red")
    right = channels(arm.evidence(tau))
    assert right.exchanged == []
    assert right.reversed == []


def test_what_a_payload_may_explain_is_no_certain_rotor():
    """The last joint of a SCARA cannot tell its rotor from a mass on it; what would do is said so."""
    bench = Bench(ROBOTS / "scara.urdf")
    rotor = [("rotor", 2, bench.size("rotor", 2))]
    tau = bench.injected(rotor) + bench.noise(np.random.default_rng(0), "white", 0.02)
    found = explain(bench.evidence(tau))
    assert len(OWN) * 2 + ROTOR not in found.told
    assert found.faults
    assert not any(fault.certain for fault in found.faults)


class Judged(NamedTuple):
    """Errors of injected parameters that are told, in standard errors, and of all others; certain faults that were not
    injected, and injected ones beyond six errors that are not told."""

    off: np.ndarray
    rest: np.ndarray
    false: list
    missed: list


def judged(folder, seed, robots, longest):
    """What is told of a log by a file, with noise of positions: robot, length, rate, noise and 0 to 2 faults drawn."""
    rng = np.random.default_rng([19, seed])
    duration, step = float(rng.uniform(0.5, 1.0) * longest), float(rng.choice([0.002, 0.004, 0.01]))
    bench = Bench(robots[rng.integers(len(robots))], duration, step, seed)
    faults = []
    joints = rng.permutation(bench.model.n).tolist()
    for kind, j in zip(rng.choice([*JOINTS], seed % 3, replace=False).tolist(), joints, strict=False):
        sign = rng.choice([-1.0, 1.0]) if kind in ("gain", "offset", "delay") else 1.0
        size = sign * rng.uniform(0.2, 1.0) * bench.size(kind, j)
        faults.append((kind, None, 0.0) if kind == "payload" else (kind, j, size))
    noise = bench.noise(rng, str(rng.choice(["white", "red"])), float(10.0 ** rng.uniform(-2.3, -1.3)))
    q = bench.q + 10.0 ** rng.uniform(-5.0, -4.0) * rng.standard_normal(bench.q.shape)
    columns = {"q": q, "tau": bench.injected(faults) + noise}
    named = {f"{kind}_{name}": x[:, k] for kind, x in columns.items() for k, name in enumerate(bench.model.rates)}
    polars.DataFrame({"time": bench.time, **named}).write_parquet(folder / "log.parquet")
    found = explain(evidence_of(read_log(str(folder / "log.parquet"), bench.model))[0])
    told, truth = sorted(found.told), bench.truth(faults)
    errors, injected = np.sqrt(np.diag(found.covariance)[told]), truth[told] != 0.0
    z = (found.theta - truth)[told] / errors
    found_ones = {(fault.effect.kind, fault.effect.joint): fault.certain for fault in found.faults}
    clear = [fault for fault in faults if (np.abs(bench.truth([fault]))[told] > 6.0 * errors).any()]
    return Judged(
        z[injected],
        z[~injected],
        [key for key, certain in found_ones.items() if certain and key not in {fault[:2] for fault in faults}],
        [fault for fault in clear if fault[:2] not in found_ones],
    )


def test_a_few_logs_of_a_small_robot(tmp_path):
    found = [judged(tmp_path, seed, [ROBOT], 8.0) for seed in range(9001, 9005)]
    off = np.abs(np.concatenate([np.r_[each.off, each.rest] for each in found]))
    assert off.max() < SIGMAS
    assert np.mean(off < 1.96) > 0.85
    assert [each.missed for each in found] == [[]] * len(found)


@pytest.mark.slow
def test_intervals_hold_what_was_injected(tmp_path):
    """Bounds are around what 240 logs of other seeds gave: 89 and 93 %, and 0.17 certain faults that are not there."""
    robots = [ROBOT, ROBOTS / "meshed_arm.urdf", path_of("kinova"), path_of("z1")]
    found = [judged(tmp_path, seed, robots, 20.0) for seed in range(9100, 9130)]
    injected, rest = (np.abs(np.concatenate(each)) for each in ([f.off for f in found], [f.rest for f in found]))
    assert 0.87 <= np.mean(injected < 1.96) <= 0.99
    assert 0.91 <= np.mean(rest < 1.96) <= 0.97
    assert sum(len(each.false) for each in found) <= 0.25 * len(found)
    assert [each.missed for each in found] == [[]] * len(found)


def log_of(seed: int, file: Path) -> tuple[str, ...]:
    """A log of an arm whose links have other inertias than the description has, and friction that it has not."""
    rng = np.random.default_rng(seed)

    def other(found: re.Match[str]) -> str:
        return f'{found[1]}="{float(found[2]) * rng.uniform(0.4, 1.0):.9g}"'

    text = re.sub(r'\b(ixx|iyy|izz)="([^"]+)"', other, ROBOT.read_text())
    (file.parent / "true.urdf").write_text(text)
    true = load(str(file.parent / "true.urdf"))
    time = np.arange(0.0, 6.0, 0.004)
    states = waves(rng, time, true.n)
    tau = inverse_dynamics(true, *states, scene=Scene(friction={true.rates[0]: Friction(2.0, 1.0, -1.0)}))
    tau += 0.002 * np.abs(tau).max(axis=0) * rng.standard_normal(tau.shape)
    write_log(file, true, time, states[0], tau, *states[1:])
    return ("torques", str(ROBOT), str(file), "--measured")


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_what_is_told_is_possible_and_counts(seed: int, tmp_path: Path) -> None:
    call = log_of(seed, tmp_path / "log.csv")
    found = json.loads(run(*call, "--format", "json").out)
    for fault in found["diagnosis"]:
        if fault["kind"] in ("viscous", "coulomb", "rotor"):
            assert all(each["value"] >= 0.0 for each in fault["parameters"])
    said = run(*call).out.partition("What explains the difference\n")[2].partition("\n\n")[0].splitlines()
    lines = [line for line in said if re.match(r"\d+\. ", line)]
    told = [fault for fault in found["diagnosis"] if max(fault["explains"].values()) >= 0.02]
    assert len(lines) == len(told) > 0
    assert not any("inertia of -" in line or "friction of -" in line for line in said)


def test_less_friction_than_a_scene_says_is_possible(tmp_path: Path) -> None:
    call = log_of(0, tmp_path / "log.csv")
    (tmp_path / "much.toml").write_text("[friction]\nwaist = { viscous = 6, coulomb = 1 }\n")
    found = json.loads(run(*call, "--scene", str(tmp_path / "much.toml"), "--format", "json").out)
    values = [
        x["parameters"][0]["value"] for x in found["diagnosis"] if (x["kind"], x["joint"]) == ("viscous", "waist")
    ]
    assert values == [pytest.approx(-4.0, abs=1.0)]  # other inertias stand in its way


def test_a_joint_at_rest_has_no_friction(tmp_path):
    """Speeds of smoothed positions are rounding there, whose sign depends on the processor."""
    model, rng = load(str(ROBOT)), np.random.default_rng(0)
    time = np.arange(0.0, 16.0, 0.004)
    moving = (time < 10.0)[:, None]
    q = 0.3 * np.sin(np.where(moving, time[:, None], 10.0) * (2.0, 3.0, 5.0))
    q += 1e-5 * moving * rng.normal(size=q.shape)
    tau = q + 0.01 * rng.normal(size=q.shape)
    write_log(tmp_path / "log.csv", model, time, q, tau)
    log = read_log(str(tmp_path / "log.csv"), model)
    evidence, at, *_ = evidence_of(log)
    assert log.noisy
    assert not evidence.own[at > 13.0, :, 1].any()
    assert (np.abs(evidence.own[at < 9.0, :, 1]) > 0.5).mean() > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["white", "band"])
def test_intervals_hold_the_truth(bench, kind):
    """Of 95 % intervals of all parameters, with a payload and a gain, 93 to 97 % hold the truth."""
    faults = [("payload", None, 0.0), ("coulomb", 1, bench.size("coulomb", 1)), ("gain", 2, 0.2)]
    truth, tau = bench.truth(faults), bench.injected(faults)
    rng, inside = np.random.default_rng(8), []
    for _ in range(12):
        found = explain(bench.evidence(tau + bench.noise(rng, kind)))
        told = sorted(found.told)
        errors = np.sqrt(np.diag(found.covariance))[told]
        inside.append(np.abs(found.theta - truth)[told] <= 1.96 * errors)
    assert 0.93 <= np.mean(np.concatenate(inside)) <= 0.97
