"""What a good description says, which defaults are taken, what is doubted; what other readers make of real robots."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.example_robots import all_paths
from helpers.sampled import sampled
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import DescriptionError
from robodyn.robot.load import load_description
from robodyn.robot.urdf.description import link_shapes
from robodyn.robot.urdf.parts import Description, Geometry, Inertial, Joint, Limit, Link, Mimic, Origin, Transmission

FULL = """<?xml version="1.0"?>
<robot name="full">
  <joint name="swing" type="revolute">
    <origin xyz="1 +2 -3e-1" rpy="
      .5 1. 0"/>
    <parent link="base"/>
    <child link="arm"/>
    <axis xyz="0 0.6 -0.8"/>
    <limit lower="-1" upper="2" effort="30" velocity="4"/>
    <dynamics damping="0.1" friction="0.2"/>
  </joint>
  <link name="base"/>
  <link name="arm">
    <inertial>
      <origin xyz="0 0 1" rpy="0 0 0"/>
      <mass value="2"/>
      <inertia ixx="1" ixy="2" ixz="3" iyy="4" iyz="5" izz="6"/>
    </inertial>
    <visual>
      <origin xyz="0 0 0" rpy="0 0 1"/>
      <geometry><mesh filename="package://a/b.stl" scale="1 -1 1"/></geometry>
    </visual>
    <collision>
      <origin xyz="0 0 0" rpy="0 0 0"/>
      <geometry><cylinder length="2" radius="1"/></geometry>
    </collision>
  </link>
  <link name="finger"><inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
  <joint name="grip" type="prismatic">
    <parent link="arm"/><child link="finger"/>
    <mimic joint="swing" multiplier="-2" offset="0.5"/>
  </joint>
  <transmission name="drive">
    <joint name="swing"/>
    <actuator name="m"><mechanicalReduction> -62.5 </mechanicalReduction><rotorInertia>2e-4</rotorInertia></actuator>
  </transmission>
