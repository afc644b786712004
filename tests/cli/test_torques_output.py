"""What `robodyn torques` prints and writes: JSON, tables, limits and the exit status that tells of them, momentum."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from helpers.command_line import ARM, ROBOTS, Outcome, document, motion, run, shown, write_arm
from helpers.oracles import EPS, worst
from helpers.sampled import sampled

import robodyn
from robodyn.loads.accumulate import NAMES
from robodyn.loads.torques import torques
from robodyn.robot.load import load
from robodyn.scene.read import load_scene

CASES = [
    ("puma560", "puma560_sweep", "puma560_motors"),
    ("puma", "puma_encoder", None),
    ("satellite", "satellite_slew", "satellite"),
]
BOUNDS = {"effort": "50", "velocity": "5", "lower": "-3", "upper": "3"}
PICK = (str(ROBOTS / "gripper.urdf"), str(ROBOTS / "gripper_pick.csv"), "--scene", str(ROBOTS / "gripper.toml"))
PARTS = ("fx", "fy", "fz", "mx", "my", "mz")
Table = dict[str, "np.ndarray[tuple[int], np.dtype[np.float64]]"]
SCARA = (str(ROBOTS / "scara.urdf"), str(ROBOTS / "scara_pick_and_place.csv"))


def files(robot: str, table: str, scene: str | None) -> list[str]:
    more = ["--scene", str(ROBOTS / f"{scene}.toml")] if scene else []
    return [str(ROBOTS / f"{robot}.urdf"), str(ROBOTS / f"{table}.csv"), *more]


@pytest.mark.parametrize(("robot", "table", "scene"), sampled([pytest.param(*each, id=each[1]) for each in CASES]))
def test_numbers_are_those_of_the_library_to_the_last_bit(robot: str, table: str, scene: str | None) -> None:
    found = document("torques", *files(robot, table, scene))
    around = load_scene(ROBOTS / f"{scene}.toml") if scene else None
    model = load(ROBOTS / f"{robot}.urdf", moving_base=bool(around and around.moving_base))
    path = ROBOTS / f"{table}.csv"
    result = torques(model, path, around) if around else torques(model, path)
    assert found["duration"] == result.duration
    for joint, expected in zip(found["joints"], result.joints, strict=True):
        for key, value in joint.items():
            assert value == getattr(expected, key), key
    for part in result.base_wrench:
        assert found["base_wrench"][part.name] == {"peak": part.peak, "peak_time": part.peak_time, "rms": part.rms}
    assert found["checks"]["energy_balance"]["residual"] == result.checks.energy_balance.residual
    assert found["warnings"] == list(result.warnings)


def test_absent_limits_are_null(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(re.sub("<limit[^>]*>", "", ARM).replace("revolute", "continuous"))
    (tmp_path / "arm.csv").write_text(motion(5))
    for joint in document("torques", str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv"))["joints"]:
        limits = ("effort_limit", "effort_margin", "velocity_limit", "velocity_margin", "lower", "upper")
        assert [joint[key] for key in limits] == [None] * 6


def test_exceeded_limits_are_data(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(
        ARM.replace('upper="3"', 'upper="0.01"').replace('velocity="5"', 'velocity="0.15"')
    )
    (tmp_path / "arm.csv").write_text(motion(10))
    during, never = {"time": 0.0, "seconds": 0.09}, {"time": None, "seconds": None}
    assert document("torques", str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv"))["limits_exceeded"] == [
        {"joint": "elbow", "quantity": "velocity", "value": 0.2, "limit": 0.15, "unit": "rad/s", **during},
        {"joint": "elbow", "quantity": "position", "value": 0.2 * 9 / 100, "limit": 0.01, "unit": "rad", **never},
    ]


def outcome_with(folder: Path, *options: str, **limits: str) -> Outcome:
    """Of the arm whose limits are these."""
    text = ARM
    for name, value in limits.items():
        text = text.replace(f'{name}="{BOUNDS[name]}"', f'{name}="{value}"')
    (folder / "arm.urdf").write_text(text)
    (folder / "arm.csv").write_text(motion(10))
    return run("torques", str(folder / "arm.urdf"), str(folder / "arm.csv"), *options)


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        ({"effort": "3"}, "effort"),
        ({"velocity": "0.15"}, "velocity"),
        ({"upper": "0.01"}, "position"),
        ({"lower": "0.001"}, "position"),
    ],
)
def test_beyond_a_limit(limits: dict[str, str], said: str, tmp_path: Path) -> None:
    outcome = outcome_with(tmp_path, "--fail-on-limits", "--out", str(tmp_path / "tau.csv"), **limits)
    assert (outcome.status, outcome.err) == (1, "")
    assert said in outcome.out.partition("LIMITS EXCEEDED")[2]
    assert (tmp_path / "tau.csv").exists()


def test_limits_do_not_fail_unless_asked_and_at_a_limit_is_within_it(tmp_path: Path) -> None:
    outcome = outcome_with(tmp_path, effort="3")
    assert outcome.status == 0
    assert "\nLIMITS EXCEEDED by 1 of 2 joints\n" in outcome.out
    within = outcome_with(tmp_path, "--fail-on-limits", velocity="0.2")
    assert within.status == 0
    assert "\nNo limit is exceeded.\n" in within.out
    found = document("torques", str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv"))["joints"][0]
    assert found["velocity_margin"] == found["velocity_limit"] - abs(found["max_speed"])
    assert math.fsum(found["shares"].values()) == pytest.approx(found["peak"], rel=0, abs=1e-12 * 100)


@pytest.fixture
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)


def written(file: str, *call: str) -> Table:
    shown("torques", *call, "--out", file)
    if file.endswith(".npz"):
        with np.load(file) as arrays:
            return {name: arrays[name] for name in arrays}
    if file.endswith(".parquet"):
        frame = pl.read_parquet(file)
        return {name: frame[name].to_numpy() for name in frame.columns}
    header, *lines = Path(file).read_text().splitlines()
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines])
    return dict(zip(header.split(","), rows.T, strict=True))


@pytest.mark.usefixtures("_folder")
def test_columns_with_reactions() -> None:
    names = ["time", "tau_lift", "tau_wrist", "tau_jaw", *(f"base_{part}" for part in PARTS)]
    for joint in ("lift", "wrist", "jaw", "right_jaw", "pinion"):
        names += [f"{part}_{joint}" for part in PARTS]
    found = list(written("tau.csv", *PICK, "--reactions"))
    assert found[:10] == names[:10]
    assert sorted(found) == sorted(names)
    assert all(found[k : k + 6] == [f"{part}_{found[k][3:]}" for part in PARTS] for k in range(10, len(found), 6))


@pytest.mark.usefixtures("_folder")
def test_every_format_has_the_same_bits() -> None:
    expected, *others = (written(f"tau.{suffix}", *PICK, "--reactions") for suffix in ("csv", "parquet", "npz"))
    for found in others:
        assert list(found) == list(expected)
        for name, values in expected.items():
            np.testing.assert_array_equal(found[name], values, strict=True)


@pytest.mark.usefixtures("_folder")
def test_a_result_can_be_read_again_as_extra_columns() -> None:
    written("tau.csv", "arm.urdf", "arm.csv")
    torques = Path("tau.csv").read_text().splitlines()
    motion = Path("arm.csv").read_text().splitlines()
    joined = "\n".join(f"{left},{right.partition(',')[2]}" for left, right in zip(motion, torques, strict=True))
    Path("both.csv").write_text(joined + "\n")
    assert "columns not used: 'tau_" in run("torques", "arm.urdf", "both.csv").out
    Path("tau.csv").rename("first.csv")
    for options in ((), ("--ignore-extra",)):
        written("tau.csv", "arm.urdf", "both.csv", *options)
        assert Path("tau.csv").read_bytes() == Path("first.csv").read_bytes()


def test_columns_of_the_file(tmp_path: Path) -> None:
    out = tmp_path / "tau.csv"
    assert run("torques", *SCARA, "--momentum", "--about", "com", "--frame", "spindle", "--out", str(out)).status == 0
    names = out.read_text().partition("\n")[0].split(",")
    assert names == ["time", "tau_shoulder", "tau_elbow", "tau_quill", *NAMES]
    table = np.loadtxt(out, delimiter=",", skiprows=1)
    model = robodyn.load(SCARA[0])
    with robodyn.read_motion(SCARA[1], model) as reader:
        (block,) = reader.blocks()
    found = robodyn.momenta(model, block.q, block.qd, about="com", frame="spindle")
    columns = (found.com, found.linear, found.angular, found.kinetic[:, None], found.potential[:, None])
    assert worst(table[:, 4:-1], np.hstack(columns)) <= 4 * EPS
    assert worst(table[:, -1], np.einsum("ij,ij->i", table[:, 1:4], block.qd)) <= 4 * EPS
