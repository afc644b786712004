"""Logs that tell nothing, too little, or what is wrong: one line each, and no file is written."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run
from helpers.identified_logs import waves, write_log

import robodyn
from robodyn.scene.scene import Friction, Scene

ROBOT = ROBOTS / "two_link_spatial.urdf"
MODEL = robodyn.load(ROBOT)
JOINTS = MODEL.rates
TIME = 0.01 * np.arange(1000)


@cache
def states():
    return waves(np.random.default_rng(5), TIME, MODEL.n)


def torques(q, qd, qdd):
    scene = Scene(friction={name: Friction(0.5, 0.8, -0.6) for name in JOINTS})
    tau = robodyn.inverse_dynamics(MODEL, q, qd, qdd, scene=scene)
    return tau + 0.01 * np.sqrt((tau**2).mean(axis=0)) * np.random.default_rng(1).standard_normal(tau.shape)


def write(path="log.csv", rows=slice(None), change=None, time=TIME):
    """Write a log of the motion at these times; `change` changes the torques in place."""
    q, qd, qdd = waves(np.random.default_rng(5), time, MODEL.n)
    tau = torques(q, qd, qdd)
    if change is not None:
        change(tau)
    write_log(path, MODEL, time[rows], q[rows], tau[rows], qd[rows], qdd[rows])
    return path


def identified(folder, *args):
    """Run the command with all outputs; return the outcome and the files that it writes."""
    outputs = ("--out", "o.urdf", "--scene-out", "o.toml", "--covariance", "o.json")
    done = run("identify", str(ROBOT), *args, *(outputs if "--out" not in args else ()))
    return done, sorted(path.name for path in folder.glob("o.*"))


def swap(tau):
    tau[:] = tau[:, ::-1].copy()


def reverse(tau):
    tau[:, 1] *= -1.0


def misread(order=(0, 1), sign=(1.0, 1.0), noise=0.0, time=TIME):
    """Write a log whose columns of positions are of other joints or have other signs, with noise of torques as a part
    of their size."""

    def make(_):
        motion = waves(np.random.default_rng(5), time, MODEL.n)
        tau = torques(*motion)
        tau += noise * np.sqrt((tau**2).mean(axis=0)) * np.random.default_rng(10).standard_normal(tau.shape)
        q, qd, qdd = (each[:, order] * sign for each in motion)
        write_log("log.csv", MODEL, time, q, tau, qd, qdd)
        return ["log.csv"]

    return make


def rest(_):
    q = np.tile(states()[0][:1], (len(TIME), 1))
    still = np.zeros_like(q)
    write_log("log.csv", MODEL, TIME, q, torques(q, still, still), still, still)
    return ["log.csv"]


def no_torque(_):
    q = states()[0]
    text = ",".join(["time", *(f"q_{name}" for name in JOINTS)])
    np.savetxt("log.csv", np.column_stack([TIME, q]), delimiter=",", header=text, comments="")
    return ["log.csv"]


def missing(cell):
    def spoil(tau):
        tau[500, 1] = cell

    return lambda _: [write(change=spoil)]


def of_different_joints(_):
    for name, left_out in zip(("one.csv", "two.csv"), JOINTS, strict=True):
        rows = Path(write()).read_text().splitlines()
        keep = [k for k, column in enumerate(rows[0].split(",")) if column != f"tau_{left_out}"]
        Path(name).write_text("\n".join(",".join(row.split(",")[k] for k in keep) for row in rows))
    return ["one.csv", "two.csv"]


def cut_short(_):
    import pyarrow
    import pyarrow.parquet

    table = np.genfromtxt(write(), delimiter=",", names=True)
    pyarrow.parquet.write_table(pyarrow.table({name: table[name] for name in table.dtype.names}), "whole.parquet")
    whole = Path("whole.parquet").read_bytes()
    Path("log.parquet").write_bytes(whole[: len(whole) // 2])
    return ["log.parquet"]


def of_another_robot(_):
    write_log("other.csv", robodyn.load(ROBOTS / "scara.urdf"), TIME, *[np.zeros((len(TIME), 3))] * 2)
    return [write(), "--validate", "other.csv"]


HARD = {
    "at rest": (rest, "no joint moves"),
    "no torques": (no_torque, "gives no torque of a joint"),
    "torques that never change": (
        lambda _: [write(change=lambda tau: tau.fill(3.0))],
        "no measured torque ever changes",
    ),
    "a cell that is no number": (missing(np.nan), "is not finite"),
    "few rows": (lambda _: [write(rows=slice(50))], "has 50 rows"),
    "few rows after the filter": (lambda _: [write(rows=slice(80))], "leaves nothing of what is held out"),
    "a cutoff that leaves nothing": (lambda _: [write(), "--cutoff", "0.01"], "leaves 0 rows"),
    "a cutoff above all": (lambda _: [write(), "--cutoff", "60"], "above half the sampling rate"),
    "different joints": (of_different_joints, "no measured joint in common"),
    "the same log twice": (lambda _: [write(), "log.csv"], "the same content"),
    "validation of another robot": (of_another_robot, "unknown columns"),
    "validation by the same log": (lambda _: [write(), "--validate", "log.csv"], "the same content"),
    "short validation": (lambda _: [write(), "--validate", write("b.csv", slice(100, 180))], "nothing of what is held"),
    "a torque in another unit": (
        lambda _: [write(change=thousandth)],
        f"({JOINTS[0]}) times what the description makes beside friction",
    ),
    "cut short": (cut_short, "cut short"),
    "no such folder": (lambda _: [write(), "--out", "o.urdf", "--scene-out", "no/o.toml"], "no such folder"),
    "one name twice": (lambda _: [write(), "--out", "o.urdf", "--scene-out", "o.urdf"], "two outputs have this name"),
    "channels exchanged": (lambda _: [write(change=swap)], f"torques of {JOINTS[0]} and {JOINTS[1]} are exchanged"),
    "positions exchanged": (misread((1, 0)), f"positions of {JOINTS[0]} and {JOINTS[1]} are exchanged"),
    "positions exchanged, under noise": (
        misread((1, 0), noise=0.6, time=0.01 * np.arange(2000)),
        f"positions of {JOINTS[0]} and {JOINTS[1]} are exchanged",
    ),
    "a position reversed": (misread(sign=(1.0, -1.0)), f"position of {JOINTS[1]} has the wrong sign"),
    "a channel reversed": (lambda _: [write(change=reverse)], f"torque of {JOINTS[1]} has the wrong sign"),
}
SLOW = (
    "channels exchanged",
    "a position reversed",
    "positions exchanged",
    "positions exchanged, under noise",
    "a torque in another unit",
)


@pytest.mark.parametrize("case", [pytest.param(case, marks=[pytest.mark.slow] * (case in SLOW)) for case in HARD])
def test_refused_in_one_line(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    make, words = HARD[case]
    done, files = identified(tmp_path, *make(None))
    assert (done.status, files) == (2, []), done.out
    assert words in done.err
    assert done.err.startswith("error: ")
    assert done.err.strip().count("\n") == 0
    assert "internal error" not in done.err


def test_reversed_torques_can_be_forced(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done, files = identified(tmp_path, write(change=reverse), "--force")
    assert (done.status, files) == (0, ["o.json", "o.toml", "o.urdf"]), done.err
    assert "has the wrong sign" in done.out


def thousandth(tau):
    tau[:, 0] *= 1e-3


def constant(tau):
    tau[:, 0] = 1.25


def spiked(tau):
    rng = np.random.default_rng(4)
    wrong = rng.random(tau.shape) < 0.01
    tau[wrong] += (10.0 * np.abs(tau).max(axis=0) * rng.choice([-1.0, 1.0], tau.shape))[wrong]


GAP = np.r_[0:450, 550:1000]
SHAKEN = TIME + 0.01 * np.random.default_rng(2).uniform(-0.3, 0.3, len(TIME))


@pytest.mark.parametrize(
    ("log", "options", "words", "error"),
    [
        pytest.param(
            {"change": constant},
            (),
            f"the torque of {JOINTS[0]} is 1.25 throughout: it is left out",
            0.05,
            marks=pytest.mark.slow,
        ),
        ({"change": spiked, "time": SHAKEN}, (), f"the torque of {JOINTS[1]} has spikes", 0.02),
        pytest.param({"rows": GAP}, (), "", 0.02, marks=pytest.mark.slow),
        pytest.param({}, ("--split", "1"), "", 0.02, marks=pytest.mark.slow),
    ],
)
def test_told_and_gone_on_with(log, options, words, error, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done, files = identified(tmp_path, write(**log), *options, "--format", "json")
    assert (done.status, files) == (0, ["o.json", "o.toml", "o.urdf"]), done.err
    found = json.loads(done.out)
    assert words in " ".join(found["warnings"])
    assert (found["held_out"] is None) == bool(options)
    assert (found["held_out"] or found["train"])["relative_error"] < error


def test_a_joint_whose_position_is_not_logged(tmp_path, monkeypatch):
    """Its derived speeds are rounding: no friction is made of them."""
    monkeypatch.chdir(tmp_path)
    q, qd, qdd = states()
    held = np.column_stack((q[:, 0], np.full(len(q), 0.3)))
    write_log("log.csv", MODEL, TIME, held, torques(q, qd, qdd))
    found = robodyn.identify([robodyn.read_log("log.csv", MODEL)])
    fit = found.motors[JOINTS[1]]
    assert max(abs(value) for value in (fit.viscous, fit.coulomb, fit.rotor)) < 100.0
    assert f"joint {JOINTS[1]} rests: nothing is shown of its friction" in found.warnings


@pytest.mark.slow
def test_a_weight_that_may_be_an_offset(tmp_path, monkeypatch):
    """What a vertical slide weighs is a constant torque, as an offset of its sensor is."""
    monkeypatch.chdir(tmp_path)
    model = robodyn.load(ROBOTS / "scara.urdf")
    motion = waves(np.random.default_rng(5), TIME, model.n, 0.1)
    write_log("log.csv", model, TIME, motion[0], robodyn.inverse_dynamics(model, *motion), *motion[1:])
    found = robodyn.identify([robodyn.read_log("log.csv", model)])
    assert any("constant torques of quill look much like weights" in each for each in found.warnings)