</robot>
"""  # noqa: E501


def load(*lines: str) -> Description:
    return load_description("\n".join(["<robot name='r'>", *lines, "</robot>"]).encode())


def warnings(description: Description) -> list[tuple[int, str]]:
    return list(description.notes)


def moving(inside: str, kind: str = "revolute") -> Description:
    inside = f"<parent link='a'/><child link='b'/><origin xyz='0 0 0' rpy='0 0 0'/>{inside}"
    return load("<link name='a'/><link name='b'/>", f"<joint name='j' type='{kind}'>", inside, "</joint>")


def test_everything_is_read_in_the_order_of_the_file() -> None:
    robot = load_description(FULL.encode(), name="full.urdf")
    assert robot.notes == ()
    assert (robot.name, robot.file, robot.root) == ("full", "full.urdf", "base")
    inertial = Inertial(2.0, Origin((0.0, 0.0, 1.0)), (1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    mesh = Geometry("visual", Origin(rpy=(0, 0, 1)), "mesh", (), "package://a/b.stl", (1.0, -1.0, 1.0), 19)
    cylinder = Geometry("collision", Origin(), "cylinder", (1.0, 2.0), None, (1.0, 1.0, 1.0), 23)
    assert robot.links == (
        Link("base", None, (), 12),
        Link("arm", inertial, (mesh, cylinder), 13),
        Link("finger", Inertial(0.0, Origin(), (0.0,) * 6), (), 28),
    )
    origin, limit = Origin((1.0, 2.0, -0.3), (0.5, 1.0, 0.0)), Limit(-1.0, 2.0, 30.0, 4.0)
    assert robot.joints == (
        Joint("swing", "revolute", "base", "arm", origin, (0.0, 0.6, -0.8), limit, damping=0.1, friction=0.2, line=3),
        Joint("grip", "prismatic", "arm", "finger", mimic=Mimic("swing", -2.0, 0.5), line=29),
    )
    assert robot.transmissions == (Transmission("drive", "swing", -62.5, 2e-4, 33),)


@pytest.mark.parametrize(
    ("inside", "kind", "words"),
    [
        ("<axis xyz='0 0 -2'/>", "continuous", "the axis of joint 'j' has the length 2, not 1"),
        ("<axis xyz='1 0 0'/><limit lower='1' upper='0' effort='1' velocity='1'/>", "prismatic", "lower 1 > upper 0"),
        ("<limit lower='0' upper='1' effort='-1' velocity='1'/>", "revolute", "negative effort: -1"),
        ("<limit lower='0' upper='1' effort='1' velocity='-1'/>", "revolute", "negative velocity: -1"),
        ("<dynamics damping='-1' friction='0'/>", "revolute", "negative damping: -1"),
        ("<dynamics damping='0' friction='-1'/>", "revolute", "negative friction: -1"),
    ],
)
def test_doubts_about_joints_are_warnings(inside: str, kind: str, words: str) -> None:
    [(_, what)] = warnings(moving(inside, kind))
    assert words in what


@pytest.mark.parametrize(
    ("inside", "kind", "axis", "limit"),
    [
        ("<limit effort='1'/><dynamics/>", "revolute", (1, 0, 0), Limit(None, None, 1.0, None)),
        ("<axis xyz='1 0 0'/><limit effort='1' velocity='2'/>", "continuous", (1, 0, 0), Limit(None, None, 1.0, 2.0)),
        ("<axis xyz='0 0 0'/>", "fixed", (0, 0, 0), None),
        ("", "planar", (1, 0, 0), None),
    ],
)
def test_defaults_are_taken_without_a_word(inside: str, kind: str, axis: tuple[float, ...], limit: Limit) -> None:
    robot = moving(inside, kind)
    (joint,) = robot.joints
    assert (joint.axis, joint.limit, joint.damping, joint.friction) == (axis, limit, 0.0, 0.0)
    assert warnings(robot) == []


def test_doubts_about_links_are_warnings() -> None:
    robot = load(
        "<link name='a'><inertial><mass value='-1'/>"
        "<inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>",
        "<visual><geometry><box size='1 0 1'/></geometry></visual></link>",
    )
    assert warnings(robot) == [
        (2, "link 'a' has a negative mass: -1 kg"),
        (3, "<box> of link 'a' has a length that is not positive: 0 m"),
    ]
    assert robot.links[0].inertial is not None
    assert robot.links[0].inertial.mass == -1.0


def transmission(inside: str) -> Description:
    return load(
        "<link name='a'/><link name='b'/><joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>",
        f"<transmission name='t'>{inside}</transmission>",
    )


@pytest.mark.parametrize(
    ("inside", "reduction", "rotor_inertia"),
    [
        ("<joint name='j'/>", 1.0, None),
        ("<joint name='j'/><mechanicalReduction>5</mechanicalReduction>", 5.0, None),
        ("<joint name='j'><mechanical_reduction>5</mechanical_reduction></joint>", 5.0, None),
        ("<joint name='j'/><actuator><motorInertia>5</motorInertia></actuator>", 1.0, 5.0),
        (
            "<joint name='j'/><actuator xmlns:drake='u'><drake:gear_ratio value='3'/>"
            "<drake:rotor_inertia value='4'/></actuator>",
            3.0,
            4.0,
        ),
        (
            "<joint name='j'><mechanicalReduction>5</mechanicalReduction></joint>"
            "<actuator><mechanicalReduction>5.0</mechanicalReduction></actuator>",
            5.0,
            None,
        ),
    ],
)
def test_transmissions(inside: str, reduction: float, rotor_inertia: float | None) -> None:
    robot = transmission(inside)
    assert robot.transmissions == (Transmission("t", "j", reduction, rotor_inertia, 3),)
    assert warnings(robot) == []


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        ("<joint name='k'/>", "names no joint of the robot and is left out: 'k'"),
        ("<joint/>", "names no joint of the robot"),
        ("<joint name='j'/><joint name='j'/>", "2 <joint> and 0 <actuator>"),
        ("<joint name='j'/><actuator/><actuator/>", "1 <joint> and 2 <actuator>"),
        ("<actuator/>", "0 <joint> and 1 <actuator>"),
    ],
)
def test_transmissions_that_drive_no_single_joint_are_left_out(inside: str, words: str) -> None:
    robot = transmission(inside)
    assert robot.transmissions == ()
    [(line, what)] = warnings(robot)
    assert line == 3
    assert words in what
    zero = transmission("<joint name='j'/><mechanicalReduction>0</mechanicalReduction>")
    assert "reduction 0" in warnings(zero)[0][1]


USUAL = st.floats(1e-60, 1e30) | st.floats(-1e30, -1e-60) | st.just(0.0)


@given(st.lists(USUAL, min_size=3, max_size=3), st.sampled_from(" \t\n"))
def test_numbers_are_read_to_the_last_bit(numbers: list[float], blank: str) -> None:
    text = blank.join(map(repr, numbers))
    origin = f"<origin xyz='{blank}{text}{blank}' rpy='0 0 0'/>"
    robot = load(
        "<link name='a'/><link name='b'/>",
        f"<joint name='j' type='fixed'><parent link='a'/><child link='b'/>{origin}</joint>",
    )
    assert robot.joints[0].origin.xyz == tuple(numbers)


REFUSED = {
    "alex_psyonic_hands.urdf": (1037, "joint 'Left_index_q2' mimics joint 'index_q1', which does not exist"),
    "ur3.urdf": (6, "<robot> has no attribute 'name'"),  # an empty <robot>
}


ROBOTS = all_paths()
LOADED = [path for path in ROBOTS if path.name not in REFUSED][::4]


@pytest.mark.parametrize("path", [path for path in ROBOTS if path.name in REFUSED], ids=lambda path: path.name)
def test_refused_for_a_real_defect(path: Path) -> None:
    line, what = REFUSED[path.name]
    assert len(ROBOTS) >= 65
    with pytest.raises(DescriptionError) as caught:
        load_description(path)
    assert (caught.value.line, caught.value.what) == (line, what)


@pytest.mark.parametrize("path", sampled(LOADED, 4), ids=lambda path: path.name)
def test_agrees_with_yourdfpy(path: Path) -> None:
    yourdfpy = pytest.importorskip("yourdfpy")
    robot = load_description(path)
    other = yourdfpy.URDF.load(str(path), build_scene_graph=False, load_meshes=False).robot
    assert (robot.name, [link.name for link in robot.links]) == (other.name, [link.name for link in other.links])
    share = next((folder for folder in path.parents if folder.name == "share"), path.parent)
    for link, theirs in zip(robot.links, other.links, strict=True):
        shapes = [*link_shapes(robot, link.name, "visual"), *link_shapes(robot, link.name, "collision")]
        for shape, their in zip(shapes, [*theirs.visuals, *theirs.collisions], strict=True):
            assert np.array_equal(
                shape.geometry.origin.xyz, np.zeros(3) if their.origin is None else their.origin[:3, 3]
            )
            if their.geometry.mesh is None:
                assert shape.path is None
                continue
            name = their.geometry.mesh.filename
            file = share / name.removeprefix("package://") if "://" in name else path.parent / name
            assert shape.path.samefile(file) if file.exists() else shape.missing
            scale = 1.0 if their.geometry.mesh.scale is None else their.geometry.mesh.scale
            assert np.array_equal(shape.geometry.scale, np.broadcast_to(scale, 3))
        if link.inertial is None:
            assert theirs.inertial is None
            continue
        assert link.inertial.mass == theirs.inertial.mass
        ixx, ixy, ixz, iyy, iyz, izz = link.inertial.inertia
        assert np.array_equal([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]], theirs.inertial.inertia)
        if theirs.inertial.origin is not None:
            assert np.array_equal(link.inertial.origin.xyz, theirs.inertial.origin[:3, 3])
    assert len(robot.joints) == len(other.joints)
    for joint, mate in zip(robot.joints, other.joints, strict=True):
        assert (joint.name, joint.type, joint.parent, joint.child) == (mate.name, mate.type, mate.parent, mate.child)
        assert np.array_equal(joint.axis, mate.axis)
        assert np.array_equal(joint.origin.xyz, np.zeros(3) if mate.origin is None else mate.origin[:3, 3])
        if joint.limit is not None:
            for name in ("lower", "upper", "effort", "velocity"):
                assert getattr(joint.limit, name) == getattr(mate.limit, name)
        if mate.dynamics is not None:
            assert joint.damping == float(mate.dynamics.damping or 0.0)
            assert joint.friction == float(mate.dynamics.friction or 0.0)
        assert (joint.mimic and joint.mimic.joint) == (mate.mimic and mate.mimic.joint)
