"""A scene that does not fit the robot is refused; several scenes, and --payload, make one: a key stands once."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from helpers.batch_runs import in_turn
from helpers.command_line import ROBOTS, run, shown, write_arm
from helpers.command_line import motion as arm_motion
from helpers.oracles import robot

from robodyn.cli import torques_batch
from robodyn.dynamics.inverse import bias_forces, inverse_dynamics, mass_matrix
from robodyn.errors import SceneError
from robodyn.loads.torques import torques
from robodyn.scene.fit import check_scene
from robodyn.scene.read import load_scene
from robodyn.scene.scene import ExternalWrench, Friction, Immersed, Loop, Motor, Payload, Rotor, Scene, Spring
from robodyn.scene.uncertainty import Deviation, Uncertainty
from robodyn.trajectory.read import motion

PUMA = robot("puma560")
MISFITS = {
    "friction": (Scene(friction={"waste": Friction()}), "[friction]: the robot has no joint 'waste' that moves"),
    "rotor": (Scene(rotor={"waste": Rotor(1.0)}), "[rotor]: the robot has no joint 'waste' that moves"),
    "spring": (Scene(spring={"waste": Spring(1.0)}), "[spring]: the robot has no joint 'waste' that moves"),
    "payload": (Scene(payloads=(Payload("flang", 1.0),)), "[[payload]]: the robot has no link 'flang'"),
    "wrench": (Scene(wrenches=(ExternalWrench("flang"),)), "[[wrench]]: the robot has no link 'flang'"),
    "uncertain friction": (
        Scene(uncertainty=Uncertainty(joint={"waste": Deviation(0.1)})),
        "[uncertainty.joint]: the robot has no joint 'waste' that moves",
    ),
    "fluid": (Scene(immersed=(Immersed("flang"),)), "[[fluid.link]]: the robot has no link 'flang'"),
}


@pytest.mark.parametrize("where", MISFITS)
def test_unknown_names(where):
    scene, what = MISFITS[where]
    with pytest.raises(SceneError) as caught:
        check_scene(scene, PUMA, "my.toml")
    meant = "waist" if "waste" in what else "flange"
    assert str(caught.value) == f"my.toml: {what} (did you mean '{meant}'?)"


def test_names_far_from_any_list_what_there_is():
    with pytest.raises(SceneError, match=re.escape("joints: 'waist', 'shoulder', 'elbow'")):
        check_scene(Scene(friction={"qqq": Friction()}), PUMA)
    with pytest.raises(SceneError, match="links: 'base', 'trunk'"):
        check_scene(Scene(payloads=(Payload("qqq", 1.0),)), PUMA)


def test_a_moving_base_needs_a_model_that_has_one():
    with pytest.raises(SceneError, match="the base moves in the scene and is fixed in the model"):
        check_scene(Scene(moving_base=True), PUMA)
    check_scene(Scene(moving_base=True), robot("puma560", True))


def test_the_functions_of_dynamics_ask():
    scene = MISFITS["rotor"][0]
    still = motion(PUMA, [0.0, 1.0], [[0.0] * 6] * 2, [[0.0] * 6] * 2, [[0.0] * 6] * 2)
    for call in (
        lambda: torques(PUMA, still, scene),
        lambda: inverse_dynamics(PUMA, [0.1] * 6, 0, 0, scene=scene),
        lambda: bias_forces(PUMA, [0.1] * 6, 0, scene=scene),
        lambda: mass_matrix(PUMA, [0.1] * 6, scene=scene),
    ):
        with pytest.raises(SceneError, match="no joint 'waste'"):
            call()


LOOPS = {
    "no such link": (Loop("a", "flang"), "[[loop]] 'a': the robot has no link 'flang' (did you mean 'flange'?)"),
    "no such other link": (
        Loop("a", "flange", to="groud"),
        "[[loop]] 'a': the robot has no link 'groud' (did you mean 'ground'?)",
    ),
    "the base to the ground": (
        Loop("a", "base"),
        "[[loop]] 'a': no joint moves 'base' against 'ground' (a loop connects links that move against each other)",
    ),
}


@pytest.mark.parametrize("where", LOOPS)
def test_loops_that_do_not_fit_the_robot(where):
    loop, what = LOOPS[where]
    with pytest.raises(SceneError, match=f"^my.toml: {re.escape(what)}$"):
        check_scene(Scene(loops=(loop,)), robot("puma560"), "my.toml")


def test_motors_are_of_joints_of_their_own():
    with pytest.raises(SceneError, match=re.escape("[motor]: the robot has no joint 'waste' that moves")):
        check_scene(Scene(motor={"waste": Motor()}), robot("puma560"))
    gripper = robot("gripper")
    follower = next(body.joint for body in gripper.bodies if body.joint.mimics)
    what = f"[motor]: the joint '{follower.name}' mimics another (its torque is part of that of '{follower.mimics}'"
    with pytest.raises(SceneError, match=re.escape(what)):
        check_scene(Scene(motor={follower.name: Motor()}), gripper)


CALL = ("torques", str(ROBOTS / "puma560.urdf"), str(ROBOTS / "puma560_sweep.csv"))
PARTS = {
    "gravity": "gravity = [0, 0, -9.7]",
    "waist": "[friction]\nwaist = { coulomb = 5 }",
    "viscous": "[friction.waist]\nviscous = 2",
    "elbow": "[friction]\nelbow.coulomb = 3",
    "tool": '[[payload]]\nlink = "flange"\nmass = 8',
    "arm": '[[payload]]\nlink = "forearm"\nmass = 1',
    "motor": "[motor]\nwaist = { peak = 1.0, gear = 60 }",
}


FORE = '[[payload]]\nlink = "fore"\nmass = 2.5\ncom = [0.1, 0.0, 0.05]\n'
OF_THE_ARM = {"fore": FORE, "both": f'{FORE}[[payload]]\nlink = "upper"\nmass = 1\n'}


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_arm(tmp_path)
    for name, text in (PARTS | OF_THE_ARM).items():
        Path(f"{name}.toml").write_text(f"# {name}\n{text}\n")


def test_scenes_of_parts_are_the_scene_of_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torques_batch, "worked_here", in_turn)
    whole = """gravity = [0, 0, -9.7]
