"""Whatever bytes a scene file holds, the answer is a scene or one clean line."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import SceneError
from robodyn.scene import scene as parts
from robodyn.scene.read import parse_scene
from robodyn.scene.scene import Scene
from robodyn.scene.toml_table import OF_THE_SCENE
from robodyn.scene.uncertainty import Uncertainty

KINDS = (parts.Friction, parts.Rotor, parts.CoupledMotor, parts.Spring, parts.Payload, parts.ExternalWrench)
KINDS += (parts.Immersed, parts.Drive, parts.LimitSpring, parts.Motor, parts.Loop, parts.Contact, parts.ContactCost)
KEYS = sorted({*OF_THE_SCENE, *(field.name for kind in (*KINDS, Uncertainty) for field in fields(kind))})
KEYS += ["coulomb", "speed_unit", "q", "qd", "polygon", "motion", "held", "density", "velocity", "", "é", "a b"]
WORDS = ["5 %", "3 mm", "link", "base", "world", "moving", "fixed", "tool0", "fx", "", "\n", "\u202e"]
DAMAGE = [b"[", b"]", b"{", b"=", b"'", b"1e999"]
EXAMPLES = sorted((Path(__file__).parents[2] / "robots").glob("*.toml"))


def tables(inner):
    return st.dictionaries(st.sampled_from(KEYS), inner, max_size=6)


numbers = st.one_of(st.integers(), st.integers(10**400, 10**401), st.floats(), st.booleans())
values = st.recursive(
    st.one_of(numbers, st.sampled_from(WORDS), st.text(max_size=5)),
    lambda inner: st.one_of(
        st.lists(inner, max_size=6), st.lists(numbers, min_size=3, max_size=3), tables(inner), st.lists(tables(inner))
    ),
    max_leaves=20,
)


def written(value):
    """A value as inline TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {written(part)}" for key, part in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(written(part) for part in value) + "]"
    return json.dumps(value) if isinstance(value, str) else str(value).lower()


def clean(data):
    try:
        found = parse_scene(data)
    except SceneError as error:
        found = error
    assert isinstance(found, Scene) or (found.what and "\n" not in str(found))


@given(tables(values))
@pytest.mark.slow
def test_any_tables(table):
    clean("\n".join(f"{json.dumps(key)} = {written(value)}" for key, value in table.items()).encode())


@given(st.one_of(st.binary(max_size=60), st.text(max_size=60).map(lambda text: text.encode("utf-8", "surrogatepass"))))
def test_any_bytes(data):
    clean(data)


@given(st.sampled_from(EXAMPLES), st.data())
def test_damaged_examples(path, data):
    text = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(text)))
        stop = min(len(text), start + data.draw(st.integers(0, 10)))
        text[start:stop] = data.draw(st.one_of(st.binary(max_size=4), st.sampled_from(DAMAGE)))
    clean(bytes(text))
