"""scene.toml: every key is read, and whatever is wrong is one line that says what and what would be right."""

from __future__ import annotations

import pytest
from helpers.oracles import ROBOTS

from robodyn.errors import SceneError
from robodyn.scene.parts import Drive, ExternalWrench, Friction, Immersed, LimitSpring, Payload, Rotor, Spring
from robodyn.scene.read import load_scene, parse_scene
from robodyn.scene.scene import Scene

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


def test_an_empty_file_is_the_default_scene():
    scene, default = parse_scene(b""), Scene()
    assert {name: getattr(scene, name) for name in Scene.__dataclass_fields__} == {
        name: getattr(default, name) for name in Scene.__dataclass_fields__
    }
    assert scene.gravity == (0.0, 0.0, -9.81)


@pytest.mark.parametrize("frame", ["link", "base", "world"])
def test_frames(frame):
    text = f'[[wrench]]\nlink = "a"\nframe = "{frame}"'.encode()
    assert parse_scene(text).wrenches[0].frame == frame


UNKNOWN = {
    "gravty = [0, 0, 0]": (
        *("gravity", "friction", "rotor", "spring", "payload", "wrench", "fluid", "base", "motor", "coupled"),
        *("slip_speed", "initial", "drive", "joint_limits", "loop", "baumgarte", "between_rows", "limit_spring"),
        *("actuated", "passive", "share", "weights", "contact", "contact_cost", "uncertainty"),
    ),
    "[friction]\na = { viscos = 1 }": ("viscous", "coulomb", "stribeck", "stribeck_velocity", "load"),
    "[rotor]\na = { inertia = 1, ratio = 2 }": ("inertia", "gear", "axis", "on"),
    "[spring]\na = { stiffness = 1, k = 2 }": ("stiffness", "rest"),
    '[[payload]]\nlink = "a"\nmass = 1\ncentre = [0, 0, 0]': ("link", "mass", "com", "inertia"),
    '[[wrench]]\nlink = "a"\ntorque = [0, 0, 0]': ("link", "force", "moment", "point", "frame"),
    "[fluid]\ndensity = 1\nspeed = [0, 0, 0]": ("density", "velocity", "link"),
    '[fluid]\ndensity = 1\n[[fluid.link]]\nlink = "a"\narea = 1': ("link", "volume", "centre", "drag_area"),
    '[base]\nmoving = "yes"': ("motion", "held"),
    "[drive]\na = { torqe = 1 }": ("torque", "kp", "kd", "reference", "speed"),
    'joint_limits = "spring"\n[limit_spring]\nk = 1\nstiffness = 2': ("stiffness", "damping"),
    "[initial]\nqdd = { a = 1 }": ("q", "qd"),
}


@pytest.mark.parametrize("text", UNKNOWN)
def test_unknown_keys_list_the_valid_ones(text):
    with pytest.raises(SceneError) as caught:
        parse_scene(text.encode())
    assert 'unknown key "' in caught.value.what
    offered = caught.value.remedy.removeprefix("valid keys: ").partition("; ")[0].split(", ")
    assert sorted(offered) == sorted(repr(key) for key in UNKNOWN[text])


