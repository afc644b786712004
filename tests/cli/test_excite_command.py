"""`robodyn excite`: text, JSON, the motion as a file, and how it refuses."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run

PENDULUM, PLANAR = str(ROBOTS / "pendulum.urdf"), str(ROBOTS / "two_link_planar.urdf")
QUICK = ("--harmonics", "2", "--rate", "20")
EMPTY = '<robot name="r"><link name="base"/></robot>'


def test_text_and_file(tmp_path: Path) -> None:
    file = tmp_path / "motion.csv"
    outcome = run("excite", PENDULUM, *QUICK, "--period", "4", "--out", str(file))
    assert outcome.status == 0, outcome.err
    words = " ".join(outcome.out.split())
    assert "pendulum: a motion of 1 joint that shows 6 base parameters" in words
    assert "period 4 s, 2 harmonics, 81 rows at 20 /s" in words
    assert "note: 1 joint (pivot): no position limits: 3.142 rad to each side" in words
    assert f"written: {file}, 81 rows of time and 3 columns" in words
    with file.open() as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == ["time", "q_pivot", "qd_pivot", "qdd_pivot"]
    assert [float(rows[k]["time"]) for k in (0, 1, -1)] == [0.0, 0.05, 4.0]
    assert abs(float(rows[-1]["qd_pivot"])) < 1e-12
    torques = run("torques", PENDULUM, str(file), "--fail-on-limits")
    assert torques.status == 0, torques.out + torques.err


def test_json_is_what_the_file_has(tmp_path: Path) -> None:
    file = tmp_path / "motion.csv"
    call = ("excite", PLANAR, *QUICK, "--joints", "elbow", "--noise", "0.2", "--max-acceleration", "5")
    found = json.loads(run(*call, "--format", "json", "--out", str(file)).out)
    assert [joint["moves"] for joint in found["joints"]] == [False, True]
    assert [joint["noise"] for joint in found["joints"]] == [0.2, 0.2]
    assert found["joints"][1]["acceleration"] <= found["joints"][1]["acceleration_limit"] == 5
    elbow = found["joints"][1]
    with file.open() as stream:
        first = next(csv.DictReader(stream))
    assert float(first["q_elbow"]) == pytest.approx(elbow["centre"] + sum(elbow["cosine"]), abs=1e-9)
    assert "shoulder.viscous" in found["invisible"]
    assert found["rank"] == len(found["base_parameters"])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ((PENDULUM, "--harmonics", "1"), "1 harmonics: one cannot begin and end at rest"),
        ((PENDULUM, "--joints", "pivto"), "there is no joint 'pivto' to move (did you mean 'pivot'?)"),
        ((PENDULUM, "--joints", "pivot,"), "invalid value for '--joints': 'pivot,' is not names between commas"),
        ((PENDULUM, "--noise", "0"), "noise is 0 (it is positive [N m, N])"),
        ((PENDULUM, "--period", "0"), "invalid value for '--period': 0 is no positive finite number"),
        ((PENDULUM, "--seed", "-1"), "invalid value for '--seed': -1 is less than 0"),
        ((PENDULUM, "--out", "motion.xlsx"), "motion.xlsx: unknown type of table by this suffix"),
        ((PENDULUM, "--out", PENDULUM), "the output would overwrite an input"),
        ((str(ROBOTS / "four_bar.urdf"), "--scene", str(ROBOTS / "four_bar_lift.toml")), "closes loops"),
        (
            (str(ROBOTS / "satellite.urdf"), "--scene", str(ROBOTS / "satellite.toml")),
            '"base" floats: nothing drives it',
        ),
        (("-",), "no joint can move (none is described)"),
    ],
)
def test_refuses_in_one_line(call: tuple[str, ...], message: str) -> None:
    outcome = run("excite", *call, stdin=EMPTY.encode())
    assert (outcome.status, outcome.out) == (2, "")
    assert message in outcome.err
    assert outcome.err.count("\n") == 1
