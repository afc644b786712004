"""What `--out` writes: columns and their order, the same numbers in every format, whole files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from helpers.command_line import ROBOTS, run, write_arm

GRIPPER = (str(ROBOTS / "gripper.urdf"), str(ROBOTS / "gripper_pick.csv"), "--scene", str(ROBOTS / "gripper.toml"))
PARTS = ("fx", "fy", "fz", "mx", "my", "mz")
Table = dict[str, "np.ndarray[tuple[int], np.dtype[np.float64]]"]


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)


def written(file: str, *call: str) -> Table:
    outcome = run("torques", *call, "--out", file)
    assert (outcome.status, outcome.err) == (0, "")
    if file.endswith(".npz"):
        with np.load(file) as arrays:
            return {name: arrays[name] for name in arrays}
    if file.endswith(".parquet"):
        frame = pl.read_parquet(file)
        return {name: frame[name].to_numpy() for name in frame.columns}
    header, *lines = Path(file).read_text().splitlines()
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines])
    return dict(zip(header.split(","), rows.T, strict=True))


def test_columns() -> None:
    assert list(written("tau.csv", "arm.urdf", "arm.csv")) == ["time", "tau_shoulder", "tau_elbow"]


def test_columns_with_reactions() -> None:
    names = ["time", "tau_lift", "tau_wrist", "tau_jaw", *(f"base_{part}" for part in PARTS)]
    for joint in ("lift", "wrist", "jaw", "right_jaw", "pinion"):
        names += [f"{part}_{joint}" for part in PARTS]
    found = list(written("tau.csv", *GRIPPER, "--reactions"))
    assert found[:10] == names[:10]
    assert sorted(found) == sorted(names)
    assert all(found[k : k + 6] == [f"{part}_{found[k][3:]}" for part in PARTS] for k in range(10, len(found), 6))


@pytest.mark.parametrize("file", ["tau.parquet", "tau.npz"])
@pytest.mark.parametrize("call", [("arm.urdf", "arm.csv"), (*GRIPPER, "--reactions")])
def test_every_format_has_the_same_bits(file: str, call: tuple[str, ...]) -> None:
    expected, found = written("tau.csv", *call), written(file, *call)
    assert list(found) == list(expected)
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values, strict=True)


def test_reactions_leave_torques_as_they_are() -> None:
    plain, more = written("tau.csv", *GRIPPER), written("more.csv", *GRIPPER, "--reactions")
    largest = max(np.abs(plain[name]).max() for name in plain if name != "time")
    for name, values in plain.items():
        assert np.abs(more[name] - values).max() <= 4 * np.finfo(float).eps * largest


def test_time_is_the_time_of_the_trajectory() -> None:
    text = [line.partition(",")[0] for line in (ROBOTS / "gripper_pick.csv").read_text().splitlines()[1:]]
    np.testing.assert_array_equal(written("tau.csv", *GRIPPER)["time"], np.array([float(cell) for cell in text]))


def test_the_report_says_where_the_table_went() -> None:
    lines = run("torques", "arm.urdf", "arm.csv", "--out", "tau.csv").out.splitlines()
    assert lines[-3:] == ["written: tau.csv, 10 rows of time and 2 columns", "", "No limit is exceeded."]
    assert "tau.csv" not in run("torques", "arm.urdf", "arm.csv", "--out", "tau.csv", "--format", "json").out


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