[friction]
waist = { coulomb = 5, viscous = 2 }
elbow = { coulomb = 3 }
[motor]
waist = { peak = 1.0, gear = 60 }
[[payload]]
link = "flange"
mass = 8
[[payload]]
link = "forearm"
mass = 1
"""
    Path("whole.toml").write_text(whole)
    assert load_scene(*(f"{name}.toml" for name in PARTS)) == load_scene("whole.toml")
    options = [word for name in PARTS for word in ("--scene", f"{name}.toml")]
    Path("same.csv").write_bytes(Path(CALL[-1]).read_bytes())
    batch = ("torques", CALL[1], CALL[2], "same.csv", "--jobs", "1", "--format", "json", "--out")
    parts, one = (json.loads(run(*batch, *more).out) for more in (("a/", *options), ("b/", "--scene", "whole.toml")))
    assert parts["worst"] == one["worst"]


@pytest.mark.parametrize(
    ("first", "second", "place"),
    [
        ("waist = { coulomb = 5 }", "waist.coulomb = 7", (4, "friction.waist.coulomb")),
        ("waist = { coulomb = 5 }", "waist = 7", (4, "friction.waist")),
        ("waist = [{ a = 1 }, 2]", "waist = [{ a = 1 }, 2]", (4, "friction.waist")),
    ],
)
def test_a_key_twice_is_an_error_with_both_places(first: str, second: str, place: tuple[int, str]) -> None:
    Path("one.toml").write_text(f"# one\n[friction]\n{first}\n")
    Path("two.toml").write_text(f"# two\n\n[friction]\n{second}\n")
    outcome = run(*CALL, "--scene", "one.toml", "--scene", "two.toml")
    assert (outcome.status, outcome.out) == (2, "")
    said = f"two.toml:{place[0]}: {place[1]} is given in one.toml:3 too"
    assert outcome.err == f"error: {said} (leave it out of one of them)\n"


def test_an_error_names_its_own_file() -> None:
    Path("bad.toml").write_text("[friction]\nwaist = { coulomb = -5 }\n")
    Path("typo.toml").write_text("[frition]\nwaist = 1\n")
    for name in ("bad", "typo"):
        with pytest.raises(SceneError) as error:
            load_scene("elbow.toml", f"{name}.toml")
        assert error.value.file == f"{name}.toml"
    assert run(*CALL, "--scene", "elbow.toml", "--scene", "nowhere.toml").err.startswith("error: nowhere.toml: ")


def test_payloads_on_one_link_are_told_to_add_up() -> None:
    Path("second.toml").write_text('[[payload]]\nlink = "flange"\nmass = 12\n')
    said = "2 payloads on link 'flange' add up: 8 + 12 = 20 kg"
    both = run(*CALL, "--scene", "tool.toml", "--scene", "second.toml", "--format", "json").out
    assert said in json.loads(both)["warnings"]
    assert f"\nwarning: {said}\n" in run(*CALL, "--scene", "tool.toml", "--payload", "flange=12").out
    assert "add up" not in run(*CALL, "--scene", "tool.toml", "--scene", "arm.toml").out
    assert "add up" not in run(*CALL, "--payload", "flange=12").out


TORQUES = ("torques", "arm.urdf", "arm.csv")
SIMULATE = ("simulate", "arm.urdf", "--duration", "0.02")
FBD = ("fbd", "arm.urdf", "--at", "0.1,0.2")
EQUATIONS = ("equations", "arm.urdf", "--at", "0.1,0.2")
OPTION = ("--payload", "fore=2.5@0.1,0,0.05")


def test_the_option_of_a_payload_is_the_payload_of_a_scene() -> None:
    for call in (TORQUES, SIMULATE, FBD, EQUATIONS):
        text = shown(*call, *OPTION)
        assert text == run(*call, "--scene", "fore.toml").out
        assert text != run(*call).out
    Path("arm.urdf").write_text(Path("arm.urdf").read_text().replace('"fore"', '"a=b@c"'))
    assert run(*TORQUES, "--payload", "a=b@c=2.5@0.1,0,0.05").status == 0, "signs in names"


def test_the_option_is_added_to_those_of_the_scene_and_can_be_repeated() -> None:
    both = run(*TORQUES, "--scene", "both.toml").out
    assert run(*TORQUES, "--scene", "fore.toml", "--payload", "upper=1").out == both
    assert run(*TORQUES, *OPTION, "--payload", "upper=1").out == both


@pytest.mark.slow
def test_a_batch_has_the_option() -> None:
    Path("more.csv").write_text(arm_motion(6))
    assert run("torques", "arm.urdf", "arm.csv", "more.csv", "--out", "a/", "--jobs", "1", *OPTION).status == 0
    for more, out in ((OPTION, "b.csv"), ((), "c.csv")):
        assert run(*TORQUES, "--out", out, "--executor", "numpy", *more).status == 0
    tables = [Path(path).read_text() for path in ("a/arm.csv", "b.csv", "c.csv")]
    batch, alone, without = (float(text.splitlines()[-1].split(",")[1]) for text in tables)
    assert abs(batch - alone) < 1e-12
    assert abs(alone - without) > 1
