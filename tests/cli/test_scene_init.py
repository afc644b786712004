"""`robodyn scene init`: as written it changes nothing, and each of its examples is a valid scene."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.command_line import ARM, ROBOTS, run, write_arm
from helpers.example_robots import path_of

import robodyn
from robodyn.errors import SceneError
from robodyn.report.scene_toml import scene_toml
from robodyn.robot.model import Model
from robodyn.scene.fit import check_scene
from robodyn.scene.read import parse_scene

OURS = [*(path.stem for path in sorted(ROBOTS.glob("*.urdf")))]
REAL = ("panda", "anymal", "tiago")
ODD = """<robot name="an &quot;odd&quot;&#10;name"><link name="a.b"/><link name="&#233; &#9;"/><link name="tip"/>
<joint name="1.5 \\" type="continuous"><parent link="a.b"/><child link="&#233; &#9;"/></joint>
<joint name="&#x1F600;" type="prismatic"><parent link="&#233; &#9;"/><child link="tip"/>
<limit lower="0.2" upper="0.5" effort="0" velocity="0"/></joint></robot>"""


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_arm(tmp_path)


def model_of(name: str, moving_base: bool = False) -> Model:
    source = {"odd": ODD.encode(), "link": b'<robot name="r"><link name="a"/></robot>'}.get(name)
    path = ROBOTS / f"{name}.urdf" if name in OURS else None if source else path_of(name)
    return robodyn.load(source or path, moving_base=moving_base)


def examples(text: str) -> list[str]:
    return [line[1:] for line in text.splitlines() if re.match("#[^ ]", line)]


@pytest.mark.parametrize("name", [*OURS, *REAL, "odd", "link"])
def test_as_written_it_is_no_scene_at_all(name: str) -> None:
    assert parse_scene(scene_toml(model_of(name)).encode()) == robodyn.Scene()


@pytest.mark.parametrize("name", [*OURS, *REAL, "odd", "link"])
def test_each_example_is_a_valid_scene(name: str) -> None:
    models = {moving: model_of(name, moving) for moving in (False, True)}
    text = scene_toml(models[False])
    for line in examples(text):
        scene = parse_scene(text.replace(f"\n#{line}\n", f"\n{line}\n").encode())
        assert scene != robodyn.Scene() or line.startswith("initial.q") or "stiffness = 0.0" in line, line
        check_scene(scene, models[scene.moving_base])


def test_every_key_of_a_scene_has_an_example() -> None:
    with pytest.raises(SceneError) as error:
        parse_scene(b"none = 1")
    known = re.findall("'(.*?)'", str(error.value.remedy))
    given = {re.split("[. ]", line)[0] for line in examples(scene_toml(model_of("puma")))}
    assert given | {"gravity"} == set(known)


def test_every_joint_stands_in_the_table_and_has_its_lines() -> None:
    text = scene_toml(model_of("panda"))
    for k in range(1, 8):
        assert re.search(rf"^# panda_joint{k} +revolute +-\d.* rad +\d.* N m +\d.* rad/s", text, re.MULTILINE)
        for table in ("friction", "rotor", "motor", "spring", "initial.q", "initial.qd", "drive"):
            assert f"\n#{table}.panda_joint{k} = " in text
    assert "\n# panda_finger_joint2" in text
    assert "#drive.panda_finger_joint2" not in text


def test_numbers_are_those_of_the_description() -> None:
    text = scene_toml(model_of("gripper"))
    model = model_of("gripper")
    geared = [body.joint for body in model.bodies if body.joint.reduction != 1.0]
    assert geared
    for joint in geared:
        assert f"#rotor.{joint.name} = {{ inertia = {joint.rotor_inertia!r}, gear = {joint.reduction!r} }}" in text
    joints_with_friction = [body.joint for body in model.bodies if body.joint.damping or body.joint.friction]
    assert joints_with_friction
    for joint in joints_with_friction:
        assert f"#friction.{joint.name} = {{ viscous = {joint.damping!r}, coulomb = {joint.friction!r} }}" in text


@pytest.mark.parametrize("name", ["puma", "gripper", "satellite"])
def test_torques_are_the_same_to_the_bit(name: str) -> None:
    urdf = str(ROBOTS / f"{name}.urdf")
    motion = next(str(path) for path in sorted(ROBOTS.glob(f"{name}_*.csv")))
    assert run("scene", "init", urdf, "--out", "scene.toml").status == 0
    with open("scene.toml", "a") as file:
        file.write('base.motion = "moving"\n' * (name == "satellite"))
    Path("none.toml").write_text('base.motion = "moving"\n' * (name == "satellite"))
    for scene, out in (("scene.toml", "a.csv"), ("none.toml", "b.csv")):
        outcome = run("torques", urdf, motion, "--scene", scene, "--out", out)
        assert outcome.status == 0, outcome.err
    assert Path("a.csv").read_bytes() == Path("b.csv").read_bytes()


def test_examples_can_be_computed() -> None:
    """Each of an arm's, alone, by the command that it is for."""
    text = scene_toml(robodyn.load("arm.urdf"))
    for line in examples(text):
        Path("scene.toml").write_text(text.replace(f"\n#{line}\n", f"\n{line}\n"))
        if line.startswith("base") or "elbow" in line:
            continue
        for call in (("torques", "arm.urdf", "arm.csv"), ("simulate", "arm.urdf", "--duration", "0.01")):
            if not line.startswith({"torques": "loop", "simulate": "contact ="}[call[0]]):
                outcome = run(*call, "--scene", "scene.toml")
                assert outcome.status == 0, (line, outcome.err)


def test_to_standard_output_and_to_a_file() -> None:
    shown = run("scene", "init", "arm.urdf")
    assert (shown.status, shown.err) == (0, "")
    written = run("scene", "init", "-", "--out", "new.toml", stdin=ARM.encode())
    assert (written.status, written.out) == (0, "written: new.toml; --scene new.toml takes it\n")
    assert Path("new.toml").read_text() == shown.out


def test_a_scene_that_is_there_is_kept() -> None:
    Path("mine.toml").write_text("slip_speed = 0.1\n")
    outcome = run("scene", "init", "arm.urdf", "--out", "mine.toml")
    line = "error: mine.toml: there is a file of this name already (name another one with --out)\n"
    assert (outcome.status, outcome.out, outcome.err) == (2, "", line)
    assert Path("mine.toml").read_text() == "slip_speed = 0.1\n"


@pytest.mark.parametrize(
    ("call", "line"),
    [
        (("init",), "missing argument 'URDF' (try: robodyn scene init --help)"),
        (("init", "no.urdf"), "no.urdf: there is no such file"),
        (("int", "arm.urdf"), "no such command 'int'. Did you mean 'init'? (try: robodyn scene --help)"),
        (("init", "arm.urdf", "--out", "no/s.toml"), "no/s.toml: "),
    ],
)
def test_wrong_calls(call: tuple[str, ...], line: str) -> None:
    outcome = run("scene", *call)
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {line}"), outcome.err


def test_alone_it_shows_its_help() -> None:
    outcome = run("scene")
    assert (outcome.status, outcome.err) == (0, "")
    assert outcome.out.startswith("Usage: robodyn scene")
