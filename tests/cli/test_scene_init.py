"""`robodyn scene init`: as written it changes nothing, and each of its examples is a valid scene."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.command_line import ARM, ROBOTS, refused, run, write_arm
from helpers.example_robots import path_of
from helpers.sampled import sampled

import robodyn
from robodyn.errors import SceneError
from robodyn.robot.model import Model
from robodyn.scene.fit import check_scene
from robodyn.scene.read import parse_scene
from robodyn.scene.template import scene_toml

OURS = [*(path.stem for path in sorted(ROBOTS.glob("*.urdf")))]
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


@pytest.mark.parametrize("name", [*sampled([*OURS, "panda", "anymal", "tiago"], 4), "odd", "link"])
def test_each_example_is_a_valid_scene(name: str) -> None:
    """And as written it is no scene at all."""
    models = {moving: model_of(name, moving) for moving in (False, True)}
    text = scene_toml(models[False])
    assert parse_scene(text.encode()) == robodyn.Scene()
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


@pytest.mark.parametrize("first", sampled(range(4)))
def test_examples_can_be_computed(first: int) -> None:
    """Each of an arm's, alone, by the command that it is for."""
    text = scene_toml(robodyn.load("arm.urdf"))
    for line in examples(text)[first::4]:
        Path("scene.toml").write_text(text.replace(f"\n#{line}\n", f"\n{line}\n"))
        if line.startswith(("base", "gear")) or "elbow" in line:  # a life needs a ratio, which an arm does not say
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
    line = "mine.toml: there is a file of this name already (name another one with --out)\n"
    refused(run("scene", "init", "arm.urdf", "--out", "mine.toml"), line)
    assert Path("mine.toml").read_text() == "slip_speed = 0.1\n"
