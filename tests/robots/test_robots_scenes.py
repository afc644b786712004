"""The scenes of robots/: keys of the contract, names that exist, and every effect in at least one of them."""

from __future__ import annotations

from helpers.robot_files import FOLDER, read_csv

from robodyn.robot.load import load
from robodyn.scene.fit import check_scene
from robodyn.scene.read import load_scene

MOTIONS = {
    "puma560_heat": "puma560_sweep",
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
