"""The scenes of robots/: keys of the contract, names that exist, and every effect in at least one of them."""

from __future__ import annotations

import pytest
from helpers.robot_files import FOLDER, read_csv
from helpers.scene_files import read_scene

from robodyn.robot.urdf.description import load_description

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
KEYS = {
    "friction": {"viscous", "coulomb", "stribeck", "stribeck_velocity"},
    "rotor": {"inertia", "gear"},
    "motor": {"gear", "inertia", "speed_unit", "continuous", "peak", "max_speed"},
    "spring": {"stiffness", "rest"},
    "payload": {"link", "mass", "com", "inertia"},
    "wrench": {"link", "point", "frame", "force", "moment"},
    "drive": {"torque", "kp", "kd", "reference", "speed"},
    "limit_spring": {"stiffness", "damping"},
    "initial": {"q", "qd"},
    "loop": {"name", "link", "point", "to", "to_point", "kind", "axis", "to_axis", "rpy", "directions"},
    "uncertainty": {"mass", "com", "inertia", "friction", "link", "joint"},
    "contact": {"name", "link", "point", "polygon", "normal", "friction", "on"},
}
SINGLE = {"gravity", "base", "slip_speed", "joint_limits", "actuated"}


def test_every_scene_is_listed():
    assert {path.stem for path in FOLDER.glob("*.toml")} == set(SCENES)


@pytest.mark.parametrize("name", SCENES)
def test_scene_names_joints_links_and_columns_that_exist(name):
    robot, motion = SCENES[name]
    scene, columns = read_scene(name), set(read_csv(motion) if motion else ())
    description = load_description(FOLDER / f"{robot}.urdf")
    assert set(scene) <= {*SINGLE, *KEYS}
    for part in ("friction", "rotor", "spring", "drive", "motor"):
        assert set(scene.get(part, {})) <= {joint.name for joint in description.joints if joint.type != "fixed"}
        assert all(set(entry) <= KEYS[part] for entry in scene.get(part, {}).values())
    for part in ("payload", "wrench", "loop", "contact"):
        for entry in scene.get(part, []):
            assert set(entry) <= KEYS[part]
            assert entry["link"] in {link.name for link in description.links}
    assert set(scene.get("actuated", [])) <= {joint.name for joint in description.joints if joint.type != "fixed"}
    assert {contact["on"] for contact in scene.get("contact", [])} <= {"always", *columns}
    for wrench in scene.get("wrench", []):
        named = [x for x in [*wrench.get("force", []), *wrench.get("moment", [])] if isinstance(x, str)]
        assert set(named) <= columns
    tables = [*scene.get("drive", {}).values(), *scene.get("initial", {}).values()]
    assert {entry for values in tables for entry in values.values() if isinstance(entry, str)} <= columns


@pytest.mark.parametrize("name", SCENES)
def test_scene_says_what_it_exercises(name):
    assert "# Exercises:" in (FOLDER / f"{name}.toml").read_text()


def test_every_effect_appears():
    used = set()
    for name in SCENES:
        scene = read_scene(name)
        used |= set(scene) | {f"base {scene['base']['motion']}" for _ in scene if "base" in scene}
        used |= {
            key for part in ("friction", "rotor", "spring") for entry in scene.get(part, {}).values() for key in entry
        }
        used |= {f"{part} {key}" for part in ("payload", "wrench") for entry in scene.get(part, []) for key in entry}
        used |= {f"frame {entry.get('frame', 'link')}" for entry in scene.get("wrench", [])}
        used |= {
            "column" for entry in scene.get("wrench", []) if any(isinstance(x, str) for x in entry.get("force", []))
        }
    wanted = set().union(*(KEYS[part] for part in ("friction", "rotor", "spring")))
    wanted |= {f"{part} {key}" for part in ("payload", "wrench") for key in KEYS[part]}
    assert used >= wanted | {"gravity", "base fixed", "base moving", "frame link", "frame base", "column"}
