"""What the documentation says is left out has no key in a scene, and what has a key is said to be there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.markdown_tables import cells

from robodyn.errors import SceneError
from robodyn.scene.read import parse_scene

ROOT = Path(__file__).parents[2]
LIMITS = (ROOT / "docs" / "explanation" / "limits.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")
CONTACT = '[[contact]]\nname = "c"\nlink = "l"\n{}'
NO_KEY = {
    "elasticity of links": ["elasticity = 1", "[link]\nl = {stiffness = 1}"],
    "elasticity of gears": ["[rotor]\nj = {inertia = 1, stiffness = 1}", "[motor]\nj = {stiffness = 1}"],
    "backlash": ["[rotor]\nj = {inertia = 1, backlash = 0.1}", "[backlash]\nj = 0.1"],
    "dependence on temperature": ["temperature = 293", "[friction]\nj = {viscous = 1, temperature = 293}"],
    "dependence on position": ["[friction]\nj = {viscous = 1, position = 1}"],
    "sticking deflection": ["[friction]\nj = {coulomb = 1, stiffness = 1}"],
    "unbalance": ["[rotor]\nj = {inertia = 1, unbalance = 1}", "[rotor]\nj = {inertia = 1, com = [0, 0, 1]}"],
    "elasticity of shafts": ["[rotor]\nj = {inertia = 1, stiffness = 1}"],
    "thermal model": ["[motor]\nj = {thermal_resistance = 1}", "[motor]\nj = {time_constant = 1}"],
    "current and voltage": ["[motor]\nj = {torque_constant = 1}", "[motor]\nj = {resistance = 1}", "voltage = 48"],
    "contact in a simulation": [CONTACT.format("stiffness = 1"), CONTACT.format("damping = 1")],
    "impact": [CONTACT.format("restitution = 1"), "restitution = 1"],
    "elastic ground": [CONTACT.format("stiffness = 1")],
    "rolling friction": [CONTACT.format("rolling = 1"), CONTACT.format("rolling_friction = 1")],
    "added mass": ['[fluid]\ndensity = 1\n[[fluid.link]]\nlink = "l"\nadded_mass = 1'],
    "lift": ['[fluid]\ndensity = 1\n[[fluid.link]]\nlink = "l"\nlift_area = 1'],
    "effort limit by position": ["[motor]\nj = {peak_by_position = [[0, 1]]}", "[effort]\nj = [[0, 1]]"],
}
"""By what is said to be left out: scenes that would ask for it, with the names by which it is known."""
PARTS = (
    *("[friction]\nj = {KEY}", "[rotor]\nj = {inertia = 1, KEY}", "[spring]\nj = {stiffness = 1, KEY}"),
    *("[motor]\nj = {KEY}", "[fluid]\ndensity = 1\nKEY", "[limit_spring]\nstiffness = 1\nKEY"),
    '[fluid]\ndensity = 1\n[[fluid.link]]\nlink = "l"\nKEY',
    CONTACT.format("KEY"),
)
"""The tables of a scene that say what acts in joints and on links."""


def test_what_is_left_out_has_no_key() -> None:
    assert {each.strip() for row in cells(LIMITS) for each in row[2].split(",")} == set(NO_KEY)
    for scenes in NO_KEY.values():
        for scene in scenes:
            with pytest.raises(SceneError, match="unknown key"):
                parse_scene(scene.encode())


@pytest.mark.parametrize("table", PARTS)
def test_what_has_a_key_is_said_to_be_there(table: str) -> None:
    """A new key fails here, so that whoever adds it reads what the page denies."""
    with pytest.raises(SceneError, match="unknown key") as caught:
        parse_scene(table.replace("KEY", "nonsense = 1").encode())
    keys = set(re.findall(r"[a-z_]+", str(caught.value).partition("valid keys: ")[2]))
    there = {key for row in cells(LIMITS) for words in row[1].split("`")[1::2] for key in re.findall(r"\w+", words)}
    assert len(keys) > 1
    assert keys - there - {"link"} == set()


def test_the_readme_denies_nothing_else() -> None:
    section = README.partition("\n## What it does not do\n")[2].partition("\n## ")[0]
    denied = re.findall(r"\bno ([a-z ]+?)(?= beyond|[,.;]|$)", section.replace("\n  ", " "), re.M)
    assert len(denied) > 5
    assert set(denied) - {"robot"} <= set(NO_KEY)
