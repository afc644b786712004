"""Several --scene make one; a key given twice is an error with both places; payloads that add up are told."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run

from robodyn.errors import SceneError
from robodyn.scene.read import load_scene

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


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in PARTS.items():
        Path(f"{name}.toml").write_text(f"# {name}\n{text}\n")


def test_scenes_of_parts_are_the_scene_of_the_whole() -> None:
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
    assert run(*CALL, *options).out == run(*CALL, "--scene", "whole.toml").out
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
