"""The calibrated description and its scene: they have the parameters, and every other byte as it was."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.example_robots import path_of
from helpers.possible_bodies import calibration, described
from helpers.sampled import sampled
from helpers.small_robots import joint, link, urdf

import robodyn
from robodyn.checks.check import check_one
from robodyn.checks.rule import Severity
from robodyn.errors import InputError
from robodyn.identification.parameters.consistent import parameters_of, pseudo_inertia
from robodyn.identification.result import calibrated, calibrated_urdf, friction_toml, lost_meshes
from robodyn.robot.load import assemble, load, load_description
from robodyn.robot.masses.declared import declared
from robodyn.scene.scene import DEFAULT, Friction, Payload, Rotor, Scene

OURS = sorted((Path(__file__).parents[2] / "robots").glob("*.urdf"))
REAL = ("ur10_robot", "solo12")


def assert_has(model, names, theta, tolerance=1e-12):
    """Inertias of each body normwise, kind by kind."""
    found_names, found = described(model)
    assert found_names == names
    for k in range(len(model.bodies)):
        for kind in (slice(0, 1), slice(1, 4), slice(4, 10)):
            ours, wanted = found[10 * k : 10 * k + 10][kind], theta[10 * k : 10 * k + 10]
            reach = np.sqrt(wanted[4:].max() / wanted[0]) if wanted[0] > 0 else 0.0
            size = max(np.abs(wanted[kind]).max(), wanted[0] * reach if kind.start == 1 else 0.0)
            assert np.abs(ours - wanted[kind]).max() <= tolerance * size


def assert_links_possible(model, before):
    """Every link with an <inertial> is a body that can exist, unless it was none before."""
    for each in model.description.links:
        found = declared(each)
        if found is not None and each.name not in before:
            assert found.body.mass > 0
            assert not found.faults, (each.name, found.faults)


def impossible(model):
    return {
        each.name
        for each in model.description.links
        if (found := declared(each)) is not None and (found.faults or not found.body.mass)
    }


def outside(text):
    """The text without inertials and blanks, no link closed in its start tag."""
    text = re.sub(rb"<inertial\s*/>|<inertial>.*?</inertial>", b"", text, flags=re.DOTALL)
    return b"".join(re.sub(rb"<(link[^>]*?)\s*/>", rb"<\1></link>", text).split())


@pytest.mark.parametrize("path", sampled([*OURS, *map(path_of, REAL)], 10), ids=lambda path: path.stem)
def test_it_reads_back(path):
    model = load(path)
    names, theta, wanted = calibration(model, 3)
    found = calibrated_urdf(model, names, theta, wanted)
    again = load(found.data)
    assert_has(again, names, wanted)
    assert_links_possible(again, impossible(model))
    assert outside(found.data) == outside(path.read_bytes())
    if path.stem == "ur10_robot":
        before, after = (
            {(one.code, one.subject) for one in check_one(data, name=str(path)) if one.severity is Severity.ERROR}
            for data in (path.read_bytes(), found.data)
        )
        assert after <= before


TEXT = b"""<?xml version="1.0"?>\r\n<robot name="arm"><!-- kept -->\r
  <link name="base"/>\r
  <link name="fore arm">   <!-- one & only -->\r
    <visual><geometry><box size="1 1 1"/></geometry></visual>\r
    <inertial>\r
      <!-- from CAD -->\r
      <mass value='2.00'/>\r
      <origin rpy="0 0.5 0"   xyz="0.1 0 0"/>\r
      <inertia ixx="0.2" iyy="0.2"   izz="0.2" ixy="0" ixz="0" iyz="0"/>\r
    </inertial>\r
  </link>\r
  <joint name="elbow" type="continuous">\r
    <parent link="base"/><child link="fore arm"/>\r
  </joint>\r
