"""scene.toml: every key is read; whatever is wrong is one line that says where, what, and what would be right."""

from __future__ import annotations

import json
import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from helpers.oracles import robot
from hypothesis import given
from hypothesis import strategies as st

from robodyn.dynamics.effects.motors import rotor_of
from robodyn.errors import SceneError
from robodyn.scene import scene as parts
from robodyn.scene.read import load_scene, parse_scene
from robodyn.scene.scene import (
    Contact,
    ContactCost,
    Drive,
    ExternalWrench,
    Friction,
    Immersed,
    LimitSpring,
    Loop,
    Motor,
    Payload,
    Rotor,
    Scene,
    Spring,
)
from robodyn.scene.toml_table import OF_THE_SCENE
from robodyn.scene.uncertainty import Uncertainty

EVERYTHING = b"""
gravity = [0.5, -1, -9.81]

[friction]
a = { viscous = 0.1, coulomb = 0.4 }
b = { viscous = 1, coulomb = [0.4, -0.35], stribeck = 0.6, stribeck_velocity = 0.05 }
c = {}

[rotor]
a = { inertia = 2e-4, gear = -62.6 }
b = { inertia = 1 }

[spring]
a = { stiffness = 12.0, rest = 0.1 }
b = { stiffness = -3 }

[[payload]]
link = "tool0"
mass = 2.5
com = [0, 0, 0.1]
inertia = [1, 2, 3, 4, 5, 6]

[[payload]]
link = "hand"
mass = -1

[[wrench]]
link = "tool0"
point = [1, 2, 3]
frame = "base"
force = ["fx", 0, "fz"]
moment = [0, "mz", 1.5]

[[wrench]]
link = "hand"

[fluid]
density = 1000
velocity = [1, 0, 0]
[[fluid.link]]
link = "hand"
volume = 0.5
centre = [0, 1, 0]
drag_area = [1, 2, 3]

[base]
motion = "moving"
"""


