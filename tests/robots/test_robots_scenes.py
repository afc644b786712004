"""The scenes of robots/: keys of the contract, names that exist, and every effect in at least one of them."""

from __future__ import annotations

from dataclasses import fields

from helpers.robot_files import FOLDER, read_csv

from robodyn.robot.load import load
from robodyn.scene.fit import check_scene
from robodyn.scene.read import load_scene
from robodyn.scene.scene import DEFAULT, Friction, Rotor, Spring

MOTIONS = {
    "puma560_motors": "puma560_sweep",
    "puma560_sizing": "puma560_sweep",
    "puma560_uncertain": "puma560_sweep",
    "puma_payload": "puma_reach",
    "satellite": "satellite_slew",
    "rigid_body": "rigid_body_flip",
    "gripper": "gripper_pick",
    "two_link_planar_swing_down": "two_link_planar_swing",
    "puma_servo": "puma_reach",
    "scara_servo": "scara_pick_and_place",
}
"""Tables of scenes; those of others have their names, where there are some."""
ROBOTS = sorted((path.stem for path in FOLDER.glob("*.urdf")), key=len)
SCENES = {
    path.stem: (
        [robot for robot in ROBOTS if path.stem.startswith(robot)][-1],
        MOTIONS.get(path.stem, path.stem if path.with_suffix(".csv").exists() else None),
    )
    for path in sorted(FOLDER.glob("*.toml"))
}


def test_a_scene_fits_its_robot_and_its_table_and_says_what_it_exercises():
    for name, (robot, motion) in SCENES.items():
        scene = load_scene(FOLDER / f"{name}.toml")
        check_scene(scene, load(FOLDER / f"{robot}.urdf", moving_base=scene.moving_base))
        assert {*scene.motion_columns, *scene.table_columns} <= set(read_csv(motion) if motion else ())
        assert "# Exercises:" in (FOLDER / f"{name}.toml").read_text()


def test_every_effect_appears():
    scenes = [load_scene(FOLDER / f"{name}.toml") for name in SCENES]
    for part, kind in (("friction", Friction), ("rotor", Rotor), ("spring", Spring)):
        used = [each for scene in scenes for each in getattr(scene, part).values()]
        wanted = {field.name for field in fields(kind)} - {"load", "axis", "on"}
        assert wanted == {name for name in wanted if any(getattr(each, name) not in (None, 0.0) for each in used)}
    wrenches = [wrench for scene in scenes for wrench in scene.wrenches]
    assert {wrench.frame for wrench in wrenches} >= {"link", "base"}
    assert any(wrench.columns for wrench in wrenches)
    assert any(any(wrench.point) for wrench in wrenches)
    assert any(any(load.com) and any(load.inertia) for scene in scenes for load in scene.payloads)
    assert {scene.moving_base for scene in scenes} == {False, True}
    assert any(scene.gravity != DEFAULT.gravity for scene in scenes)
