"""Every command reads the same descriptions: xacro files, and meshes of packages wherever ROS has them."""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path

import pytest
from helpers.command_line import ARM, ROBOTS, Outcome, motion, refused, run
from helpers.sampled import sampled

from robodyn.robot.urdf.sources import VARIABLES

SHAPE = '<visual><geometry><mesh filename="package://arm/meshes/m.stl" scale="0.001 0.001 0.001"/></geometry></visual>'
MESHED = ARM.replace('<link name="upper">', f'<link name="upper">{SHAPE}')
XACRO = (
    MESHED.replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ')
    .replace('<link name="base"/>', '<xacro:arg name="kilo" default="3"/><link name="base"/>')
    .replace('<mass value="2"/>', '<mass value="$(arg kilo)"/>')
)
SCENE = "[initial]\nq = { shoulder = 0.3 }\n"
COMMANDS = {
    "torques": ("torques", "ROBOT", "arm.csv"),
    "simulate": ("simulate", "ROBOT", "--scene", "scene.toml", "--duration", "0.02"),
    "inertia": ("inertia", "ROBOT"),
    "compare": ("inertia", "ROBOT", "--compare"),
    "fbd": ("fbd", "ROBOT", "--at", "0.1,0.2"),
    "equations": ("equations", "ROBOT", "--at", "0.1,0.2"),
    "derive": ("derive", "ROBOT", "--at", "0.1,0.2"),
    "linearize": ("linearize", "ROBOT", "--at", "0.1,0.2"),
    "envelope": ("envelope", "ROBOT"),
    "excite": ("excite", "ROBOT", "--joints", "shoulder"),
    "info": ("info", "ROBOT"),
    "check": ("check", "ROBOT", "--statistics"),
}
WAYS = {
    "package.xml above": ("src/arm/urdf/arm.urdf", (), {}),
    "--package-path": ("alone.urdf", ("--package-path", "src"), {}),
    "ROS_PACKAGE_PATH": ("alone.urdf", (), {"ROS_PACKAGE_PATH": "src"}),
    "nowhere": ("alone.urdf", (), {}),
}


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package in src/, and a motion."""
    for variable in VARIABLES:
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.chdir(tmp_path)
    Path("src/arm/meshes").mkdir(parents=True)
    Path("src/arm/urdf").mkdir()
    Path("src/arm/package.xml").write_text("<package><name>arm</name></package>")
    shutil.copy(ROBOTS / "meshes" / "bracket.stl", "src/arm/meshes/m.stl")
    Path("src/arm/urdf/arm.urdf").write_text(MESHED)
    Path("src/arm/urdf/arm.xacro").write_text(XACRO)
    Path("alone.urdf").write_text(MESHED)
    Path("arm.csv").write_text(motion(5))
    Path("scene.toml").write_text(SCENE)


def called(name: str, robot: str, *more: str) -> Outcome:
    return run(*(robot if word == "ROBOT" else word for word in COMMANDS[name]), *more)


def found(robot: str, *more: str) -> dict[str, bool]:
    """Which commands find the mesh."""
    checked = run("check", robot, *more)
    outcome = called("compare", robot, *more, "--format", "json")
    compared = {link["link"]: link for link in json.loads(outcome.out)["links"]}
    assert outcome.status == (0 if compared["upper"]["difference"] is not None else 2), outcome.err
    info = called("info", robot, *more, "--format", "json")
    assert info.status == 0, info.err
    return {
        "info": not json.loads(info.out)["meshes"]["missing"],
        "check": "RD601" not in checked.out,
        "compare": compared["upper"]["difference"] is not None,
    }


@pytest.mark.parametrize("way", sampled(WAYS, 2))
def test_all_commands_find_the_same_meshes(way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    robot, more, variables = WAYS[way]
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert found(robot, *more) == dict.fromkeys(("info", "check", "compare"), way != "nowhere")


@pytest.mark.parametrize(
    ("kind", "why"),
    [("none", "there is no such folder"), pytest.param("file", "is a file, not a folder", marks=pytest.mark.slow)],
)
def test_a_package_path_that_is_not_there_is_an_error(kind: str, why: str) -> None:
    Path("file").touch()
    for name in COMMANDS:
        outcome = called(name, "alone.urdf", "--package-path", kind)
        refused(outcome, f"invalid value for '--package-path': '{kind}': {why} (try: robodyn ")


def test_a_description_from_standard_input_has_its_meshes_in_the_current_folder() -> None:
    Path("beside.stl").write_bytes(Path("src/arm/meshes/m.stl").read_bytes())
    text = MESHED.replace("package://arm/meshes/m.stl", "beside.stl").encode()
    outcome = run("info", "-", "--format", "json", stdin=text)
    assert json.loads(outcome.out)["meshes"]["missing"] == []


@pytest.mark.parametrize("name", sampled(COMMANDS, len(COMMANDS)))
def test_xacro_files_are_read_by_every_command(name: str) -> None:
    """What is found is that of the expanded file, with the arguments of the call."""
    Path("src/arm/urdf/heavy.urdf").write_text(MESHED.replace('<mass value="2"/>', '<mass value="7"/>'))
    plain = called(name, "src/arm/urdf/heavy.urdf")
    given = called(name, "src/arm/urdf/arm.xacro", "--xacro-arg", "kilo:=7")
    assert (plain.status, given.status) == ((1, 1) if name == "check" else (0, 0)), given.err
    assert lines(given.out.replace("arm.xacro (expanded)", "heavy.urdf")) == lines(plain.out)


def lines(text: str) -> list[str]:
    """Without places in the file, commands to type, and times."""
    kept = [re.sub(r":\d+:\d+:|\(line \d+\)| +", " ", line) for line in text.splitlines()]
    return [line for line in kept if not re.search("robodyn |xacro|µs|us per|executor", line)]


@pytest.mark.parametrize(
    ("more", "line"),
    [
        (("kilo:=7", "mass:=3"), "src/arm/urdf/arm.xacro: the file has no argument 'mass' (arguments: 'kilo')"),
        (("kil:=7",), "src/arm/urdf/arm.xacro: the file has no argument 'kil' (did you mean 'kilo'?)"),
        (("kilo=7",), "invalid value for '--xacro-arg': 'kilo=7' is not NAME:=VALUE, such as prefix:=left_"),
        ((":=7",), "invalid value for '--xacro-arg': ':=7' is not NAME:=VALUE"),
    ],
)
def test_arguments_of_xacro_that_are_wrong(more: tuple[str, ...], line: str) -> None:
    words = [word for each in more for word in ("--xacro-arg", each)]
    refused(called("torques", "src/arm/urdf/arm.xacro", *words), line)


def test_arguments_of_xacro_are_for_xacro_files() -> None:
    for name in COMMANDS:
        outcome = called(name, "alone.urdf", "--xacro-arg", "kilo:=7")
        refused(outcome, "")
        assert "xacro (xacro files end in .xacro)" in outcome.err


def test_an_argument_without_a_value_says_which_option_gives_one() -> None:
    Path("need.xacro").write_text(XACRO.replace('<xacro:arg name="kilo" default="3"/>', ""))
    outcome = called("torques", "need.xacro")
    assert outcome.status == 2
    assert "kilo" in outcome.err
    assert outcome.err.endswith("(--xacro-arg NAME:=VALUE gives it a value)\n")
    assert called("torques", "need.xacro", "--xacro-arg", "kilo:=2").status == 0


def test_without_xacrodoc_every_command_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xacrodoc", None)
    line = 'src/arm/urdf/arm.xacro: xacro files need xacrodoc (pip install "robodyn[xacro]"'
    for name in COMMANDS:
        refused(called(name, "src/arm/urdf/arm.xacro"), line)


@pytest.mark.slow
def test_a_batch_computes_with_the_expanded_file() -> None:
    Path("more.csv").write_text(motion(6))
    for robot, out in (("src/arm/urdf/arm.xacro", "a"), ("src/arm/urdf/heavy.urdf", "b")):
        Path("src/arm/urdf/heavy.urdf").write_text(MESHED.replace('<mass value="2"/>', '<mass value="3"/>'))
        outcome = run("torques", robot, "arm.csv", "more.csv", "--out", f"{out}/", "--jobs", "1")
        assert outcome.status == 0, outcome.err
    assert Path("a/more.csv").read_bytes() == Path("b/more.csv").read_bytes()
