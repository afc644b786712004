"""The scene of a calibrated robot: written, read back, and what the regressor says of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.possible_bodies import calibration, described
from helpers.small_robots import joint, link, urdf

import robodyn
from robodyn.identification.result import calibrated, friction_toml
from robodyn.robot.load import load
from robodyn.scene.scene import DEFAULT, Friction, Rotor, Scene


def read_back(tmp_path, text):
    path = tmp_path / "friction.toml"
    path.write_text(text, encoding="utf-8")
    return robodyn.load_scene(path)


@pytest.mark.parametrize("scene", [DEFAULT, BUSY_SCENE, replace(BUSY_SCENE, slip_speed=0.02)])
def test_it_has_the_parameters_and_reads_back(tmp_path, scene):
    model = busy_robot()
    names, _, theta = calibration(model, 1, scene=scene)
    found = calibrated(model, names, theta, scene)
    again, values = described(model, scene=found)
    of_joints = [k for k, name in enumerate(names) if name.endswith((".viscous", ".forward", ".backward", ".rotor"))]
    assert again == names
    assert np.abs(values - theta)[of_joints].max() <= 4 * np.finfo(float).eps * np.abs(theta[of_joints]).max()
    text = friction_toml(model, found, ["as found", "in a log"])
    assert text.startswith("# as found\n# in a log\n")
    written = read_back(tmp_path, text)
    assert (written.friction, written.rotor, written.slip_speed) == (found.friction, found.rotor, scene.slip_speed)
    others = ("payloads", "wrenches", "spring", "gravity", "motor")
    assert all(getattr(found, name) == getattr(scene, name) for name in others)


def test_it_replaces_what_the_description_says(tmp_path):
    """Zeros are written where the description has none; a joint that never had friction is left out."""
    ball = (1, 0, 0, 1, 0, 1)
    parts = [link(name, 1, inertia=ball) for name in ("base", "a", "b")]
    first = joint("the first", "base", "a", more='<dynamics damping="0.5"/>')
    model = load(urdf(*parts, first, joint("second", "a", "b")))
    names, theta = described(model)
    found = calibrated(model, names, np.where([name == "the first.viscous" for name in names], 0.0, theta))
    assert friction_toml(model, found) == '[friction."the first"]\nviscous = 0.0\ncoulomb = 0.0\n'
    assert read_back(tmp_path, friction_toml(model, found)).friction == {"the first": Friction()}


def test_stribeck_and_gears_stay():
    model = load(urdf(link("base"), link("a", 1, inertia=(1, 0, 0, 1, 0, 1)), joint("j", "base", "a")))
    scene = Scene(friction={"j": Friction(0.1, 1.0, -2.0, 3.0, 0.5)}, rotor={"j": Rotor(1e-4, -100.0)})
    names, theta = described(model, scene=scene)
    values = dict(zip(names, theta.tolist(), strict=True)) | {"j.stribeck": 2.5, "j.rotor": 2.0}
    found = calibrated(model, names, np.array(list(values.values())), scene)
    assert found.friction == {"j": Friction(0.1, 1.0, -2.0, 2.5, 0.5)}
    assert found.rotor["j"].inertia == pytest.approx(2e-4, rel=1e-15)
    assert friction_toml(model, found) == (
        "[friction.j]\nviscous = 0.1\ncoulomb = [1.0, -2.0]\nstribeck = 2.5\nstribeck_velocity = 0.5\n\n"
        "[rotor.j]\ninertia = 0.0002\ngear = -100.0\n"
    )
