"""Options that say how a table is to be read: joints that are held, names that are mapped."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ARM, document, refused, run

GRIPPER = """
  <link name="left"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
  <link name="right"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
  <joint name="finger" type="prismatic"><parent link="fore"/><child link="left"/><axis xyz="0 1 0"/>
    <limit effort="9" velocity="1" lower="-0.05" upper="0.05"/></joint>
  <joint name="other" type="prismatic"><parent link="fore"/><child link="right"/><axis xyz="0 1 0"/>
    <limit effort="9" velocity="1" lower="-0.04" upper="-0.01"/><mimic joint="finger" multiplier="-1"/></joint>
</robot>"""
"""Two fingers, the second of which mimics the first and keeps away from zero."""
SLIPS = [
    (1e3, 1.0, "--time-unit ms", "--time-unit s"),
    (1e9, 1.0, "--time-unit ns", "--time-unit s"),
    (1.0, 180 / math.pi, "--angle-unit deg", "--angle-unit rad"),
]


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("arm.urdf").write_text(ARM.replace("</robot>", GRIPPER))
    write("arm.csv", ("time", "q_shoulder", "q_elbow"))


def write(path: str, names: tuple[str, ...], rows: int = 40) -> None:
    time = np.arange(rows) / 100
    columns = [time, *(0.2 * np.sin(3 * time + k) for k in range(len(names) - 1))]
    lines = [",".join(names), *(",".join(f"{x:.12g}" for x in row) for row in zip(*columns, strict=True))]
    Path(path).write_text("\n".join([*lines, ""]))


def test_held_joints_are_in_text_json_and_page() -> None:
    """At rest where the finger that mimics it is within its limits, too."""
    refused(run("torques", "arm.urdf", "arm.csv"), "arm.csv:1: no position of joint 'finger' (--hold rest keeps joints")
    outcome = run("torques", "arm.urdf", "arm.csv", "--hold", "rest", "--report", "page.md")
    said = "Held still, for want of columns, in m or rad: finger at 0.01."
    assert said in outcome.out
    assert said in Path("page.md").read_text()
    assert document("torques", "arm.urdf", "arm.csv", "--hold", "rest")["held"] == {"finger": 0.01}


def test_held_joints_carry_what_they_would_with_columns() -> None:
    write("full.csv", ("time", "q_shoulder", "q_elbow"))
    lines = Path("full.csv").read_text().splitlines()
    head, rest = f"{lines[0]},q_finger,qd_finger,qdd_finger", [f"{line},0.03,0,0" for line in lines[1:]]
    Path("full.csv").write_text("\n".join([head, *rest, ""]))
    whole = document("torques", "arm.urdf", "full.csv")
    held = document("torques", "arm.urdf", "arm.csv", "--hold", "finger=0.03")
    assert (held.pop("held"), whole.pop("held")) == ({"finger": 0.03}, {})
    assert held == whole


@pytest.mark.slow
def test_wherever_a_table_is_read() -> None:
    options = ("--hold", "rest", "--map", "q_elbow=e")
    write("arm.csv", ("time", "q_shoulder", "e"))
    assert run("fbd", "arm.urdf", "--traj", "arm.csv", "--time", "0.1", *options).status == 0
    assert run("torques", "arm.urdf", "arm.csv", "--accuracy", "1e-6", *options).status == 0
    outcome = run("torques", "arm.urdf", "arm.csv", *options, "--out", "results/", "--jobs", "1")
    assert outcome.status == 0
    assert json.loads(Path("results/arm.json").read_text())["held"] == {"finger": 0.01}
    again = run("torques", "arm.urdf", "arm.csv", *options, "--hold", "finger=0.02", "--out", "results/", "--jobs", "1")
    assert "finished before" not in again.out


def test_names_are_mapped_by_options_and_by_a_file() -> None:
    write("own.csv", ("clock", "my shoulder", "Elbow=1"))
    refused(
        run("torques", "arm.urdf", "own.csv"), "own.csv:1: no column of time (name it 'time', or say which it is: --map"
    )
    Path("names.toml").write_text('q_shoulder = "my shoulder"\nq_elbow = "Elbow=1"\n')
    hold = ("--hold", "rest", "--map", "time=clock")
    by_file = run("torques", "arm.urdf", "own.csv", *hold, "--map", "names.toml")
    one_by_one = run(
        "torques", "arm.urdf", "own.csv", *hold, "--map", "q_shoulder=my shoulder", "--map", "q_elbow=Elbow=1"
    )
    assert by_file.out == one_by_one.out == run("torques", "arm.urdf", "arm.csv", "--hold", "rest").out


def test_units_of_options_are_those_of_columns_that_do_not_tell() -> None:
    """The same motion in other units, with the same loads."""
    time = np.arange(40) / 100
    q = 0.2 * np.sin(3 * time)
    rows = [f"{1000 * t!r},{math.degrees(x)!r},{x!r}" for t, x in zip(time.tolist(), q.tolist(), strict=True)]
    Path("odd.csv").write_text("\n".join(["time,q_shoulder,q_elbow [rad]", *rows, ""]))
    write("arm.csv", ("time", "q_shoulder", "q_elbow"))
    units = ("--time-unit", "ms", "--angle-unit", "deg", "--hold", "rest")
    found = document("torques", "arm.urdf", "odd.csv", *units)["joints"]
    assert found[0]["max_speed"] == pytest.approx(0.6, rel=1e-6)
    assert found[1]["max_speed"] == pytest.approx(found[0]["max_speed"], rel=1e-6)


def swing(path: str, ticks: float = 1.0, parts: float = 1.0, start: float = 0.0) -> None:
    """A swing of the arm that is within all limits, with the finger still, in other units."""
    time = np.arange(200) / 100
    q = 0.3 * np.sin(3 * time) * parts
    rows = [f"{(start + t) * ticks!r},{x!r},{-x!r},0.02" for t, x in zip(time.tolist(), q.tolist(), strict=True)]
    Path(path).write_text("\n".join(["time,q_shoulder,q_elbow,q_finger", *rows, ""]))


@pytest.mark.parametrize(("ticks", "parts", "option", "meant"), SLIPS, ids=["ms", "ns", "deg"])
def test_a_slip_of_units_ends_in_one_line(ticks: float, parts: float, option: str, meant: str) -> None:
    """Nothing is computed, printed or written of numbers that can hardly be so, unless it is said that they are."""
    swing("arm.csv", ticks, parts)
    call = ("torques", "arm.urdf", "arm.csv")
    outcome = run(*call, "--out", "tau.csv", "--report", "page.md")
    refused(outcome, "arm.csv: ")
    assert f"({option}, or {meant} if they are" in outcome.err
    assert not Path("tau.csv").exists()
    assert not Path("page.md").exists()
    assert run(*call, *option.split()).status == run(*call, *meant.split()).status == 0


def test_a_slip_of_units_is_told_by_other_commands() -> None:
    swing("arm.csv", 1e3)
    head, *rows = Path("arm.csv").read_text().splitlines()
    Path("arm.csv").write_text(
        "\n".join([f"{head},tau_shoulder", *(f"{row},{k % 7}" for k, row in enumerate(rows)), ""])
    )
    said = "are the stamps milliseconds? (--time-unit ms, or --time-unit s if they are seconds)"
    check = ("check", "arm.urdf", "--trajectory", "arm.csv", "--select", "RD802")
    measured = ("torques", "arm.urdf", "arm.csv", "--measured")
    for call in (("fbd", "arm.urdf", "--traj", "arm.csv", "--time", "0"), check, measured):
        outcome = run(*call)
        refused(outcome, "")
        assert said in outcome.err
    assert said not in run(*check, "--time-unit", "ms").out


def test_epoch_stamps_are_relative_in_reports_and_as_given_in_tables() -> None:
    """The origin is told once; rows of the output can be joined to those of the input."""
    swing("arm.csv", start=1_700_000_000.0)
    outcome = run("torques", "arm.urdf", "arm.csv", "--out", "tau.csv", "--report", "page.md")
    assert outcome.out.count("1700000000") == 1
    assert "Times count from the first stamp of the table, 1700000000 s.\n" in outcome.out
    assert Path("page.md").read_text().count("1700000000") == 1
    found = document("torques", "arm.urdf", "arm.csv")
    assert found["time_origin"] == 1_700_000_000.0
    assert max(joint["peak_time"] for joint in found["joints"]) < 2.0
    given, written = (np.loadtxt(name, delimiter=",", skiprows=1)[:, 0] for name in ("arm.csv", "tau.csv"))
    np.testing.assert_array_equal(written, given)


def test_a_simulation_reads_stamps_and_names_likewise() -> None:
    """A drive that follows a table in ms since 1970, whose column has another name."""
    time = np.arange(50) / 100
    for name, stamps, column in (("plain.csv", time, "ref"), ("odd.csv", 1.7e12 + 1000 * time, "my ref")):
        rows = [f"{t!r},{x!r}" for t, x in zip(stamps.tolist(), (0.1 * np.sin(3 * time)).tolist(), strict=True)]
        Path(name).write_text("\n".join([f"time,{column}", *rows, ""]))
    Path("scene.toml").write_text(
        '[drive]\nelbow = { kp = 20, kd = 2, reference = "ref" }\n[initial]\nq = {finger = 0.02}\n'
    )
    call = ("simulate", "arm.urdf", "--scene", "scene.toml", "--duration", "0.2")
    plain = run(*call, "--traj", "plain.csv", "--out", "plain_out.csv")
    odd = run(*call, "--traj", "odd.csv", "--map", "ref=my ref", "--time-unit", "ms", "--out", "odd_out.csv")
    assert (plain.status, odd.status) == (0, 0), odd.err
    assert "its first row, 1.7e+09 s, is time 0" in odd.out
    assert Path("plain_out.csv").read_text() == Path("odd_out.csv").read_text()