WRONG = {
    "gravity = 9.81": 'the scene: "gravity" is 9.81, not 3 numbers',
    "gravity = [0, 0]": '"gravity" is [0, 0], not 3 numbers',
    'gravity = "down"': "\"gravity\" is 'down', not 3 numbers",
    "gravity = [0, 0, true]": '"gravity" is True, not a finite number',
    "gravity = [0, 0, nan]": '"gravity" is nan, not a finite number',
    "gravity = [0, 0, -inf]": '"gravity" is -inf, not a finite number',
    'gravity = [0, 0, "g"]': "\"gravity\" is 'g', not a finite number",
    "gravity = [0, 0, [1]]": '"gravity" is [1], not a finite number',
    "gravity = [0, 0, 2020-01-01]": "not a finite number",
    "friction = 1": "[friction] is 1, not a table",
    "friction = []": "[friction] is [], not a table",
    "[friction]\na = 1": "[friction] a is 1, not a table",
    '[friction]\na = { viscous = "1" }': "[friction] a: \"viscous\" is '1', not a finite number",
    "[friction]\na = { viscous = -1 }": '"viscous" is -1, which drives the joint',
    "[friction]\na = { coulomb = -1 }": '"coulomb" is -1, which drives the joint',
    "[friction]\na = { stribeck = -1 }": '"stribeck" is -1, which drives the joint',
    "[friction]\na = { coulomb = [1, 1] }": '"coulomb" is [1, 1], which drives the joint',
    "[friction]\na = { coulomb = [-1, -1] }": '"coulomb" is [-1, -1], which drives the joint',
    "[friction]\na = { coulomb = [1] }": '"coulomb" is [1], not 2 numbers',
    "[friction]\na = { stribeck_velocity = 0 }": '"stribeck_velocity" is 0',
    "[rotor]\na = {}": '[rotor] a: "inertia" is missing',
    "[rotor]\na = { inertia = -1 }": '"inertia" is -1',
    "[rotor]\na = { gear = 2 }": '"inertia" is missing',
    "[spring]\na = { rest = 1 }": '[spring] a: "stiffness" is missing',
    "payload = 1": '"payload" is not a list of tables',
    "[payload]\nmass = 1": '"payload" is not a list of tables',
    "payload = [1]": "[[payload]] number 1 is 1, not a table",
    "[[payload]]\nmass = 1": '[[payload]] number 1: "link" is missing',
    '[[payload]]\nlink = "a"': '[[payload]] number 1: "mass" is missing',
    '[[payload]]\nlink = "a"\nmass = 1\n[[payload]]\nlink = 3': '[[payload]] number 2: "link" is 3, not a name',
    '[[payload]]\nlink = ""\nmass = 1': "\"link\" is '', not a name",
    '[[payload]]\nlink = "a"\nmass = 1\ninertia = [1, 1, 1]': '"inertia" is [1, 1, 1], not 6 numbers',
    "[[wrench]]\nforce = [0, 0, 1]": '[[wrench]] number 1: "link" is missing',
    '[[wrench]]\nlink = "a"\nforce = "fx"': "\"force\" is 'fx', not three numbers or names of columns",
    '[[wrench]]\nlink = "a"\nforce = [0, "", 1]': "\"force\" is '', not a finite number",
    '[[wrench]]\nlink = "a"\nmoment = [0, 1]': '"moment" is [0, 1], not three numbers or names of columns',
    '[[wrench]]\nlink = "a"\npoint = ["x", 0, 0]': "\"point\" is 'x', not a finite number",
    '[[wrench]]\nlink = "a"\nframe = "tool"': '"frame" is "tool" (one of: link, base, world)',
    "[fluid]\nvelocity = [0, 0, 0]": '[fluid]: "density" is missing',
    "[fluid]\ndensity = -1": '"density" is -1',
    "fluid = 1": "[fluid] is 1, not a table",
    '[fluid]\ndensity = 1\n[[fluid.link]]\nlink = "a"\nvolume = -1': "volume and drag_area are positive or zero",
    '[base]\nmotion = "free"': '"motion" is "free" (one of: fixed, moving)',
    "base = 1": "[base] is 1, not a table",
    "slip_speed = -1": '"slip_speed" is -1',
    'joint_limits = "bounce"': '"joint_limits" is "bounce" (one of: stop, ignore, spring)',
    'joint_limits = "spring"': '"joint_limits" is "spring" without a [limit_spring] (give its stiffness, N m/rad)',
    'joint_limits = "stop"\n[limit_spring]\nstiffness = 1': '"joint_limits" is "stop" with a [limit_spring] (write',
    'joint_limits = "spring"\nlimit_spring = {}': '[limit_spring]: "stiffness" is missing',
    'joint_limits = "spring"\nlimit_spring = { stiffness = 0 }': "[limit_spring]: stiffness 0, damping 0 (stiffness is",
    'between_rows = "spline"': '"between_rows" is "spline" (one of: linear, hold)',
    "[initial]\nq = 3": "[initial] q is 3, not a table",
    '[initial]\nqd = { a = "" }': "[initial] qd: \"a\" is '', not a finite number",
    "[drive]\na = { kp = true }": '[drive] a: "kp" is True, not a finite number',
    "contact = 0": '"contact" is not a list of tables',
    "ground = 0": '"ground" is no key',
    "gravity = [": "is not TOML",
    "gravity = [0, 0, 0]\ngravity = [0, 0, 0]": "is not TOML",
    "\x00": "is not TOML",
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_values(text):
    with pytest.raises(SceneError) as caught:
        parse_scene(text.encode(), "my.toml")
    assert str(caught.value).startswith("my.toml:")
    assert WRONG[text] in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("digits", [400, 5000], ids=["no float", "no integer"])
@pytest.mark.parametrize("text", ["gravity = [0, 0, {}]", "[rotor]\na = {{ inertia = {} }}", "[fluid]\ndensity = {}"])
def test_integers_that_no_float_holds(text, digits):
    with pytest.raises(SceneError) as caught:
        parse_scene(text.format("9" * digits).encode())
    assert "\n" not in str(caught.value)


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


@pytest.mark.parametrize("path", sorted(ROBOTS.glob("*.toml")), ids=lambda path: path.stem)
def test_scenes_of_the_examples(path):
    assert isinstance(load_scene(path), Scene)


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
