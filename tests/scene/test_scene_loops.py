"""[[loop]] of scene.toml: every key, and one line for whatever is wrong."""

from __future__ import annotations

import re

import pytest
from helpers.oracles import robot

from robodyn.errors import SceneError
from robodyn.scene.fit import check_scene
from robodyn.scene.parts import Loop
from robodyn.scene.read import parse_scene
from robodyn.scene.scene import Scene

EVERY_KIND = b"""
baumgarte = 20

[[loop]]
name = "ball"
link = "rod"

[[loop]]
name = "slot"
link = "rod"
point = [1, 0, 0]
to = "slider"
to_point = [0, 0.5, 0]
directions = [[1, 0, 0], [0, 0, 2]]

[[loop]]
name = "pin"
link = "rod"
kind = "hinge"
axis = [0, 3, 4]

[[loop]]
name = "pins"
link = "rod"
kind = "hinge"
axis = [0, 1, 0]
to_axis = [0, 0, 1]

[[loop]]
name = "joined"
link = "rod"
to = "ground"
kind = "weld"
rpy = [0.1, 0.2, 0.3]
"""


def test_every_key():
    scene = parse_scene(EVERY_KIND)
    assert scene.baumgarte == 20.0
    assert scene.loops == (
        Loop("ball", "rod"),
        Loop("slot", "rod", (1, 0, 0), "slider", (0, 0.5, 0), directions=((1, 0, 0), (0, 0, 2))),
        Loop("pin", "rod", kind="hinge", axis=(0, 3, 4), to_axis=(0, 3, 4)),
        Loop("pins", "rod", kind="hinge", axis=(0, 1, 0), to_axis=(0, 0, 1)),
        Loop("joined", "rod", kind="weld", rpy=(0.1, 0.2, 0.3)),
    )
    assert Scene().loops == ()


NAMED = '[[loop]]\nname = "a"\nlink = "b"\n'
WRONG = {
    '[loop]\nname = "a"': '"loop" is not a list of tables (write [[loop]] above each)',
    '[[loop]]\nlink = "b"': '[[loop]] number 1: "name" is missing',
    '[[loop]]\nname = "a"': '[[loop]] number 1: "link" is missing',
    NAMED + 'kind = "ball"': '"kind" is "ball" (one of: point, hinge, weld)',
    NAMED + 'kind = "hinge"': '"axis" is missing',
    NAMED + 'kind = "hinge"\naxis = [0, 0, 0]': '"axis" is zero (give a vector that has a direction)',
    NAMED + 'kind = "hinge"\naxis = [0, 0, 1]\nto_axis = [0, 0, 0]': '"to_axis" is zero',
    NAMED + "axis = [0, 0, 1]": "unknown key \"axis\" (valid keys: 'kind', 'name', 'link', 'point', 'to', 'to_point', "
    "'directions')",
    NAMED + 'kind = "weld"\ndirections = []': 'unknown key "directions"',
    NAMED + "directions = [1, 0, 0]": '"directions" is 1, not 3 numbers',
    NAMED + "directions = [[0, 0, 0]]": 'one of "directions" is zero',
    NAMED + "directions = [[0, 0, 1], [0, 0, -2]]": 'two of "directions" are parallel (give each direction once)',
    NAMED + "directions = [[1, 0, 0], [0, 1, 0], [1, 1, 0]]": '"directions" lie in a plane (two of them are enough)',
    NAMED + f"directions = {[[1, 0, 0]] * 4}": "not at most 3 vectors of 3 numbers",
    NAMED + 'to = "b"': '"link" and "to" are both "b" (a loop connects two links)',
    NAMED + NAMED: '2 loops and contacts have the name "a" (give each a name of its own)',
    "baumgarte = -1": '"baumgarte" is -1 (it is positive, or 0 for projection after each step)',
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_values(text):
    with pytest.raises(SceneError) as caught:
        parse_scene(text.encode(), "my.toml")
    assert str(caught.value).startswith("my.toml: ")
    assert WRONG[text] in str(caught.value)
    assert "\n" not in str(caught.value)


MISFITS = {
    "no such link": (Loop("a", "flang"), "[[loop]] 'a': the robot has no link 'flang' (did you mean 'flange'?)"),
    "no such other link": (
        Loop("a", "flange", to="groud"),
        "[[loop]] 'a': the robot has no link 'groud' (did you mean 'ground'?)",
    ),
    "the base to the ground": (
        Loop("a", "base"),
        "[[loop]] 'a': no joint moves 'base' against 'ground' (a loop connects links that move against each other)",
    ),
}


@pytest.mark.parametrize("where", MISFITS)
def test_loops_that_do_not_fit_the_robot(where):
    loop, what = MISFITS[where]
    with pytest.raises(SceneError, match=f"^my.toml: {re.escape(what)}$"):
        check_scene(Scene(loops=(loop,)), robot("puma560"), "my.toml")


def test_a_loop_that_fits():
    check_scene(Scene(loops=(Loop("a", "flange"), Loop("b", "flange", to="base"))), robot("puma560"))
