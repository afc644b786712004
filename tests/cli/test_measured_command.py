"""`robodyn torques --measured`: faults in words, gross ones first, JSON by its schema, reports, bad calls."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run
from helpers.faulty_logs import Bench
from jsonschema import Draft202012Validator

ROBOT = str(ROBOTS / "puma.urdf")
SCHEMAS = Path(__file__).parents[2] / "docs" / "reference" / "schemas"


@pytest.fixture(scope="module")
def bench():
    return Bench(ROBOT, step=0.008)


def log(path, bench, tau, leave_out=(), rows=slice(None)):
    names = bench.model.rates
    columns = {"time": bench.time, **{f"q_{name}": bench.q[:, j] for j, name in enumerate(names)}}
    columns |= {f"tau_{name}": tau[:, j] for j, name in enumerate(names) if name not in leave_out}
    table = np.column_stack([*columns.values()])[rows]
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="")
    return str(path)


def measured(*args, **keywords):
    return run("torques", ROBOT, *args, "--measured", **keywords)


def found(*args):
    document = json.loads(measured(*args, "--format", "json").out)
    schema = json.loads((SCHEMAS / "torques_measured.schema.json").read_text(encoding="utf-8"))
    Draft202012Validator(schema).validate(document)
    return document


def test_friction_is_told_in_words_and_pictures(bench, tmp_path):
    tau = bench.injected([("coulomb", 1, 9.0)]) + bench.noise(np.random.default_rng(0), "white", 0.02)
    path, page = log(tmp_path / "log.csv", bench, tau), tmp_path / "page.html"
    text = measured(path, "--cutoff", "8", "--report", str(page)).out
    assert "1. Coulomb friction of 9.0" in text
    assert "N m at shoulder explains 100 % of its residual" in text
    (first, *_) = found(path, "--cutoff", "8")["diagnosis"]
    (parameter,) = first["parameters"]
    assert (first["kind"], first["joint"], first["link"]) == ("coulomb", "shoulder", None)
    assert abs(parameter["value"] - 9.0) < 4.0 * parameter["standard_error"]
    assert first["explains"]["shoulder"] > 0.9
    drawn = page.read_text(encoding="utf-8")
    assert drawn.count('<figure class="chart"') == 3 * bench.model.n
    assert re.search(r"shoulder: friction over speed, from -(9|1\d)\.\d+ to (9|1\d)\.\d+ N m", drawn)


def test_exchanged_and_reversed_torques_are_said_first(bench, tmp_path):
    tau = bench.tau + bench.noise(np.random.default_rng(0), "white", 0.02)
    tau = tau[:, [1, 0, 2]]
    tau[:, 2] *= -1.0
    path = log(tmp_path / "log.csv", bench, tau)
    page = tmp_path / "page.md"
    text = measured(path, "--cutoff", "8", "--report", str(page)).out
    assert "❌ The model differs" in page.read_text(encoding="utf-8")
    assert "1. The measured torques of waist and shoulder are exchanged: that explains " in text
    assert "2. The measured torque of elbow has the wrong sign: that explains " in text
    document = found(path, "--cutoff", "8")
    assert document["exchanged"] == [["waist", "shoulder"]]
    assert document["reversed"] == ["elbow"]
    assert document["relative_error_left"] < 0.05 < document["relative_error"]


def test_a_payload_is_weighed(tmp_path):
    robot = ROBOTS / "puma560.urdf"
    six = Bench(str(robot), step=0.008)
    tau = six.injected([("payload", None, 0.0)]) + six.noise(np.random.default_rng(0), "white", 0.02)
    text = run("torques", str(robot), log(tmp_path / "log.csv", six, tau), "--measured", "--cutoff", "8").out
    assert "1. A payload of 1.999" in text
    assert "its centre at (0.05" in text


def test_what_was_not_measured_is_said_line_by_line(bench, tmp_path):
    tau = bench.tau.copy()
    tau[:, 0] = 3.0
    outcome = measured(log(tmp_path / "log.csv", bench, tau, leave_out=["elbow"]), "--cutoff", "8")
    assert "note: the torque of waist is 3 throughout: it is left out" in outcome.out
    assert "note: elbow: its torque was not measured" in outcome.out
    assert "note: waist:" not in outcome.out
    assert "1 joint with measured torques" in outcome.out


def test_a_robot_at_rest_has_an_offset_or_a_load(bench, tmp_path):
    time = 0.01 * np.arange(1000)
    columns = {"time": time} | {f"q_{name}": 0.4 * np.ones(1000) for name in bench.model.rates}
    columns["tau_elbow"] = 2.0 + 0.1 * np.random.default_rng(0).normal(size=1000)
    path = tmp_path / "log.csv"
    np.savetxt(path, np.column_stack([*columns.values()]), delimiter=",", header=",".join(columns), comments="")
    outcome = measured(str(path), "--cutoff", "8")
    assert "No joint moves" in outcome.out
    told = found(str(path), "--cutoff", "8")
    assert not any(told["joints"][0]["effects"].values())
    assert [(each["kind"], each["certain"]) for each in told["diagnosis"]] == [("offset", False)]  # or a load


def test_logs_that_tell_nothing(bench, tmp_path):
    begun = bench.tau.copy()
    begun[:2000] = 1.0
    for tau, leave_out, rows, what in (
        (bench.tau, bench.model.rates, slice(None), "gives no torque of a joint"),
        (np.ones_like(bench.tau), (), slice(None), "no measured torque ever changes"),
        (begun, (), np.r_[:1900, 2000 : len(begun)], "no measured torque varies"),
    ):
        outcome = measured(log(tmp_path / "log.csv", bench, tau, leave_out, rows), "--cutoff", "8")
        assert (outcome.status, what in outcome.err) == (2, True)
    short = measured(log(tmp_path / "log.csv", bench, bench.tau), "--cutoff", "0.2")
    assert "too few to compare" in short.err