def test_every_key():
    scene = parse_scene(EVERYTHING)
    assert scene.gravity == (0.5, -1.0, -9.81)
    assert scene.friction == {
        "a": Friction(0.1, 0.4, -0.4),
        "b": Friction(1.0, 0.4, -0.35, 0.6, 0.05),
        "c": Friction(0.0, 0.0, -0.0, None, 0.01),
    }
    assert scene.rotor == {"a": Rotor(2e-4, -62.6), "b": Rotor(1.0, None)}
    assert scene.spring == {"a": Spring(12.0, 0.1), "b": Spring(-3.0, 0.0)}
    loaded = Payload("tool0", 2.5, (0.0, 0.0, 0.1), (1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    assert scene.payloads == (loaded, Payload("hand", -1.0))
    pushed = ExternalWrench("tool0", ("fx", 0.0, "fz"), (0.0, "mz", 1.5), (1.0, 2.0, 3.0), "base")
    assert scene.wrenches == (pushed, ExternalWrench("hand"))
    assert scene.columns == ("fx", "fz", "mz")
    assert (scene.fluid_density, scene.fluid_velocity) == (1000.0, (1.0, 0.0, 0.0))
    assert scene.immersed == (Immersed("hand", 0.5, (0.0, 1.0, 0.0), (1.0, 2.0, 3.0)),)
    assert scene.moving_base is True
    assert parse_scene(b"") == Scene()


def test_parts_of_a_simulation():
    text = """
        joint_limits = "spring"
        limit_spring = { stiffness = 1e4, damping = 20 }
        between_rows = "hold"
        [initial]
        q = { a = "q_a", b = 0.5 }
        [drive]
        a = { torque = "ff", kp = 3, kd = 2, reference = "q_a", speed = "qd_a" }
        b = { kd = 1, speed = -0.5 }
    """
    scene = parse_scene(text.encode())
    assert (scene.joint_limits, scene.limit_spring, scene.between_rows) == ("spring", LimitSpring(1e4, 20.0), "hold")
    assert scene.drive == {"a": Drive("ff", 3.0, 2.0, "q_a", "qd_a"), "b": Drive(kd=1.0, speed=-0.5)}
    assert (scene.table_columns, scene.columns) == (("ff", "q_a", "qd_a"), ())


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


def test_every_kind_of_loop():
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


def test_actuation_and_contacts():
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
    everyone = parse_scene(b'weights = "effort"')
    assert (everyone.share, dict(everyone.weights), everyone.weight) == ("weighted", {}, "effort")
    assert [parse_scene(b"passive = " + names).constrained for names in (b"[]", b'["a"]')] == [False, True]
    assert scene.columns == ()


def motor(text):
    return parse_scene(f"[motor]\nj = {{ {text} }}".encode())


def test_every_key_of_a_motor():
    scene = motor(
        'gear = -50, efficiency = 0.8, inertia = 2e-4, speed_unit = "rpm", continuous = [[0, 0.5], [3000, 0.4]], '
        "peak = 1.5, max_speed = 5000, gear_average = 40, gear_peak = 60"
    )
    rpm = np.pi / 30
    assert scene.motor == {"j": Motor(0.8, ((0.0, 0.5), (3000 * rpm, 0.4)), 1.5, 5000 * rpm, 40.0, 60.0)}
    assert scene.rotor == {"j": Rotor(2e-4, -50.0)}
    assert (motor("").motor, motor("").rotor) == ({"j": Motor()}, {})
    own = parse_scene(b"[rotor]\nj = { inertia = 1, gear = 2 }\n[motor]\nj = { peak = 3 }")
    assert (own.motor, own.rotor) == ({"j": Motor(peak=3.0)}, {"j": Rotor(1.0, 2.0)})


def test_a_gear_alone_leaves_the_inertia_of_the_description():
    joint = replace(robot("puma560").independent[0], name="j", rotor_inertia=5e-4, reduction=30.0)
    assert rotor_of(replace(joint, name="i"), motor("gear = 3")) == (5e-4, 30.0)
    assert rotor_of(joint, motor("gear = 3")) == (5e-4, 3.0)
    assert rotor_of(joint, motor("inertia = 1e-3")) == (1e-3, 30.0)


UNKNOWN = {
    "gravty = [0, 0, 0]": (
        *("gravity", "friction", "rotor", "spring", "payload", "wrench", "fluid", "base", "motor", "gear", "coupled"),
        *("slip_speed", "initial", "drive", "joint_limits", "loop", "baumgarte", "between_rows", "limit_spring"),
        *("actuated", "passive", "share", "weights", "contact", "contact_cost", "uncertainty"),
    ),
    "[friction]\na = { viscos = 1 }": ("viscous", "coulomb", "stribeck", "stribeck_velocity", "load"),
    '[fluid]\ndensity = 1\n[[fluid.link]]\nlink = "a"\narea = 1': ("link", "volume", "centre", "drag_area"),
    '[base]\nmoving = "yes"': ("motion", "held"),
    "[initial]\nqdd = { a = 1 }": ("q", "qd"),
}


@pytest.mark.parametrize("text", UNKNOWN)
def test_unknown_keys_list_the_valid_ones(text):
    with pytest.raises(SceneError) as caught:
        parse_scene(text.encode())
    assert 'unknown key "' in caught.value.what
    offered = caught.value.remedy.removeprefix("valid keys: ").partition("; ")[0].split(", ")
    assert sorted(offered) == sorted(repr(key) for key in UNKNOWN[text])


NAMED = '[[loop]]\nname = "a"\nlink = "b"\n'
FOOT = '[[contact]]\nname = "f"\nlink = "l"\n'
WRONG = {
    "gravity = 9.81": 'the scene: "gravity" is 9.81, not 3 numbers (write gravity = [x, y, z])',
    "gravity = [0, 0, true]": '"gravity" is True, not a finite number',
    "gravity = [0, 0, nan]": '"gravity" is nan, not a finite number',
    'gravity = [0, 0, "g"]': "\"gravity\" is 'g', not a finite number",
    "friction = 1": "[friction] is 1, not a table",
    "[friction]\nelbow = 1": "[friction] elbow is 1, not a table (write elbow = { key = value })",
    'base = "moving"': "[base] is 'moving', not a table (write [base] above lines of key = value)",
    '[friction]\na = { viscous = "1" }': "[friction] a: \"viscous\" is '1', not a finite number",
    "[friction]\na = { viscous = -1 }": '"viscous" is -1 (positive or zero: else it drives the joint)',
    "[friction]\na = { coulomb = -1 }": '"coulomb" is -1 (positive or zero: else it drives the joint)',
    "[friction]\na = { coulomb = [1, 1] }": '"coulomb" is [1, 1], which drives the joint',
    "[friction]\na = { coulomb = [1] }": '"coulomb" is [1], not 2 numbers',
    "[friction]\na = { stribeck_velocity = 0 }": '"stribeck_velocity" is 0',
    "[rotor]\na = {}": '[rotor] a: "inertia" is missing',
    "[rotor]\na = { inertia = -1 }": '"inertia" is -1',
    "payload = 1": '"payload" is not a list of tables',
    "payload = [1]": "[[payload]] number 1 is 1, not a table (write [[payload]] above lines of key = value)",
    "[[payload]]\nmass = 1": '[[payload]] number 1: "link" is missing',
    '[[payload]]\nlink = "a"\nmass = 1\n[[payload]]\nlink = 3': '[[payload]] number 2: "link" is 3, not a name',
    '[[payload]]\nlink = ""\nmass = 1': "\"link\" is '', not a name",
    '[[payload]]\nlink = "a"\nmass = 1\ninertia = [1, 1, 1]': '"inertia" is [1, 1, 1], not 6 numbers',
    '[[wrench]]\nlink = "a"\nforce = "fx"': "\"force\" is 'fx', not 3 numbers or names of columns",
    '[[wrench]]\nlink = "a"\nforce = [0, "", 1]': "\"force\" is '', not a finite number",
    '[[wrench]]\nlink = "a"\npoint = ["x", 0, 0]': "\"point\" is 'x', not a finite number",
    '[[wrench]]\nlink = "a"\nframe = "tool"': '"frame" is "tool" (one of: link, base, world)',
    "[fluid]\ndensity = -1": '"density" is -1',
    '[base]\nmotion = "free"': '"motion" is "free" (one of: fixed, moving)',
    "slip_speed = -1": '"slip_speed" is -1',
    'joint_limits = "bounce"': '"joint_limits" is "bounce" (one of: stop, ignore, spring)',
    "joint_limits = true": 'the scene: "joint_limits" is True, not a name (one of: stop, ignore, spring)',
    'joint_limits = "spring"': '"joint_limits" is "spring" without a [limit_spring] (give its stiffness, N m/rad)',
    'joint_limits = "stop"\n[limit_spring]\nstiffness = 1': '"joint_limits" is "stop" with a [limit_spring] (write',
    'joint_limits = "spring"\nlimit_spring = { stiffness = 0 }': '[limit_spring]: "stiffness" is 0 (it is positive)',
    'between_rows = "spline"': '"between_rows" is "spline" (one of: linear, hold)',
    "[initial]\nq = 3": "[initial] q is 3, not a table",
    '[initial]\nqd = { a = "" }': "[initial] qd: \"a\" is '', not a finite number",
    "[drive]\na = { kp = true }": '[drive] a: "kp" is True, not a finite number',
    "ground = 0": '"ground" is no key',
    "gravity = [": "is not TOML",
    "[drive]\na = {}\n[drive]\n": "is not TOML: cannot declare ('drive',) twice (each key and",
    f"a = {'[' * 5000}": "is not TOML: nested too deeply",
    f"[fluid]\ndensity = {'9' * 400}": "not a finite number",
    f"[rotor]\na = {{ inertia = {'9' * 5000} }}": "is not TOML",
    "\x00": "is not TOML",
    '[loop]\nname = "a"': '"loop" is not a list of tables (write [[loop]] above each)',
    '[[loop]]\nlink = "b"': '[[loop]] number 1: "name" is missing',
    NAMED + 'kind = "ball"': '"kind" is "ball" (one of: point, hinge, weld)',
    NAMED + 'kind = "hinge"': '"axis" is missing',
    NAMED + 'kind = "hinge"\naxis = [0, 0, 0]': '"axis" is (0.0, 0.0, 0.0) (give a vector that has a direction)',
    NAMED
    + "axis = [0, 0, 1]": "unknown key \"axis\" (valid keys: 'kind', 'directions', 'name', 'link', 'point', 'to', "
    "'to_point')",
    NAMED + 'kind = "weld"\ndirections = []': 'unknown key "directions"',
    NAMED + "directions = [1, 0, 0]": '"directions" is 1, not 3 numbers',
    NAMED + "directions = [[0, 0, 0]]": 'one of "directions" is zero',
    NAMED + "directions = [[1, 0, 0], [0, 1, 0], [1, 1, 0]]": 'two of "directions" are parallel, or three',
    NAMED + f"directions = {[[1, 0, 0]] * 4}": "not at most 3 vectors of 3 numbers",
    NAMED + 'to = "b"': '"link" and "to" are both "b" (a loop connects two links)',
    NAMED + NAMED: '2 loops and contacts have the name "a" (give each a name of its own)',
    "baumgarte = -1": '"baumgarte" is -1 (it is positive, or 0 for projection after each step)',
    'actuated = "a"': '"actuated" is \'a\', not a list (names of joints, each once: ["a", "b"])',
    'passive = ["a", "a"]': "\"passive\" is ('a', 'a') (names of joints, each once",
    'actuated = ["a"]\npassive = ["b"]': '"actuated" and "passive" are both given (give one',
    'share = "equal"': '"share" is "equal" (one of: least, weighted)',
    'share = "least"\nweights = { a = 1 }': '"weights" are given, and "share" is "least" (write share = "weighted")',
    'share = "weighted"\nweights = { a = 0 }': '[weights]: "a" is 0 (give a positive weight, or "effort"',
    'share = "weighted"\nweights = { a = "x" }': "[weights]: \"a\" is 'x', not a finite number",
    FOOT + "normal = [0, 0, 0]": '"normal" is (0.0, 0.0, 0.0) (give',
    FOOT + "friction = -1": '"friction" is -1',
    FOOT + "polygon = [[0, 0, 0], [1, 0, 0]]": '"polygon" has 2 different points (give at least 3',
    FOOT + "polygon = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\npoint = [0, 0, 0]": '"point" and "polygon" are both given',
    FOOT + "on = [0, 1]": '"on" is [0, 1] (give "always", "auto", the name of a column, or intervals',
    FOOT + "on = [[1, 0]]": '"on" is [[1, 0]]',
    FOOT + '[[loop]]\nname = "f"\nlink = "a"': '2 loops and contacts have the name "f"',
    "contact_cost = { forces = 0 }": '"forces" is 0 (it is positive: torques alone leave forces open)',
    "contact_cost = { torques = -1 }": '"torques" is -1',
    "contact_cost = { within_limits = 1 }": '"within_limits" is 1, not true or false',
    "[motor]\nj = { efficiency = 85 }": '"efficiency" is 85 (a share above 0 and up to 1, such as 0.85 of 85 %)',
    "[motor]\nj = { gear = 0 }": '"gear" is 0 (turns of the motor per turn of the joint)',
    "[motor]\nj = { inertia = -1 }": '"inertia" is -1 (it is positive or zero)',
    "[motor]\nj = { peak = 0 }": '"peak" is 0 (it is positive; leave it out if it is not known)',
    "[motor]\nj = { peak = [1, 2] }": '"peak" is 1, not 2 numbers (points are [speed, torque]',
    "[motor]\nj = { peak = [] }": '"peak" is () (points are',
    "[motor]\nj = { peak = [[1.5, 0], [1.2, 300]] }": 'the speeds of "peak" do not increase from 0 on: 1.5, 1.2',
    "[motor]\nj = { peak = [[0, -1], [9, 2]] }": 'the torques of "peak" are not positive: -1, 2',
    "[motor]\nj = { continuous = [[0, 1], [9, 2]], peak = [[0, 3], [9, 1]] }": '"continuous" allows 2 at 9',
    '[motor]\nj = { speed_unit = "rpms" }': '"speed_unit" is "rpms" (one of: rad/s, rpm)',
    "[motor]\nj = { spead = 1 }": 'unknown key "spead" (valid keys: ',
    "[rotor]\nj = { inertia = 1 }\n[motor]\nj = { gear = 3 }": '"gear" and [rotor] j say the same (leave [rotor] out)',
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_values(text):
    with pytest.raises(SceneError) as caught:
        parse_scene(text.encode(), "my.toml")
    assert re.match(r"my\.toml:(\d+:)? ", str(caught.value))
    assert WRONG[text] in str(caught.value)
    assert "\n" not in str(caught.value)


PLACES = {
    "# one\nslip_speed = 0\n\ngravity = 9.81\n": 4,
    "[friction]\na = { viscous = 1 }\nb.viscous = 1\nb.coulomb = -1\n": 4,
    "[friction.'a b']\nviscous = 1\n[friction.\"c.d\"]\n  load = 1\n": 4,
    '[[payload]]\nlink = "a"\nmass = 1\n\n[[payload]] # two\nlink = "a"\nmas = 1\n': 5,
    '[[payload]]\nlink = "a"\nmass = 1\n\n[[payload]]\nmass = 1\ncom = [0,\n0]\nlink = "a"': 7,
    '[fluid]\ndensity = 1\n[[fluid.link]]\nlink = "a"\n[[fluid.link]]\nlink = "b"\nvolume = -1': 7,
}


@pytest.mark.parametrize("text", PLACES)
def test_the_line_of_what_is_wrong(text):
    with pytest.raises(SceneError) as caught:
        parse_scene(text.encode(), "my.toml")
    assert caught.value.line == PLACES[text]


def test_files(tmp_path):
    with pytest.raises(SceneError, match="no such file"):
        load_scene(tmp_path / "missing.toml")
    with pytest.raises(SceneError, match="is a directory"):
        load_scene(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(bytes(range(128, 256)))
    with pytest.raises(SceneError, match=r"binary.toml: is not TOML"):
        load_scene(binary)
    good = tmp_path / "good.toml"
    good.write_bytes(EVERYTHING)
    assert load_scene(good).payloads == parse_scene(EVERYTHING).payloads


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
