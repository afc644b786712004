"""`robodyn torques --report`: one file that says all, for people."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run, write_arm
from helpers.html_pages import checked

PUMA = (str(ROBOTS / "puma560.urdf"), str(ROBOTS / "puma560_sweep.csv"))


def page_of(file: Path):
    return checked(file.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def puma(tmp_path_factory: pytest.TempPathFactory):
    file = tmp_path_factory.mktemp("report") / "puma.html"
    outcome = run("torques", *PUMA, "--report", str(file))
    assert outcome.status == 0
    assert f"written: {file}" in outcome.out
    return page_of(file)


def test_summary_comes_first(puma) -> None:
    body = next(each for each in puma.elements if each.tag == "main").text.split()
    assert " ".join(body[:4]) == "No limit is exceeded"


def test_figures(puma) -> None:
    captions = [each.text for each in puma.all("figcaption")]
    assert captions[0] == "puma560 at the peak of shoulder, 1.94 s"
    assert captions[1] == "What acts on upper_arm, which shoulder carries"
    assert captions[2:8] == ["waist", "shoulder", "elbow", "wrist_roll", "wrist_pitch", "flange_roll"]
    assert captions[8:] == [
        "What makes the peaks",
        "Base forces: ground on robot",
        "Base moments: ground on robot",
        "Energy check: work less losses, and energy stored",
    ]
    labels = [str(each.attributes["aria-label"]) for each in puma.elements if each.attributes.get("role") == "img"]
    assert any("Peak torque 53.24 N m at 1.94 s" in label for label in labels)
    assert len(puma.all("image")) == 1  # the robot's shapes


def test_command_and_versions_at_the_foot(puma) -> None:
    (footer,) = puma.all("footer")
    assert f"robodyn torques {PUMA[0]} {PUMA[1]} --report" in footer.text
    assert "matplotlib 3." in footer.text


def test_data_are_those_of_json(puma) -> None:
    import base64

    links = {
        each.attributes["download"]: each.attributes["href"] for each in puma.all("a") if "download" in each.attributes
    }
    assert list(links) == ["result.json", "joints.csv", "curves.csv"]
    data = json.loads(base64.b64decode(links["result.json"].partition("base64,")[2]))
    assert data == json.loads(run("torques", *PUMA, "--format", "json").out)


def test_limits_in_plain_words(tmp_path: Path) -> None:
    write_arm(tmp_path)
    urdf = (
        (tmp_path / "arm.urdf")
        .read_text()
        .replace('effort="50" velocity="5" lower="-3"', 'effort="7" velocity="0.05" lower="0.01"', 1)
    )
    (tmp_path / "arm.urdf").write_text(urdf)
    file = tmp_path / "r.html"
    assert run("torques", str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv"), "--report", str(file)).status == 0
    text = " ".join(page_of(file).all("main")[0].text.split())
    assert text.startswith(
        "1 of 2 joints exceeds its limits shoulder moves at 0.1000 rad/s, 200 % of its limit of 0.05"
    )
    assert "rad/s; it is beyond the limit for 0.09 s. shoulder needs a torque of 8.833 N m at 0.09 s, 126 % of" in text
    assert "shoulder goes to 0 rad, below its lower limit of 0.01 rad." in text
    assert "as a skeleton" in text


def test_hostile_names(tmp_path: Path) -> None:
    write_arm(tmp_path)
    bad = "&lt;script&gt;alert(1)&lt;/script&gt; $\\frac{ | --&gt;"
    urdf = (tmp_path / "arm.urdf").read_text().replace('name="arm"', f'name="{bad}"').replace('"upper"', f'"{bad}"')
    (tmp_path / "arm.urdf").write_text(urdf.replace('"shoulder"', f'"{bad}"'))
    motion = (tmp_path / "arm.csv").read_text()
    (tmp_path / "arm.csv").write_text(motion.replace("shoulder", "<script>alert(1)</script> $\\frac{ | -->"))
    for suffix in ("html", "md"):
        file = tmp_path / f"r.{suffix}"
        outcome = run("torques", str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv"), "--report", str(file))
        assert outcome.status == 0, outcome.err
    page = page_of(tmp_path / "r.html")
    assert page.all("h1")[0].text.startswith("<script>")
    assert "\\<script\\>alert(1)" in (tmp_path / "r.md").read_text()


def test_markdown(tmp_path: Path) -> None:
    file = tmp_path / "r.md"
    assert run("torques", *PUMA, "--report", str(file)).status == 0
    text = file.read_text(encoding="utf-8")
    assert text.startswith("# puma560\n\nTorques along a motion: 6 joints, 401 samples, 4 s")
    assert "**✅ No limit is exceeded**" in text
    assert "| shoulder | 53.24 N m |" in text
    assert "svg" not in text


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("r.pdf", "unknown type of report by this suffix (name it .html or .md)"),
        ("nowhere/r.html", "cannot be written: there is no such folder"),
    ],
)
def test_wrong_names_are_refused_at_once(tmp_path: Path, name: str, line: str) -> None:
    outcome = run("torques", *PUMA, "--report", str(tmp_path / name))
    assert (outcome.status, outcome.out) == (2, "")
    assert line in outcome.err
    assert os.listdir(tmp_path) == []


def test_a_failed_job_leaves_the_old_report(tmp_path: Path) -> None:
    write_arm(tmp_path)
    (tmp_path / "arm.csv").write_text("time,q_shoulder\n0,1\n")
    (tmp_path / "r.html").write_text("old")
    assert (
        run(
            "torques", str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv"), "--report", str(tmp_path / "r.html")
        ).status
        == 2
    )
    assert (tmp_path / "r.html").read_text() == "old"


@pytest.mark.parametrize("name", ["satellite", "scara", "puma"])
def test_other_robots(tmp_path: Path, name: str) -> None:
    motions = {"satellite": "satellite_slew.csv", "scara": "scara_pick_and_place.csv", "puma": "puma_polish.csv"}
    scenes = {"satellite": "satellite.toml", "puma": "puma_polish.toml"}
    scene = ("--scene", str(ROBOTS / scenes[name])) if name in scenes else ()
    file = tmp_path / "r.html"
    assert (
        run("torques", str(ROBOTS / f"{name}.urdf"), str(ROBOTS / motions[name]), *scene, "--report", str(file)).status
        == 0
    )
    page_of(file)


def test_motors(tmp_path: Path) -> None:
    file = tmp_path / "r.html"
    scene = str(ROBOTS / "puma560_sizing.toml")
    assert run("torques", *PUMA, "--scene", scene, "--momentum", "--report", str(file)).status == 0
    page = page_of(file)
    text = " ".join(page.all("main")[0].text.split())
    assert text.startswith(
        "3 of 6 joints ask more than motors, gears or limits bear wrist_pitch: the motor's torque is"
    )
    captions = [each.text for each in page.all("figcaption")]
    assert [name for name in captions if name.startswith("Motor of")] == [
        f"Motor of {joint}" for joint in captions[2:8]
    ]
    assert "Momentum and energy" in text


def test_a_robot_on_its_feet(tmp_path: Path) -> None:
    file = tmp_path / "trot.html"
    call = [str(ROBOTS / name) for name in ("quadruped.urdf", "quadruped_trot.csv")]
    assert run("torques", *call, "--scene", str(ROBOTS / "quadruped_trot.toml"), "--report", str(file)).status == 0
    page = page_of(file)
    captions = [each.text for each in page.all("figcaption")]
    assert "What acts on rf_shank, which rf_knee carries" in captions
    for foot in ("lf", "rf", "lh", "rh"):
        assert f"{foot}: force along the normal; shaded where it is on" in captions
    labels = [str(each.attributes["aria-label"]) for each in page.elements if each.attributes.get("role") == "img"]
    assert "Contact lf: force along the normal against time, up to 61.05 N, on 63 % of it" in labels
    assert "contact forces on rf_foot" in page.all("main")[0].text
