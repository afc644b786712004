"""What a newcomer does wrong: the line says what was meant, and which option or order is right."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run, write_arm
from helpers.example_robots import path_of

from robodyn.checks.catalogue import CODES
from robodyn.errors import SceneError
from robodyn.scene.read import parse_scene
from robodyn.scene.toml_table import OF_THE_SCENE
from robodyn.support.wording import alternatives, nearest

TORQUES = ("torques", "arm.urdf", "arm.csv")
SWAPPED = "arm.csv: this is a table, and a robot description is expected here (is it swapped with arm.urdf? the order: "
ORDER = "robodyn torques URDF TRAJECTORY...)"
POINT = "invalid value for '--about': {!r} is neither com nor origin nor X,Y,Z in m, such as 0,0,0.1"
LAST_RD2 = max(code for code in CODES if code.startswith("RD2"))
RULES = "(give codes such as RD207, or their beginnings such as RD2; robodyn rule WORD finds them)"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_arm(tmp_path)
    shutil.copy(ROBOTS / "meshes" / "bracket.stl", "part.stl")
    Path("scene.toml").write_text("gravity = [0, 0, -1.6]\n")


CALLS: dict[str, str] = {
    # files of another kind
    "torques arm.csv arm.urdf": SWAPPED + ORDER,
    "accuracy arm.csv arm.urdf": SWAPPED + "robodyn accuracy MESH|URDF TRAJECTORY|URDF SCENE.toml)",
    "torques arm.urdf arm.urdf": "arm.urdf: this is a robot description, and a table is expected here (the order: ",
    "torques arm.urdf scene.toml": "scene.toml: this is a scene, and a table is expected here (the order: ",
    "torques scene.toml arm.csv": "scene.toml: this is a scene, and a robot description is expected here (the order: ",
    "torques part.stl arm.csv": "part.stl: this is a mesh, and a robot description is expected here (the order: "
    + ORDER,
    "torques arm.urdf arm.csv --scene arm.urdf": "arm.urdf: this is a robot description, and a scene is expected here "
    "(robodyn scene init URDF writes one)",
    "info arm.csv": "arm.csv: this is a table, and a robot description is expected here (the order: robodyn info URDF)",
    "simulate arm.urdf scene.toml": "got unexpected extra argument (scene.toml); did you mean --scene scene.toml? (",
    "linearize arm.urdf scene.toml": "got unexpected extra argument (scene.toml); did you mean --scene scene.toml? (",
    "linearize arm.csv": "arm.csv: this is a table, and a robot description is expected here (the order: robodyn line",
    "fbd arm.urdf arm.csv": "got unexpected extra argument (arm.csv); did you mean --traj arm.csv? (try: ",
    "info arm.urdf scene.toml": "got unexpected extra argument (scene.toml) (try: robodyn info --help)",
    "torques arm.urdf arm.csv --scene no.toml": "no.toml: cannot be read: no such file or directory (check the name)",
    # points, links, joints
    "inertia part.stl --about tool0": POINT.format("tool0") + "; --link takes the name of a link (",
    "torques arm.urdf arm.csv --momentum --about fore": POINT.format("fore") + "; --frame takes the name of a link (",
    "inertia part.stl --rpy 1,2": "invalid value for '--rpy': '1,2' is not three finite numbers between "
    "commas, such as 0,0,1.57",
    "fbd arm.urdf --at elbow=1,elbow=2": "invalid value for '--at': 'elbow=1,elbow=2' names 'elbow' twice",
    "fbd arm.urdf --at ELBOW=1": "arm.urdf: no joint 'ELBOW' to set (did you mean 'elbow'?)",
    "inertia arm.urdf --link Fore": "arm.urdf: there is no link 'Fore' (did you mean 'fore'?)",
    # options that do not go together
    "inertia arm.urdf --density 1": "--density is not for a whole robot, but for meshes or a URDF with --link NAME "
    "--geometry visual (try: ",
    "inertia part.stl --at 1": "--at is not for meshes one by one, but for a URDF (try: ",
    "inertia part.stl --place 0,0,0": "--place is not for meshes one by one, but for meshes with --combine (try: ",
    # numbers
    "inertia part.stl --mass heavy": "invalid value for '--mass': 'heavy' is no number (try: ",
    # rules
    "check arm.urdf --select RD2xx": f"there is no rule 'RD2XX' (RD2 means RD201 to {LAST_RD2})",
    "check arm.urdf --select inertia": f"there is no rule 'inertia' {RULES}",
    "check arm.urdf --ignore mesh-missing": "there is no rule 'mesh-missing' ('mesh-missing' is RD601)",
    "check arm.urdf --select R207": "there is no rule 'R207' (did you mean 'RD207'?)",
    "rule RD2xx": f"no rule has the code or the word 'RD2xx' (RD2 means RD201 to {LAST_RD2})",
    "rule zebra": f"no rule has the code or the word 'zebra' {RULES}",
}


@pytest.mark.parametrize("call", CALLS)
def test_a_wrong_call(call: str) -> None:
    outcome = run(*call.split())
    assert (outcome.status, outcome.out, len(outcome.err.splitlines())) == (2, "", 1)
    assert outcome.err.startswith(f"error: {CALLS[call]}"), outcome.err


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
    "[friction]\nelbow = { viscous = 1 }\n": "[friction]",
    "[friction.elbow]\nviscous = 1\n": "[friction] elbow",
    "[initial]\nq = { elbow = 1 }\n": "[initial]",
    "[[payload]]\nlink = 'fore'\nmass = 1\n": "[[payload]] number 1",
    "[fluid]\ndensity = 1\n": "[fluid]",
}


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("line", ["gravity = [0, 0, 0]", "slip_speed = 1", "joint_limits = 'stop'"])
def test_a_key_of_the_scene_below_a_table_says_where_it_belongs(table: str, line: str) -> None:
    parse_scene(f"{line}\n{table}".encode())
    with pytest.raises(SceneError) as error:
        parse_scene((table + line).encode())
    key = line.partition(" ")[0]
    what = f'"{key}" is a key of the whole scene, and below the header of a table it belongs to that table'
    assert error.value.what == f"{TABLES[table]}: {what}"
    assert error.value.remedy == f"write {key} = ... above the first [table]"


def test_all_keys_of_the_scene_are_known_to_be_such() -> None:
    with pytest.raises(SceneError) as error:
        parse_scene(b"none = 1")
    known = error.value.remedy.removeprefix("valid keys: ").split(", ")
    assert sorted(known) == sorted(repr(key) for key in OF_THE_SCENE)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a = 1\nb = = 2", "my.toml:2: is not TOML: invalid value"),
        (
            "[drive]\na = {}\n[drive]\n",
            "my.toml:3: is not TOML: cannot declare ('drive',) twice (each key and",
        ),
        ("a = 1\na = 2\n", "my.toml"),
        ("a = [", "my.toml: is not TOML: "),
    ],
)
def test_what_is_not_toml_has_its_line(text: str, message: str) -> None:
    with pytest.raises(SceneError) as error:
        parse_scene(text.encode(), "my.toml")
    assert str(error.value).startswith(message)


def test_rules_are_found_by_words_of_their_titles_first() -> None:
    listed = run("rule", "parallel axis").out.splitlines()
    assert [line.split()[0] for line in listed] == ["RD308", "RD307"]
    assert {line.split()[0] for line in run("rule", "RD9").out.splitlines()} == {"RD901", "RD902"}
    assert "RD207" in run("rule", "inertia").out
    both = run("rule", "RD207", "mirror")
    assert both.out.startswith("RD207 ")


@pytest.mark.parametrize("given", ["RD601", "rd601", "mesh-missing", "Mesh-Missing"])
def test_one_rule_is_explained(given: str) -> None:
    assert run("rule", given).out.startswith("RD601 mesh-missing (error: the check fails)\n")


NAMES = ("base_link", "arm_1_link", "arm_2_link", "wrist_ft_link", "wrist_ft_tool_link", "Torso")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("torso", "did you mean 'Torso'?"),
        ("ARM_1_LINK", "did you mean 'arm_1_link'?"),
        ("arm_1_lnk", "did you mean 'arm_1_link'?"),
        ("wrist", "did you mean 'wrist_ft_link' or 'wrist_ft_tool_link'?"),
        ("my_torso_joint_1", "did you mean 'Torso'?"),
        ("link", "links like it: 'base_link', 'arm_1_link', 'arm_2_link', 'wrist_ft_link', 'wrist_ft_tool_link'"),
        ("zz", "links: 'base_link', 'arm_1_link', 'arm_2_link', 'wrist_ft_link', 'wrist_ft_tool_link', 'Torso'"),
        ("", "links: 'base_link', "),
    ],
)
def test_names_that_are_near(name: str, expected: str) -> None:
    assert alternatives(name, NAMES, "links").startswith(expected)


def test_no_name_is_near_to_none() -> None:
    assert nearest("a", ()) == []
    assert alternatives("a", (), "links") == "there are no links"


def test_a_part_of_a_name_is_enough_on_a_large_robot() -> None:
    tiago = str(path_of("tiago"))
    assert "(did you mean 'wrist_ft_link' or 'wrist_ft_tool_link'?)" in run("inertia", tiago, "--link", "wrist").err
    assert "(did you mean 'torso_lift_joint'?)" in run("fbd", tiago, "--at", "torso=0.1").err
