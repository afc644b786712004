"""Where a motion begins if nobody says: at zero, or within the joints' limits where zero is not."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run
from helpers.example_robots import path_of
from helpers.small_robots import built, joint, link

import robodyn
from robodyn.dynamics.initial_state import begun_at, default_pose, initial_state
from robodyn.errors import InputError
from robodyn.robot.load import load
from robodyn.scene.scene import Scene
from robodyn.simulation.events import Limits

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
