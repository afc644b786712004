"""URDF that is written: read again it is the same to the last bit, and edits touch nothing else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.example_robots import cases
from helpers.sampled import sampled

import robodyn
from robodyn.errors import DescriptionError, InputError
from robodyn.robot.load import assemble, load, load_description
from robodyn.robot.write.common import MARK, check_possible, comments_of
from robodyn.robot.write.urdf import write_urdf
from robodyn.scene.described import described
from robodyn.scene.read import parse_scene

ROBOTS = Path(__file__).parents[3] / "robots"
FILES = [pytest.param(path, id=path.stem) for path in sorted(ROBOTS.glob("*.urdf"))]


def parts_of(description):
    """What it says, without the lines."""
    links = [replace(link, line=1, geometries=tuple(replace(g, line=1) for g in link.geometries))
             for link in description.links]  # fmt: skip
    joints = [replace(joint, line=1) for joint in description.joints]
    return links, joints, [replace(each, line=1) for each in description.transmissions], description.root


@pytest.mark.parametrize("path", [*sampled(FILES, 3), *cases()])
def test_it_is_read_again_to_the_last_bit(path):
    """As edits and, as of another format, as a new text."""
    description = load_description(path)
    try:
        check_possible(description)
    except DescriptionError:
        return
    data = write_urdf(description, str(path)).data
    assert data.replace(f"<!--{MARK}-->".encode(), b"").split() == description.data.split()
    new = write_urdf(replace(description, format="mjcf"), str(path)).data
    for text in (data, new):
        again = load_description(text)
        assert parts_of(again) == parts_of(description)
    a, b = assemble(description), assemble(again)
    for one, two in zip(a.bodies, b.bodies, strict=True):
        for x, y in zip(one.inertia, two.inertia, strict=True):
            assert np.array_equal(x, y)
    assert set(comments_of(new)) - {("", "")} == set(comments_of(description.data)) - {("", "")}


SCENE = """
friction.elbow = {viscous = 0.25, coulomb = 1.5}
rotor.elbow = {inertia = 1e-4, gear = 50}
rotor.shoulder = {inertia = 2e-4, gear = 100}
spring.elbow = {stiffness = 3.0, rest = 0.2}
payload = [{link = "spindle", mass = 2.0, com = [0.1, 0, 0], inertia = [1, 0, 0, 1, 0, 1]}]
[[loop]]
name = "tip"
link = "spindle"
to = "base"
point = [0, 0, 0.1]
to_point = [1, 0, 0.5]
kind = "weld"
rpy = [0.1, 0.2, 0.3]
[[loop]]
name = "pin"
link = "spindle"
to = "base"
kind = "hinge"
axis = [0, 0, 1]
to_axis = [0, 1, 0]
[[loop]]
name = "ground"
link = "spindle"
"""
GEARED = """<transmission name="drive"><joint name="elbow"/><actuator name="m">
  <mechanicalReduction>30</mechanicalReduction></actuator></transmission></robot>"""


def test_what_a_scene_says_goes_along_by_edits():
    text = (ROBOTS / "scara.urdf").read_text().replace("</robot>", GEARED)
    model = load(text.encode())
    scene = replace(parse_scene(SCENE.encode()), gravity=(0.0, 1.0, -3.0))
    description, lost = described(model.description, scene)
    assert not lost
    written = write_urdf(description, "out.urdf")
    assert written.lost == [
        "the loop ground, to the ground or held along some directions",
        "gravity",
        "springs 'elbow'",
    ]
    again = load(written.data)
    own = robodyn.scene_of(again)
    for one, two in zip(own.loops, scene.loops, strict=False):
        assert replace(one, rpy=two.rpy) == two
        np.testing.assert_allclose(one.rpy, two.rpy, atol=1e-15)
    state = [0.1, 0.2, 0.3], [1, 2, 3], [3, 2, 1]
    bare = replace(scene, spring={}, loops=())
    expected = robodyn.inverse_dynamics(model, *state, scene=bare)
    found = robodyn.inverse_dynamics(again, *state, scene=robodyn.Scene(gravity=scene.gravity))
    np.testing.assert_allclose(found, expected, rtol=1e-15)
    (drive,) = (each for each in again.description.transmissions if each.name == "drive")
    assert (drive.reduction, drive.rotor_inertia) == (50.0, 1e-4)
    once = write_urdf(again.description, "out.urdf")
    assert once.data == written.data, "what is written stays as it is"


def test_names_of_meshes_are_those_seen_from_the_output(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "meshes" / "a&b.stl").write_bytes(b"")
    shape = "<visual><geometry><mesh filename='{}'/></geometry></visual>"
    names = ("meshes/a&amp;b.stl", "meshes/none.stl", "package://p/q.stl")
    text = f"<robot name='r'><link name='l'>{''.join(map(shape.format, names))}</link></robot>"
    (tmp_path / "r.urdf").write_text(text)
    description = load_description(tmp_path / "r.urdf")
    there = write_urdf(description, str(tmp_path / "out" / "r.urdf")).data.decode()
    assert there.replace(f"<!--{MARK}-->\n", "") == text.replace("meshes/a&amp;b.stl", "../meshes/a&amp;b.stl")
    with pytest.raises(InputError, match="UTF-16"):
        write_urdf(load_description("<robot name='r'><link name='l'/></robot>".encode("utf-16")), "x.urdf")


def test_mjcf_becomes_urdf(tmp_path):
    pytest.importorskip("mujoco")
    (tmp_path / "a.xml").write_text(
        """<mujoco model='m'><option gravity='0 0 -3'/><worldbody><!-- an arm --><body name='a'>
        <joint name='j' axis='0 1 0'
        armature='.02' damping='.3' range='-90 90'/><inertial pos='.1 0 0' mass='1' diaginertia='.1 .1 .1'/>
        <geom size='.1 .2' type='capsule'/></body></worldbody></mujoco>"""
    )
    model = load(tmp_path / "a.xml")
    description, lost = described(model.description, robodyn.scene_of(model))
    written = write_urdf(description, str(tmp_path / "a.urdf"))
    assert (lost, written.lost) == ([], ["gravity"])
    assert b'<!-- an arm -->\n  <link name="a">' in written.data
    again = load(written.data)
    assert parts_of(again.description) == parts_of(model.description)
