"""The scenes of robots/: keys of the contract, names that exist, and every effect in at least one of them."""

from __future__ import annotations

from dataclasses import fields

import pytest
from helpers.robot_files import FOLDER, read_csv

from robodyn.robot.load import load
from robodyn.scene.fit import check_scene
from robodyn.scene.parts import Friction, Rotor, Spring
from robodyn.scene.read import load_scene
from robodyn.scene.scene import DEFAULT

SCENES = {
    "puma560_motors": ("puma560", "puma560_sweep"),
    "puma560_sizing": ("puma560", "puma560_sweep"),
    "puma560_uncertain": ("puma560", "puma560_sweep"),
    "puma_payload": ("puma", "puma_reach"),
    "puma_polish": ("puma", "puma_polish"),
    "satellite": ("satellite", "satellite_slew"),
    "rigid_body": ("rigid_body", "rigid_body_flip"),
    "gripper": ("gripper", "gripper_pick"),
    "two_link_planar_swing_down": ("two_link_planar", "two_link_planar_swing"),
    "pendulum_a01": ("pendulum", None),
    "four_bars_a02": ("four_bars", None),
    "crank_slider_pump": ("crank_slider", None),
    "puma_servo": ("puma", "puma_reach"),
    "puma560_power_cut": ("puma560", None),
    "scara_servo": ("scara", "scara_pick_and_place"),
    "cylindrical_fall": ("cylindrical", None),
    "two_link_spatial_whirl": ("two_link_spatial", None),
    "satellite_deploy": ("satellite", None),
    "composite_throw": ("composite", None),
    "rigid_body_tumble": ("rigid_body", None),
    "double_pendulum_chaos": ("double_pendulum", None),
    "heavy_top_steady": ("heavy_top", None),
    "crank_slider_turn": ("crank_slider", "crank_slider_turn"),
    "four_bar_lift": ("four_bar", "four_bar_lift"),
    "five_bar_reach": ("five_bar", "five_bar_reach"),
    "delta_pick": ("delta", "delta_pick"),
    "planar_3rrr_circle": ("planar_3rrr", "planar_3rrr_circle"),
    "quadruped_stand": ("quadruped", "quadruped_stand"),
    "quadruped_crouch": ("quadruped", "quadruped_crouch"),
    "quadruped_trot": ("quadruped", "quadruped_trot"),
}


def test_every_scene_is_listed():
    assert {path.stem for path in FOLDER.glob("*.toml")} == set(SCENES)


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_fits_its_robot_and_its_table_and_says_what_it_exercises(name):
    robot, motion = SCENES[name]
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
