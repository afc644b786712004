"""What Python shows of a model and of a scene: three lines, and the call that makes it."""

from __future__ import annotations

import inspect
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS
from helpers.example_robots import PATHS
from helpers.small_robots import built, joint, link

import robodyn
from robodyn.scene.parts import LimitSpring
from robodyn.scene.scene import DEFAULT, Scene

FILES = [*sorted(ROBOTS.glob("*.urdf"))[::4], *PATHS[::25]]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_model_is_shown_in_three_lines(path: Path) -> None:
    model = robodyn.load(path)
    first, second, third = repr(model).split("\n")
    assert first.startswith(f"<Model '{model.name}' of ")
    assert f"{path.name}'" in first
    assert first.endswith("moving base" if model.floating else "fixed base")
    assert second.startswith(f" {model.n} degree")
    assert all(f"'{name}'" in second for name in model.joint_names[:8])
    assert third.endswith(">")
    assert len(repr(model)) < 1000


def test_hostile_names_are_shown_without_effect() -> None:
    long, strange = "l" * 9999, "a\u202e\x85b"
    model = built(link(long), link(strange, 1.0), joint(strange * 500, long, strange))
    text = repr(model)
    assert len(text) < 500
    assert text.count("\n") == 2
    assert all(character.isprintable() or character == "\n" for character in text)


def test_a_scene_is_shown_as_the_call_that_makes_it() -> None:
    names = {name: getattr(robodyn, name) for name in robodyn.__all__} | {"LimitSpring": LimitSpring}
    for path in ROBOTS.glob("*.toml"):
        scene = robodyn.load_scene(path)
        assert eval(repr(scene), names) == scene


def test_signatures_can_be_read() -> None:
    """No default takes a line of its own: a scene's was 800 characters long."""
    for name in filter(str.islower, robodyn.__all__):
        parameters = inspect.signature(getattr(robodyn, name)).parameters.values()
        assert [each for each in parameters if len(repr(each.default)) > 40] == []


def test_the_default_scene_is_short() -> None:
    assert repr(DEFAULT) == "Scene()"
    assert repr(Scene(gravity=(0, 0, -1.62))) == "Scene(gravity=(0.0, 0.0, -1.62))"
