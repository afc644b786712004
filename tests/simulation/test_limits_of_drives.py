"""What a simulated motion asks beside limits, no verdict over what was not checked, and where it begins by itself."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ARM, ROBOTS, Outcome, run
from helpers.example_robots import path_of
from helpers.small_robots import built, joint, link

import robodyn
from robodyn.dynamics.initial_state import begun_at, default_pose, initial_state
from robodyn.errors import InputError
from robodyn.report.limits import limits_verdict
from robodyn.robot.load import load
from robodyn.scene.scene import Drive, ExternalWrench, Scene
from robodyn.simulation.events import Limits

PUSHED = "[drive]\nelbow = { torque = 9.0 }\nshoulder = { torque = 2.0 }\n"
HOW = ("--duration", "0.005", "--executor", "numpy", "--gravity", "0,0,0")


def simulate(folder: Path, *more: str, scene: str = PUSHED, **limits: str) -> Outcome:
    """Of the arm whose elbow has these limits."""
    text = ARM
    for name, value in limits.items():
        old = {"effort": "50", "velocity": "5"}[name]
        text = text.replace(f'{name}="{old}"', value and f'{name}="{value}"')
    (folder / "arm.urdf").write_text(text)
    (folder / "scene.toml").write_text(scene)
    return run("simulate", str(folder / "arm.urdf"), "--scene", str(folder / "scene.toml"), *HOW, *more)


def test_a_drive_and_a_speed_beyond_their_limits(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    outcome = simulate(tmp_path, "--fail-on-limits", "--report", str(page), effort="5", velocity="0.5")
    assert (outcome.status, outcome.err) == (1, "")
    assert "LIMITS EXCEEDED by " in outcome.out
    assert "180% of 5" in outcome.out
    assert "No limit" not in outcome.out + page.read_text()
    assert "needs a torque of 9.000 N m" in page.read_text()
    assert simulate(tmp_path, effort="5", velocity="0.5").status == 0


def test_the_document_has_them(tmp_path: Path) -> None:
    found = json.loads(simulate(tmp_path, "--format", "json", effort="5").out)
    excess = next(one for one in found["limits_exceeded"] if one["joint"] == "elbow")
    assert (excess["quantity"], excess["value"], excess["limit"]) == ("effort", 9.0, 5.0)
    assert excess["seconds"] == pytest.approx(0.005, rel=1e-12)
    assert found["within_limits"] is False
    assert found["verdict"]["level"] == "bad"
    assert found["start"]["q"] == {"shoulder": 0.0, "elbow": 0.0}


def test_within_all_limits_is_said(tmp_path: Path) -> None:
    outcome = simulate(tmp_path, "--fail-on-limits")
    assert outcome.status == 0
    assert "\nNo limit is exceeded.\n" in outcome.out
    found = json.loads(simulate(tmp_path, "--format", "json").out)
    assert (found["within_limits"], found["verdict"]["level"], found["warnings"]) == (True, "good", [])


@pytest.mark.parametrize("limits", [{"effort": "0"}, {"velocity": "0"}, {"effort": "", "velocity": ""}])
def test_joints_without_limits_are_not_checked(limits: dict[str, str], tmp_path: Path) -> None:
    outcome = simulate(tmp_path, "--fail-on-limits", **limits)
    assert outcome.status == 0
    assert "No limit is exceeded.\n" not in outcome.out
    assert ": not checked (" in outcome.out
    found = json.loads(simulate(tmp_path, "--format", "json", **limits).out)
    assert found["within_limits"] is None
    assert found["verdict"]["level"] != "good"


def test_a_limit_of_position_that_ends_the_motion_fails(tmp_path: Path) -> None:
    scene = "[initial]\nq = { elbow = 2.999 }\nqd = { elbow = 1 }\n"
    outcome = simulate(tmp_path, "--fail-on-limits", scene=scene)
    assert outcome.status == 1
    assert "of 3 rad at 0.0" in outcome.out
    assert '(joint_limits = "spring" or "ignore" in a scene goes on)\n' in outcome.out
    assert simulate(tmp_path, scene=scene).status == 0


def test_ignored_positions_are_not_green(tmp_path: Path) -> None:
    scene = 'joint_limits = "ignore"\n[initial]\nq = { elbow = 2.999 }\nqd = { elbow = 1 }\n'
    outcome = simulate(tmp_path, scene=scene)
    assert "No limit is exceeded but for positions, whose limits the scene ignores.\n" in outcome.out
    assert 'warning: limits of position are ignored, as the scene says: "elbow" passes its upper limit of 3 rad' in (
        outcome.out
    )


def test_when_and_how_long_a_slide_is_too_fast() -> None:
    """v = t from rest, with a limit of 0.25 m/s."""
    text = joint("j1", "l0", "l1", "prismatic").replace('velocity="100"', 'velocity="0.25"')
    model = built(link("l0"), link("l1", 2.0), text)
    scene = Scene(gravity=(0, 0, 0), drive={"j1": Drive(torque=2.0)})
    found = robodyn.simulate(model, scene, 1.0, executor="numpy")
    (use,), (excess,) = found.joints, found.exceeded
    assert (use.max_speed, use.max_speed_time) == (pytest.approx(1.0, rel=1e-12), 1.0)
    assert use.seconds_over_velocity == pytest.approx(0.75, abs=1.1e-3)
    assert (excess.quantity, excess.unit, use.peak, use.unit) == ("velocity", "m/s", 2.0, "N")


def test_what_carries_a_robot_is_assumed_and_said() -> None:
    how = {"duration": 1e-3, "executor": "numpy", "method": "midpoint"}
    standing = robodyn.simulate(robodyn.load(path_of("solo")), Scene(), **how)
    assert limits_verdict(standing).headline.endswith("as long as the base is held (assumed)")
    assert "there is no contact at its feet" in standing.caveats[0].text
    free = robodyn.load(path_of("solo"), moving_base=True)
    falling = robodyn.simulate(free, Scene(moving_base=True), **how)
    assert limits_verdict(falling).headline.endswith("as the robot falls freely (assumed)")
    pushed = Scene(moving_base=True, wrenches=(ExternalWrench("base_link", (0.0, 0.0, 24.0)),))
    for scene in (pushed, Scene(moving_base=True, gravity=(0, 0, 0)), Scene(moving_base=True, held=True)):
        assert robodyn.simulate(free, scene, **how).caveats == ()


def test_a_body_that_is_thrown_falls_freely() -> None:
    scene = Scene(moving_base=True)
    model = built(link("l0", 1.0, (0, 0, 0.1), (0.01, 0, 0, 0.02, 0, 0.03)), moving_base=True)
    said = "the base is free, and nothing but gravity acts on it from outside: it falls freely"
    assert said in robodyn.simulate(model, scene, 1e-3, executor="numpy").notes
    weightless = replace(scene, gravity=(0.0, 0.0, 0.0))
    assert said not in robodyn.simulate(model, weightless, 1e-3, executor="numpy").notes


def test_motors_are_not_looked_at() -> None:
    scene = robodyn.load_scene(ROBOTS / "puma560_sizing.toml")
    result = robodyn.simulate(robodyn.load(ROBOTS / "puma560.urdf"), scene, 1e-3, executor="numpy")
    assert "but for motors, which are not looked at" in limits_verdict(result).headline
    assert result.within_limits is None


HEAVY = (1.0, (0.1, 0, 0), (0.01, 0, 0, 0.01, 0, 0.01))


def arm(*limits: str, more: str = ""):
    """Joints j1, j2, .. with these limits."""
    parts = [link("l0")]
    for k, limit in enumerate(limits, 1):
        text = joint(f"j{k}", f"l{k - 1}", f"l{k}", axis=(0, 1, 0), more=more if k > 1 else "")
        parts += [link(f"l{k}", *HEAVY), text.replace('lower="-9" upper="9"', limit)]
    return built(*parts)


@pytest.mark.parametrize(
    ("limits", "begin"),
    [
        ('lower="-1" upper="2"', 0.0),
        ('lower="0.5" upper="2"', 0.55),
        ('lower="-2" upper="-0.5"', -0.55),
        ('lower="0" upper="2"', 0.05),
        ('lower="-0.01" upper="0"', -0.0005),
        ('lower="1" upper="1"', 1.0),
        ('lower="2" upper="1"', 0.0),
    ],
)
def test_of_one_joint(limits: str, begin: float) -> None:
    assert default_pose(arm(limits)).tolist() == pytest.approx([begin], abs=1e-15)


@pytest.mark.parametrize(("multiplier", "begin"), [(2.0, 0.55), (-2.0, -0.55)])
def test_of_a_joint_that_another_mimics(multiplier: float, begin: float) -> None:
    mimic = f'<mimic joint="j1" multiplier="{multiplier}" offset="-1"/>'
    model = arm('lower="-5" upper="5"', 'lower="0" upper="5"', more=mimic)
    assert default_pose(model).tolist() == pytest.approx([begin], abs=1e-15)
    assert begun_within(model)


def begun_within(model) -> bool:
    Limits(model, True).check_start(initial_state(model, Scene()))
    return True


@pytest.mark.parametrize("name", ["panda", "go1", "icub_reduced", "tiago_pro"])
def test_real_robots_begin_within_their_limits(name: str) -> None:
    assert begun_within(load(path_of(name)))


def test_a_joint_without_room_is_said() -> None:
    notes = robodyn.simulate(arm('lower="-1" upper="1"', 'lower="0" upper="0"'), duration=1e-3).notes
    assert notes[-1].startswith('"j2" cannot move: limits, those of joints that mimic it among them, leave no room')


def test_what_is_chosen_is_said_everywhere(tmp_path: Path) -> None:
    page = tmp_path / "panda.md"
    call = ("simulate", str(path_of("panda")), "--duration", "1e-3", "--step", "1e-3", "--executor", "numpy")
    said = 'begun within the limits and not at 0: "panda_joint4" at -0.1198 rad, "panda_finger_joint1" at 0.002 m'
    outcome = run(*call, "--report", str(page))
    assert (outcome.status, outcome.err) == (0, "")
    assert f"note: {said}\n" in outcome.out
    assert said in page.read_text().replace("\\", "")
    assert said in json.loads(run(*call, "--format", "json").out)["notes"]


def test_what_is_given_is_not_said() -> None:
    model = arm('lower="0.5" upper="2"')
    scene = begun_at(model, Scene(initial_q={"j1": 1.0}), ())
    assert not [note for note in robodyn.simulate(model, scene, 1e-3).notes if note.startswith("begun")]
    with pytest.raises(InputError, match=r'"j1" begins at 0, beyond its limit of 0\.5'):
        robodyn.simulate(model, begun_at(model, scene, [0.0]), 1e-3)


def test_a_pose_on_the_command_line_wins_over_the_scene(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text("[initial]\nq = { shoulder = 0.3, elbow = 0.4 }\n")
    call = ("simulate", str(ROBOTS / "puma.urdf"), "--scene", str(tmp_path / "scene.toml"), "--duration", "0.01")
    outcome = run(*call, "--at", "elbow=1.25", "--gravity", "0,0,-1.62")
    assert outcome.status == 0, outcome.err
    assert "gravity (0, 0, -1.62) m/s^2" in outcome.out
    start = {line.split()[0]: float(line.split()[2]) for line in outcome.out.split("\n\n")[1].splitlines()[1:]}
    assert start == {"waist": 0.0, "shoulder": 0.3, "elbow": 1.25}
    outcome = run(*call, "--at", "1,2")
    assert outcome.err.endswith("puma.urdf: 2 values for 3 coordinates (in the order: 'waist', 'shoulder', 'elbow')\n")


@pytest.mark.parametrize("method", ["rk4", "dop853"])
def test_a_motion_that_ends_where_it_begins_has_one_row(method: str) -> None:
    """`torques` refuses a table in which a time repeats."""
    result = robodyn.simulate(arm('lower="-2" upper="0"'), Scene(initial_q={"j1": 0.0}), 1.0, method=method)
    assert result.ended == '"j1" reaches its upper limit of 0 rad at 0 s'
    assert result.time.tolist() == [0.0]
    assert np.isfinite(result.columns).all()
