"""Actuation, sharing and contacts in scene.toml."""

from __future__ import annotations

import pytest

from robodyn.errors import SceneError
from robodyn.scene.parts import Contact, ContactCost
from robodyn.scene.read import parse_scene

WHOLE = b"""
actuated = ["a", "b"]
share = "weighted"
weights = { a = 2, b = "effort" }
contact_cost = { forces = 2, torques = 0.5, within_limits = true }

[[contact]]
name = "heel"
link = "foot"

[[contact]]
name = "sole"
link = "foot"
polygon = [[0.1, 0.05, 0], [0.1, -0.05, 0], [-0.1, 0, 0]]
normal = [0, 1, 1]
friction = 0.4
on = [[0, 0.5], [1, 1.5]]

[[contact]]
name = "hand"
link = "hand"
point = [0, 0, 0.1]
on = "hand_on"
"""


def test_what_is_read():
    scene = parse_scene(WHOLE)
    heel, sole, hand = scene.contacts
    assert (scene.actuated, scene.passive, scene.share) == (("a", "b"), (), "weighted")
    assert (dict(scene.weights), scene.weight) == ({"a": 2.0, "b": "effort"}, 1.0)
    assert scene.contact_cost == ContactCost(2.0, 0.5, True)
    assert heel == Contact("heel", "foot", ((0.0, 0.0, 0.0),), None, 0.7, "always")
    assert sole.points == ((0.1, 0.05, 0.0), (0.1, -0.05, 0.0), (-0.1, 0.0, 0.0))
    assert (sole.normal, sole.friction, sole.on) == ((0.0, 1.0, 1.0), 0.4, ((0.0, 0.5), (1.0, 1.5)))
    assert (hand.points, hand.on) == (((0.0, 0.0, 0.1),), "hand_on")
    assert scene.motion_columns == ("hand_on",)
    assert scene.columns == ()


@pytest.mark.parametrize(
    "text", [b"passive = []", b'passive = ["a"]', b"actuated = []", b'[[loop]]\nname="l"\nlink="a"']
)
def test_constrained(text):
    assert parse_scene(text).constrained == (text != b"passive = []")


def test_weights_of_all():
    scene = parse_scene(b'weights = "effort"')
    assert scene.share == "weighted"
    assert (dict(scene.weights), scene.weight) == ({}, "effort")


FOOT = '[[contact]]\nname = "f"\nlink = "l"\n'
WRONG = {
    'actuated = "a"': '"actuated" is \'a\', not a list of names (write actuated = ["a", "b"])',
    'passive = ["a", "a"]': '"passive" names a joint twice (name each once)',
    'actuated = ["a"]\npassive = ["b"]': '"actuated" and "passive" are both given (give one',
    'share = "equal"': '"share" is "equal" (one of: least, weighted)',
    'share = "least"\nweights = { a = 1 }': '"weights" are given, and "share" is "least" (write share = "weighted")',
    'share = "weighted"\nweights = { a = 0 }': '[weights]: "a" is 0 (give a positive weight, or "effort"',
    'share = "weighted"\nweights = { a = "x" }': "[weights]: \"a\" is 'x', not a finite number",
    '[[contact]]\nname = "f"': '"link" is missing',
    FOOT + "normal = [0, 0, 0]": '"normal" is zero',
    FOOT + "friction = -1": '"friction" is -1',
    FOOT + "polygon = [[0, 0, 0], [1, 0, 0]]": '"polygon" has 2 different points (give at least 3, each once)',
    FOOT + "polygon = [[0, 0, 0], [1, 0, 0], [0, 0, 0]]": '"polygon" has 2 different points',
    FOOT + "polygon = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\npoint = [0, 0, 0]": '"point" and "polygon" are both given',
    FOOT + "on = [0, 1]": '"on" is [0, 1] (give "always", "auto", the name of a column, or intervals',
    FOOT + "on = [[1, 0]]": '"on" is [[1, 0]]',
    FOOT + "on = [[nan, 1]]": '"on" is [[nan, 1]]',
    FOOT + "on = []": '"on" is []',
    FOOT + FOOT: '2 loops and contacts have the name "f"',
    FOOT + '[[loop]]\nname = "f"\nlink = "a"': '2 loops and contacts have the name "f"',
    "contact_cost = { forces = 0 }": '"forces" is 0 (it is positive: torques alone leave forces open)',
    "contact_cost = { torques = -1 }": '"torques" is -1',
    "contact_cost = { within_limits = 1 }": '"within_limits" is 1 (true or false)',
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_values(text):
    with pytest.raises(SceneError) as caught:
        parse_scene(text.encode(), "my.toml")
    assert str(caught.value).startswith("my.toml: ")
    assert WRONG[text] in str(caught.value)