</robot>\r
""".replace(b" & ", b" and ")
NEW = np.array((4.0, 0.5, 0.0, 0.0, 0.25, 0.0, 0.0, 0.28, 0.0, 0.28))


def test_only_numbers_change():
    model = load(TEXT)
    names, theta = described(model)
    wanted = theta.copy()
    wanted[10:20] = NEW
    found = calibrated_urdf(model, names, theta, wanted).data
    old = rb'ixx="0.2" iyy="0.2"   izz="0.2" ixy="0" ixz="0" iyz="0"'
    new = re.search(re.sub(rb'"[0-9.]+"', rb'"[^"]*"', old), found)
    expected = TEXT.replace(b"2.00", b"4.0").replace(b"0 0.5 0", b"0 0 0").replace(b"0.1 0 0", b"0.125 0.0 0.0")
    assert found == expected.replace(old, new[0])
    assert_has(load(found), names, wanted)
    assert calibrated_urdf(model, names, theta, theta, friction=True) == (TEXT, ())


def test_a_comment_goes_to_the_top():
    model = load(TEXT)
    names, theta = described(model)
    found = calibrated_urdf(model, names, theta, theta, comment=["one --- two", "three"]).data
    head = b'<?xml version="1.0"?>\r\n'
    assert found == TEXT.replace(head, head[:-2] + b"\r\n<!-- one - - - two\r\nthree\r\n-->\r\n")
    bare = load(urdf(link("base"), name="bare").split(b"\n", 1)[1])
    assert calibrated_urdf(bare, *described(bare), described(bare)[1], comment=["x"]).data.startswith(
        b"<!-- x -->\n<ro"
    )
    assert load(found).name == "arm"


@pytest.mark.parametrize(
    "inertial",
    [
        "",
        "<inertial><mass value='0'/><inertia ixx='0' ixy='0' ixz='0' iyy='0' iyz='0' izz='0'/></inertial>",
        "<inertial>\n<mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>",
        "<inertial><origin rpy='1 0 0'/><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/>"
        "</inertial>",
    ],
)
def test_what_is_missing_is_put_in(inertial):
    hand = f'<link name="hand">{inertial}</link>' if inertial else '<link name="hand"/>'
    model = load(urdf(link("base"), hand, joint("j", "base", "hand")))
    names, theta = described(model)
    wanted = theta.copy()
    wanted[10:20] = NEW
    found = calibrated_urdf(model, names, theta, wanted)
    assert_has(load(found.data), names, wanted)


def lumped(hand=0.5, own=1.0, tool=0.1):
    ball = (0.01, 0, 0, 0.01, 0, 0.01)
    arm = link("arm", own, (0, 0, 0.2), ball) if own else link("arm")
    fixed = [
        joint("f", "arm", "hand", "fixed", xyz=(0.1, 0, 0.4), rpy=(0.3, 0.2, 1.0)),
        joint("g", "hand", "tool", "fixed"),
    ]
    more = [link("hand", hand, (0.01, 0, 0), ball, (0.1, 0.2, 0.3)), link("tool", tool, (0, 0, 0.1), ball)]
    return load(urdf(link("base"), arm, *more, joint("j", "base", "arm"), *fixed))


def with_body(model, factor):
    names, theta = described(model)
    wanted = theta.copy()
    wanted[10:20] *= factor
    return names, theta, wanted


def inertials(model):
    return {each.name: each.inertial for each in model.description.links}


@pytest.mark.parametrize(("own", "changed"), [(1.0, "arm"), (None, "hand")])
def test_of_links_fixed_to_each_other_the_first_or_the_heaviest_changes(own, changed):
    model = lumped(own=own)
    names, theta, wanted = with_body(model, 1.3)
    found = calibrated_urdf(model, names, theta, wanted)
    again = load(found.data)
    assert_has(again, names, wanted)
    assert not found.notes
    before, after = inertials(model), inertials(again)
    assert [name for name in before if before[name] != after[name]] == [changed]
    assert own is None or after["arm"].mass == pytest.approx(1.0 + 0.3 * 1.6)


@pytest.mark.parametrize("factor", [0.5, 1e-6])
def test_links_that_are_more_than_their_body_are_scaled(factor):
    model = lumped()
    names, theta, wanted = with_body(model, factor)
    found = calibrated_urdf(model, names, theta, wanted)
    again = load(found.data)
    assert_has(again, names, wanted)
    assert_links_possible(again, set())
    assert "the links 'hand', 'tool' are more than body 'arm' is found to be: their masses and in" in found.notes[0]
    share = float(found.notes[0].rpartition(" ")[2])
    after = inertials(again)
    assert after["hand"].mass == pytest.approx(0.5 * share, rel=1e-9)
    assert after["tool"].inertia == pytest.approx(
        tuple(share * x for x in inertials(model)["tool"].inertia), abs=1e-12 * share
    )


def test_payloads_belong_to_no_link():
    model, scene = lumped(), Scene(payloads=(Payload("tool", 0.7, (0.1, 0, 0)),))
    names, theta = described(model, scene=scene)
    wanted = theta.copy()
    wanted[10:20] += described(model)[1][10:20] * 0.2
    again = load(calibrated_urdf(model, names, theta, wanted).data)
    assert described(again, scene=scene)[1] == pytest.approx(wanted, rel=1e-11, abs=1e-12)
    with pytest.raises(InputError, match="body 'arm' leaves nothing that can exist beside its payload"):
        calibrated_urdf(model, names, theta, np.where(np.arange(len(theta)) // 10 == 1, 0.2 * theta, theta))


def test_friction_in_the_description():
    model = load(
        urdf(
            link("base"),
            link("a", 1, inertia=(1, 0, 0, 1, 0, 1)),
            joint("j", "base", "a"),
            link("b"),
            joint("k", "a", "b", more='<mimic joint="j"/><dynamics friction="0.5"/>'),
        )
    )
    names, theta = described(model)
    wanted = dict(zip(names, theta.tolist(), strict=True))
    wanted |= {"j.viscous": 0.3, "j.forward": 2.0, "j.backward": -2.0}
    wanted |= {"k.viscous": 0.1, "k.forward": 1.0, "k.backward": -3.0}
    values = np.array(list(wanted.values()))
    found = calibrated_urdf(model, names, theta, values, friction=True)
    assert b'<dynamics damping="0.3" friction="2.0"/>' in found.data
    assert b'<dynamics friction="2.0" damping="0.1"/>' in found.data
    assert found.notes[0].startswith("<dynamics friction> is the mean of the friction of 'k', which differs forwards")
    assert calibrated_urdf(model, names, theta, values).data == model.description.data


def test_meshes_that_would_be_lost(tmp_path):
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot" / "part.stl").write_bytes(b"solid\nendsolid\n")
    part = '<link name="base"><visual><geometry><mesh filename="{}"/></geometry></visual></link>'
    path = tmp_path / "robot" / "arm.urdf"
    path.write_bytes(
        urdf(part.format("part.stl"), part.format("gone.stl").replace("base", "b"), joint("j", "base", "b"))
    )
    description = load_description(path)
    assert lost_meshes(description, str(tmp_path / "robot" / "new.urdf")) is None
    line = lost_meshes(description, str(tmp_path / "new.urdf"))
    assert line.startswith("1 mesh of 2 will not be found beside ")
    assert line.endswith("write it into " + repr(str(tmp_path / "robot")))


def test_what_cannot_be_edited_is_refused():
    model = load(TEXT.decode().replace('version="1.0"', 'version="1.0" encoding="utf-16"').encode("utf-16"))
    names, theta = described(model)
    with pytest.raises(InputError, match="UTF-16"):
        calibrated_urdf(model, names, theta, theta)


def test_a_xacro_file_is_expanded(tmp_path):
    pytest.importorskip("xacrodoc")
    path = tmp_path / "arm.urdf.xacro"
    path.write_bytes(TEXT.replace(b'<robot name="arm">', b'<robot name="arm" xmlns:xacro="http://ros.org/wiki/xacro">'))
    model = assemble(load_description(path))
    names, theta = described(model)
    wanted = theta.copy()
    wanted[10:20] = NEW
    found = calibrated_urdf(model, names, theta, wanted)
    assert found.notes[0].startswith("the description is xacro")
    assert_has(load(found.data), names, wanted)


def test_a_narrow_body_keeps_its_digits():
    """A needle of 1 : 1e4, far from its frame."""
    model = load(urdf(link("base"), link("a", 1, (5, 0, 0), (1, 0, 0, 1, 0, 1)), joint("j", "base", "a")))
    names, theta = described(model)
    wanted = theta.copy()
    wanted[10:20] = parameters_of(
        pseudo_inertia((1, 1, 0, 0, 0, 0, 0, 0, 0, 0)) + np.diag((1e-4, 1e-12, 1e-12, 0)) + np.diag((1.0, 0, 0, 0))
    )
    again = load(calibrated_urdf(model, names, theta, wanted).data)
    assert_has(again, names, wanted)


def read_back(tmp_path, text):
    path = tmp_path / "friction.toml"
    path.write_text(text, encoding="utf-8")
    return robodyn.load_scene(path)


@pytest.mark.parametrize("scene", [DEFAULT, BUSY_SCENE, replace(BUSY_SCENE, slip_speed=0.02)])
def test_it_has_the_parameters_and_reads_back(tmp_path, scene):
    model = busy_robot()
    names, _, theta = calibration(model, 1, scene=scene)
    found = calibrated(model, names, theta, scene)
    again, values = described(model, scene=found)
    of_joints = [k for k, name in enumerate(names) if name.endswith((".viscous", ".forward", ".backward", ".rotor"))]
    assert again == names
    assert np.abs(values - theta)[of_joints].max() <= 4 * np.finfo(float).eps * np.abs(theta[of_joints]).max()
    text = friction_toml(model, found, ["as found", "in a log"])
    assert text.startswith("# as found\n# in a log\n")
    written = read_back(tmp_path, text)
    assert (written.friction, written.rotor, written.slip_speed) == (found.friction, found.rotor, scene.slip_speed)
    others = ("payloads", "wrenches", "spring", "gravity", "motor")
    assert all(getattr(found, name) == getattr(scene, name) for name in others)


def test_it_replaces_what_the_description_says(tmp_path):
    """Zeros are written where the description has none; a joint that never had friction is left out."""
    ball = (1, 0, 0, 1, 0, 1)
    parts = [link(name, 1, inertia=ball) for name in ("base", "a", "b")]
    first = joint("the first", "base", "a", more='<dynamics damping="0.5"/>')
    model = load(urdf(*parts, first, joint("second", "a", "b")))
    names, theta = described(model)
    found = calibrated(model, names, np.where([name == "the first.viscous" for name in names], 0.0, theta))
    assert friction_toml(model, found) == '[friction."the first"]\nviscous = 0.0\ncoulomb = 0.0\n'
    assert read_back(tmp_path, friction_toml(model, found)).friction == {"the first": Friction()}


def test_stribeck_and_gears_stay():
    model = load(urdf(link("base"), link("a", 1, inertia=(1, 0, 0, 1, 0, 1)), joint("j", "base", "a")))
    scene = Scene(friction={"j": Friction(0.1, 1.0, -2.0, 3.0, 0.5)}, rotor={"j": Rotor(1e-4, -100.0)})
    names, theta = described(model, scene=scene)
    values = dict(zip(names, theta.tolist(), strict=True)) | {"j.stribeck": 2.5, "j.rotor": 2.0}
    found = calibrated(model, names, np.array(list(values.values())), scene)
    assert found.friction == {"j": Friction(0.1, 1.0, -2.0, 2.5, 0.5)}
    assert found.rotor["j"].inertia == pytest.approx(2e-4, rel=1e-15)
    assert friction_toml(model, found) == (
        "[friction.j]\nviscous = 0.1\ncoulomb = [1.0, -2.0]\nstribeck = 2.5\nstribeck_velocity = 0.5\n\n"
        "[rotor.j]\ninertia = 0.0002\ngear = -100.0\n"
    )
