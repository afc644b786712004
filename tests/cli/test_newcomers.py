"""What a newcomer does wrong: the line says what was meant, and which option or order is right."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run, write_arm

from robodyn.cli.torques import command
from robodyn.errors import SceneError
from robodyn.scene.read import parse_scene
from robodyn.support.wording import alternatives

TORQUES = ("torques", "arm.urdf", "arm.csv")


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_arm(tmp_path)
    shutil.copy(ROBOTS / "meshes" / "bracket.stl", "part.stl")
    Path("scene.toml").write_text("gravity = [0, 0, -1.6]\n")


SCENES: dict[str, str] = {
    "[motor]\nelbw = { gear = 9, inertia = 1 }": "[motor]: the robot has no joint 'elbw' that moves (did you mean",
    "[motor]\nupper = { gear = 9 }": "[motor]: the robot has no joint 'upper' that moves (joints: 'shoulder', 'elbow')",
    "[rotor]\nelbw = { inertia = 1 }": "[rotor]: the robot has no joint 'elbw' that moves (did you mean 'elbow'?)",
    "frcition = {}": 'the scene: unknown key "frcition" (valid keys: ',
    "gravity = 9.81": 'the scene: "gravity" is 9.81, not 3 numbers (write gravity = [x, y, z])',
    'base = "moving"': "[base] is 'moving', not a table (write [base] above lines of key = value)",
    "[friction]\nelbow = 1": "[friction] elbow is 1, not a table (write elbow = { key = value })",
    "payload = [1]": "[[payload]] number 1 is 1, not a table (write [[payload]] above lines of key = value)",
    "joint_limits = true": 'the scene: "joint_limits" is True, not a name (one of: stop, ignore, spring)',
}


@pytest.mark.parametrize("text", SCENES)
def test_a_wrong_scene(text: str) -> None:
    Path("scene.toml").write_text(text)
    outcome = run(*TORQUES, "--scene", "scene.toml")
    assert (outcome.status, outcome.out) == (2, "")
    assert re.match(r"error: scene\.toml:(\d+:)? ", outcome.err)
    assert SCENES[text] in outcome.err


TABLES = {
    "[base]\nmotion = 'fixed'\n": "[base]",
    "[friction.elbow]\nviscous = 1\n": "[friction] elbow",
    "[initial]\nq = { elbow = 1 }\n": "[initial]",
    "[[payload]]\nlink = 'fore'\nmass = 1\n": "[[payload]] number 1",
}


@pytest.mark.parametrize("table", TABLES)
def test_a_key_of_the_scene_below_a_table_says_where_it_belongs(table: str) -> None:
    parse_scene(f"slip_speed = 1\n{table}".encode())
    with pytest.raises(SceneError) as error:
        parse_scene(f"{table}slip_speed = 1".encode())
    what = '"slip_speed" is a key of the whole scene, and below the header of a table it belongs to that table'
    assert error.value.what == f"{TABLES[table]}: {what}"
    assert error.value.remedy == "write slip_speed = ... above the first [table]"


def test_rules_are_found_by_words_of_their_titles_first() -> None:
    listed = run("rule", "parallel axis").out.splitlines()
    assert [line.split()[0] for line in listed] == ["RD308", "RD307"]
    assert {line.split()[0] for line in run("rule", "RD9").out.splitlines()} == {"RD901", "RD902"}
    assert "RD207" in run("rule", "inertia").out
    both = run("rule", "RD207", "mirror")
    assert both.out.startswith("RD207 ")


NAMES = ("base_link", "arm_1_link", "arm_2_link", "wrist_ft_link", "wrist_ft_tool_link", "Torso")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("torso", "did you mean 'Torso'?"),
        ("ARM_1_LINK", "did you mean 'arm_1_link'?"),
        ("arm_1_lnk", "did you mean 'arm_1_link'?"),
        ("wrist", "did you mean 'wrist_ft_link' or 'wrist_ft_tool_link'?"),
        ("baes", "did you mean 'base_link'?"),
        ("my_torso_joint_1", "did you mean 'Torso'?"),
        ("link", "links like it: 'base_link', 'arm_1_link', 'arm_2_link', 'wrist_ft_link', 'wrist_ft_tool_link'"),
        ("zz", "links: 'base_link', 'arm_1_link', 'arm_2_link', 'wrist_ft_link', 'wrist_ft_tool_link', 'Torso'"),
        ("", "links: 'base_link', "),
    ],
)
def test_names_that_are_near(name: str, expected: str) -> None:
    assert alternatives(name, NAMES, "links").startswith(expected)


def test_help_of_torques_is_in_groups() -> None:
    text = run("torques", "--help").out
    titles = re.findall(r"^(\S.*):$", text, re.MULTILINE)
    assert titles[:2] == ["The robot and what surrounds it", "The trajectory"]
    assert len(titles) == 7
    assert titles[-1] == "Other options"
    assert text.partition("Other options:\n")[2].strip().startswith("-h, --help")
    for option in (name for each in command.params for name in each.opts if name.startswith("--")):
        assert len(re.findall(rf"^  {option}\b", text, re.MULTILINE)) == 1
