"""What commands print as JSON is what the published schemas say, no key more and none less."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import run
from jsonschema import Draft202012Validator

ROOT = Path(__file__).parents[2]
SCHEMAS = ROOT / "docs" / "reference" / "schemas"
SWEEP = "torques robots/puma560.urdf robots/puma560_sweep.csv"
TUMBLE = "simulate robots/rigid_body.urdf --scene robots/rigid_body_tumble.toml --duration 0.05"
TX40 = "tests/data/tx40_log/tx40.urdf tests/data/tx40_log/log.parquet"
COMMANDS = (
    ("torques", "torques robots/gripper.urdf robots/gripper_pick.csv --scene robots/gripper.toml"),
    ("simulate", "simulate robots/crank_slider.urdf --scene robots/crank_slider_pump.toml --duration 0.1"),
    ("inertia", "inertia robots/meshes/torn_block.stl robots/meshes/worn_pad.stl robots/meshes/open_tray.stl"),
    ("inertia_robot", "inertia robots/meshed_arm.urdf --at elbow=0.5"),
    ("inertia_robot", "inertia robots/satellite.urdf --symbols --about origin --momentum --terms"),
    ("inertia_robot", "inertia robots/scara.urdf --momentum --qd elbow=1 --links spindle"),
    ("inertia_comparison", "inertia robots/meshed_arm.urdf --compare"),
    ("check", "check robots/puma560.urdf robots/scara.urdf"),
    ("info", "info robots/gripper.urdf"),
    ("diff", "diff robots/puma560.urdf robots/puma.urdf"),
    ("size", "size robots/scara.urdf robots/scara_pick_and_place.csv --catalog robots/catalogue/motors.csv"),
    ("retime", "retime robots/puma560.urdf robots/puma560_waypoints.csv --grid 100"),
    ("fbd", "fbd robots/scara.urdf --at 0.3,-0.5,0.05 --qdd elbow=2"),
    ("equations", "equations robots/puma560.urdf"),
    ("equations_closed", "equations robots/two_link_planar.urdf --form closed"),
    ("equations_closed", "equations robots/rigid_body.urdf --symbols"),
    ("equations_dae", "equations robots/gripper.urdf --form dae"),
    ("linearize", "linearize robots/two_link_planar.urdf --equilibrium"),
    ("envelope", "envelope robots/puma560.urdf --payload flange --samples 100"),
)

SLOW = (
    ("torques_batch", "torques robots/puma.urdf robots/puma_reach.csv robots/puma_polish.csv --out OUT/"),
    ("torques", "torques robots/scara.urdf robots/scara_pick_and_place.csv --explain --accuracy 1e-9"),
    ("torques", f"{SWEEP} --scene robots/puma560_sizing.toml --momentum"),
    ("torques", f"{SWEEP} --scene robots/puma560_uncertain.toml"),
    ("torques", f"{SWEEP} --scene robots/puma560_sizing.toml --scene robots/puma560_heat.toml"),
    ("torques", "torques robots/puma560.urdf --at elbow=0.5 --scene robots/puma560_sizing.toml"),
    ("torques", "torques robots/crank_slider.urdf robots/crank_slider_turn.csv --scene robots/crank_slider_turn.toml"),
    ("simulate", TUMBLE),
    ("simulate", "simulate robots/puma560.urdf --scene robots/puma560_power_cut.toml --duration 0.1"),
    ("inertia", "inertia robots/meshed_arm.urdf --link forearm --geometry visual"),
    ("inertia_robot", "inertia robots/meshed_arm.urdf --link forearm"),
    ("torques", "torques robots/puma.urdf robots/puma_encoder.csv --sizing"),
    ("torques", "torques robots/quadruped.urdf robots/quadruped_trot.csv --scene robots/quadruped_trot.toml"),
    ("linearize", "linearize robots/puma.urdf --scene robots/puma_servo.toml --step 0.01"),
    ("linearize", "linearize robots/puma.urdf --qd 1,2,3"),
    ("linearize", "linearize robots/crank_slider.urdf --scene robots/crank_slider_pump.toml"),
    ("retime", "retime robots/puma560.urdf robots/puma560_sweep.csv --grid 100 --payload flange=1000"),
    ("excite", "excite robots/two_link_planar.urdf --joints elbow"),
    ("torques_measured", f"torques {TX40} --measured --cutoff 20"),
    ("identify", f"identify {TX40} --cutoff 40"),
    ("accuracy", "accuracy robots/meshes/torn_block.stl"),
    ("accuracy", "accuracy robots/puma.urdf robots/puma_encoder.csv"),
    ("accuracy", "accuracy robots/pendulum.urdf robots/pendulum_a01.toml --duration 1 --target 1e-6"),
    ("doctor", "doctor"),
)
SOLE = """
[base]
motion = "moving"
[[contact]]
name = "sole"
link = "lf_foot"
polygon = [[-0.02, -0.02, 0], [0.02, -0.02, 0], [0.02, 0.02, 0], [-0.02, 0.02, 0]]
"""
PULLED = (ROOT / "robots" / "five_bar_reach.toml").read_text(encoding="utf-8").replace('"left", "right"', '"left"')


def schema(name: str) -> Any:
    return json.loads((SCHEMAS / f"{name}.schema.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("name", "command"), [*COMMANDS, *(pytest.param(*each, marks=pytest.mark.slow) for each in SLOW)]
)
def test_documents_are_as_their_schemas_say(name, command, tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    outcome = run(*command.replace("OUT", str(tmp_path)).split(), "--format", "json")
    Draft202012Validator(schema(name)).validate(json.loads(outcome.out))


@pytest.mark.parametrize(
    ("scene", "motion", "key"),
    [
        pytest.param(SOLE, "quadruped.urdf robots/quadruped_crouch.csv", "missing", marks=pytest.mark.slow),
        (PULLED, "five_bar.urdf robots/five_bar_reach.csv", "unbalanced"),
    ],
)
def test_what_nothing_balances_is_in_the_schema(scene, motion, key, tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    path = tmp_path / "scene.toml"
    path.write_text(scene, encoding="utf-8")
    document = json.loads(run("torques", *f"robots/{motion} --scene {path} --format json".split()).out)
    assert document["constraints"][key]
    Draft202012Validator(schema("torques")).validate(document)


def test_every_schema_is_sound_and_used():
    names = {path.name.removesuffix(".schema.json") for path in SCHEMAS.iterdir()}
    assert names == {name for name, _ in (*COMMANDS, *SLOW)}
    for name in names:
        Draft202012Validator.check_schema(schema(name))
