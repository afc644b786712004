"""A healthy robot, and every defect that is planted in it: what is replaced, by what, and where it must be found."""

from __future__ import annotations

from functools import cache
from math import pi
from typing import NamedTuple

from robodyn.checks.check import check_one
from robodyn.checks.rule import Finding

HERE = "@"
"""Marks in a replacement where the finding must begin; it is not part of the text."""

HEALTHY = """<?xml version="1.0"?>
<!-- A base, an arm with a wrist, a two-finger gripper, a camera. -->
<robot name="picker">
  <link name="base">
    <inertial>
      <origin xyz="0 0 0.05"/>
      <mass value="8"/>
      <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.07"/>
    </inertial>
    <collision><geometry><box size="0.3 0.3 0.1"/></geometry></collision>
  </link>
  <link name="arm">
    <inertial>
      <origin xyz="0 0 0.2" rpy="0 0.1 0"/>
      <mass value="3.5"/>
      <inertia ixx="0.04" ixy="0.001" ixz="-0.002" iyy="0.045" iyz="0.0005" izz="0.008"/>
    </inertial>
    <visual><origin xyz="0 0 0.2"/><geometry><cylinder radius="0.05" length="0.4"/></geometry></visual>
  </link>
  <link name="wrist">
    <inertial>
      <mass value="1.25"/>
      <inertia ixx="0.003" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0035"/>
    </inertial>
  </link>
  <link name="left_finger">
    <inertial><mass value="0.11"/><inertia ixx="3e-4" ixy="0" ixz="0" iyy="2e-4" iyz="0" izz="2.5e-4"/></inertial>
  </link>
  <link name="right_finger">
    <inertial><mass value="0.12"/><inertia ixx="3.1e-4" ixy="0" ixz="0" iyy="2.1e-4" iyz="0" izz="2.5e-4"/></inertial>
  </link>
  <link name="camera">
    <inertial><mass value="0.2"/><inertia ixx="4e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="6e-4"/></inertial>
  </link>
  <link name="lens"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/>
    <child link="arm"/>
    <origin xyz="0 0 0.1" rpy="0 0 1.5707963267948966"/>
    <axis xyz="0 0 1"/>
    <limit lower="-2.9" upper="2.8" effort="120" velocity="2.5"/>
    <dynamics damping="0.4" friction="0.6"/>
    <safety_controller soft_lower_limit="-2.85" soft_upper_limit="2.75" k_position="15" k_velocity="10"/>
  </joint>
  <joint name="roll" type="continuous">
    <parent link="arm"/>
    <child link="wrist"/>
    <origin xyz="0 0 0.4"/>
    <axis xyz="0.6 0 0.8"/>
    <limit effort="40" velocity="3"/>
  </joint>
  <joint name="grip" type="prismatic">
    <parent link="wrist"/>
    <child link="left_finger"/>
    <axis xyz="1 0 0"/>
    <limit lower="0" upper="0.04" effort="25" velocity="0.2"/>
  </joint>
  <joint name="grip_follower" type="prismatic">
    <parent link="wrist"/>
    <child link="right_finger"/>
    <axis xyz="-1 0 0"/>
    <limit lower="0" upper="0.05" effort="20" velocity="0.25"/>
    <mimic joint="grip" multiplier="1.1" offset="0.001"/>
  </joint>
  <joint name="mount" type="fixed">
    <parent link="wrist"/>
    <child link="camera"/>
    <origin xyz="0.05 0 0.02" rpy="0.3 0 0"/>
  </joint>
  <joint name="optics" type="fixed"><parent link="camera"/><child link="lens"/></joint>
  <gazebo reference="arm"><mu1 anything="1,5">${not read}</mu1></gazebo>
</robot>
"""


@cache
def findings(text: str) -> tuple[Finding, ...]:
    """What `check` finds in a text; each is checked once."""
    return check_one(text.encode())


def of_code(text: str, code: str) -> Finding:
    """The one finding of a rule."""
    (finding,) = [finding for finding in findings(text) if finding.code == code]
    return finding


class Defect(NamedTuple):
    """`old`, which is in the robot once, replaced by `new`, must be found as `code`."""

    code: str
    old: str
    new: str

    @property
    def text(self) -> str:
        assert HEALTHY.count(self.old) == 1, self.old
        return HEALTHY.replace(self.old, self.new.replace(HERE, ""))

    @property
    def place(self) -> tuple[int, int]:
        """Line and column, from 1."""
        before = HEALTHY.replace(self.old, self.new).partition(HERE)[0]
        return before.count("\n") + 1, len(before) - before.rfind("\n")


_WRIST = '<inertia ixx="0.003" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0035"/>'
_ARM = '<inertia ixx="0.04" ixy="0.001" ixz="-0.002" iyy="0.045" iyz="0.0005" izz="0.008"/>'
_CAMERA = '<inertia ixx="4e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="6e-4"/>'
_LENS = '<link name="lens"/>'
_OPTICS = '<joint name="optics" type="fixed"><parent link="camera"/><child link="lens"/></joint>'
_GRIP = '<limit lower="0" upper="0.04" effort="25" velocity="0.2"/>'
_SHOULDER = '<limit lower="-2.9" upper="2.8" effort="120" velocity="2.5"/>'
_TO_LIMIT = HEALTHY.partition('"shoulder" ')[2].partition("<dynamics")[0]
_SLIDING = '<axis xyz="1 0 0"/>'
_TO_AXIS = HEALTHY.partition('"grip" ')[2].partition("<limit")[0]
_RIGHT = '<mass value="0.12"/><inertia ixx="3.1e-4" ixy="0" ixz="0" iyy="2.1e-4" iyz="0" izz="2.5e-4"/>'
_ROD = '<cylinder radius="0.05" length="0.4"/>'
_ROD_SEEN = f'<visual><origin xyz="0 0 0.2"/><geometry>{_ROD}</geometry></visual>'
_SOFT = 'soft_lower_limit="-2.85" soft_upper_limit="2.75"'

_MOUNT = '<joint name="mount" type="fixed">'
_RED = '<material name="red"><color rgba="1 0 0 1"/></material>'
_RANGE = '<command_interface name="v">@<param name="min">x</param></command_interface>'
_CONTROL = '<ros2_control name="s" type="system"><joint name="roll">{}</joint></ros2_control>'

DEFECTS = tuple(
    Defect(code, old, new)
    for code, old, new in (
        ("RD001", '<mass value="3.5"/>', '<mass value="3.5">'),
        ("RD001", '<mass value="1.25"/>', '<mass value="1.25@<"/>'),
        ("RD001", '<axis xyz="1 0 0"/>', "<axis xyz=@1 0 0/>"),
        ("RD001", '<axis xyz="1 0 0"/>', '<axis xyz="1 0 0" @xyz="0 0 1"/>'),
        ("RD001", "</robot>\n", "</robot>\n@<robot/>\n"),
        ("RD001", "</robot>\n", "@"),
        ("RD002", "<robot ", "@<!DOCTYPE robot>\n<robot "),
        ("RD002", "<robot ", '@<!DOCTYPE robot SYSTEM "http://localhost/robot.dtd">\n<robot '),
        ("RD002", "<robot ", '@<!DOCTYPE robot [<!ENTITY a "&a;">]>\n<robot '),
        ("RD002", "<robot ", '@<!DOCTYPE robot [<!ENTITY a SYSTEM "file:///etc/passwd">]>\n<robot '),
        ("RD002", '"picker"', '"picker@&nbsp;2"'),
        ("RD003", '<joint name="optics" ', '<joint name="optics" @drake:x="1" '),
        ("RD003", _LENS, '<link name="lens"><@drake:collision/></link>'),
        ("RD004", 'value="3.5"', 'value="@${arm_mass}"'),
        ("RD004", 'value="3.5"', 'value="@$(arg mass)"'),
        ("RD004", 'link name="lens"', 'link name="@${prefix}lens"'),
        ("RD004", '<child link="wrist"/>', '<child link="@${prefix}wrist"/>'),
        ("RD004", 'name="mount" type="fixed"', 'name="mount" type="@${mounting}"'),
        ("RD004", '<mimic joint="grip"', '<mimic joint="@${prefix}grip"'),
        ("RD004", _LENS, '<@xacro:camera_lens name="lens"/>' + _LENS),
        ("RD005", 'mass value="1.25"/>', 'mass value="1.25"/>@<orgin xyz="0 0 1"/>'),
        ("RD005", '<mass value="1.25"/>', '<mass value="1.25" @unit="kg"/>'),
        ("RD005", '<axis xyz="1 0 0"/>', '<axis xyz="1 0 0" @rpy="0 0 0"/>'),
        ("RD005", _LENS, _LENS + '@<Link name="aperture"/>'),
        ("RD005", _LENS, _LENS + '@<joints name="aperture"/>'),
        ("RD005", '<axis xyz="1 0 0"/>', '<axis xyz="1 0 0"/>@<axis xyz="0 1 0"/>'),
        ("RD005", 'effort="120"', '@efort="120" effort="120"'),
        ("RD006", _WRIST, _WRIST.replace("iyy", '@iyx="0" iyy')),
        ("RD006", _WRIST, _WRIST.replace("iyz", '@izy="0.001" iyz')),
        ("RD007", 'value="3.5"', 'value="@nan"'),
        ("RD007", 'value="3.5"', 'value="@3,5"'),
        ("RD007", 'value="3.5"', 'value="@3.5 kg"'),
        ("RD007", 'value="3.5"', 'value="@"'),
        ("RD007", 'ixx="0.04"', 'ixx="@1e999"'),
        ("RD007", 'ixx="0.04"', 'ixx="@0x1p-3"'),
        ("RD007", 'ixx="0.04"', 'ixx="@0.0_4"'),
        ("RD007", '<axis xyz="0 0 1"/>', '<axis xyz="@0 0"/>'),
        ("RD007", '<axis xyz="0 0 1"/>', "@<axis/>"),
        ("RD007", '<axis xyz="0.6 0 0.8"/>', '<axis xyz="@0.6 0 0.8 0"/>'),
        ("RD007", 'rpy="0.3 0 0"', 'rpy="@0.3; 0; 0"'),
        ("RD007", 'upper="0.05"', 'upper="@inf"'),
        ("RD007", 'effort="40"', 'effort="@40 Nm"'),
        ("RD007", 'offset="0.001"', 'offset="@1 mm"'),
        ("RD007", 'soft_upper_limit="2.75"', 'soft_upper_limit="@max"'),
        ("RD007", 'ixx="0.003"', 'ixx="@3 g"'),
        ("RD007", 'damping="0.4"', 'damping="@low"'),
        ("RD007", 'multiplier="1.1"', 'multiplier="@1.1.0"'),
        ("RD007", 'size="0.3 0.3 0.1"', 'size="@0.3"'),
        ("RD007", '<cylinder radius="0.05" length="0.4"/>', '@<cylinder radius="0.05"/>'),
        ("RD101", '<child link="wrist"/>', '<child link="@wirst"/>'),
        ("RD101", '<parent link="arm"/>', '<parent link="@world"/>'),
        (
            "RD101",
            'joint name="roll" type="continuous">\n    <parent link="arm"/>',
            'joint name="roll" type="continuous">',
        ),
        ("RD101", '<child link="wrist"/>', "@<child/>"),
        (
            "RD102",
            _OPTICS,
            _OPTICS + _OPTICS.replace("optics", "glue").replace("camera", "arm").replace('"lens', '"@lens'),
        ),
        ("RD102", '<child link="right_finger"/>', '<child link="@left_finger"/>'),
        ("RD103", '<parent link="base"/>', '<parent link="@wrist"/>'),
        ("RD103", '<parent link="base"/>', '<parent link="@arm"/>'),
        ("RD104", _OPTICS, ""),
        ("RD104", _LENS, _LENS + '<link name="cover"/>'),
        ("RD105", _LENS, '<link name="lens"/><link name="@lens"/>'),
        ("RD105", 'link name="camera"', 'link name="@wrist"'),
        ("RD106", _OPTICS, _OPTICS.replace('"optics"', '"@mount"')),
        ("RD106", _OPTICS, _OPTICS + _OPTICS.replace('"optics', '"@optics')),
        ("RD107", 'robot name="picker"', "robot"),
        ("RD107", _LENS, "@<link/>"),
        ("RD107", 'joint name="grip_follower"', 'joint name="@"'),
        ("RD108", 'name="shoulder" type="revolute"', 'name="shoulder" type="@hinge"'),
        ("RD108", 'name="shoulder" type="revolute"', 'name="shoulder" type="@Revolute"'),
        ("RD108", 'name="mount" type="fixed"', 'name="mount"'),
        ("RD110", 'joint name="roll"', 'joint name="@2nd_axis"'),
        ("RD110", 'joint name="roll"', 'joint name="@arm/roll"'),
        ("RD110", 'joint name="roll"', 'joint name="@arm"'),
        ("RD201", 'value="3.5"', 'value="@-3.5"'),
        ("RD201", _RIGHT, _RIGHT.replace('"0.12', '"@0')),
        ("RD201", _RIGHT, '<mass value="@0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'),
        ("RD202", f"<inertial>{_RIGHT}</inertial>", ""),
        ("RD202", 'name="optics" type="fixed">', 'name="optics" type="continuous"><axis xyz="0 0 1"/>'),
        ("RD203", '<mass value="1.25"/>', ""),
        ("RD203", '<mass value="1.25"/>', "@<mass/>"),
        ("RD203", _WRIST, ""),
        ("RD203", _WRIST, _WRIST.replace("<inertia ", "@<inertia ").replace(' iyy="0.004"', "")),
        ("RD204", _WRIST, '<inertia ixx="@0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'),
        (
            "RD204",
            _RIGHT,
            '<mass value="0.12"/><inertia ixx="@1e-20" ixy="0" ixz="0" iyy="1e-20" iyz="0" izz="1e-20"/>',
        ),
        ("RD205", '<mass value="0.2"/>', '<mass value="@0"/>'),
        ("RD206", _WRIST, _WRIST.replace('ixx="', 'ixx="@-')),
        ("RD206", _WRIST, _WRIST.replace('iyy="0.004', 'iyy="@0')),
        ("RD206", _WRIST, _WRIST.replace('ixy="0', 'ixy="@0.01')),
        ("RD206", _WRIST, _WRIST.replace('iyz="0', 'iyz="@-0.0038')),
        ("RD206", _WRIST, '<inertia ixx="@-1" ixy="0" ixz="0" iyy="-1" iyz="0" izz="-1"/>'),
        ("RD207", _WRIST, _WRIST.replace("0.0035", "@0.0071")),
        ("RD207", _WRIST, _WRIST.replace("0.004", "@0.04")),
        ("RD207", _WRIST, _WRIST.replace('ixy="0"', 'ixy="0.0029"').replace("0.004", "@0.004")),
        ("RD208", _WRIST, '<inertia ixx="@1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'),
        ("RD208", _WRIST, '<inertia ixx="@0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>'),
        ("RD208", _CAMERA, '<inertia ixx="@3.1e-4" ixy="0" ixz="0" iyy="2.1e-4" iyz="0" izz="2.5e-4"/>'),
        ("RD209", _RIGHT, '<mass value="@1.2e-5"/><inertia ixx="3e-9" ixy="0" ixz="0" iyy="2e-9" iyz="0" izz="2e-9"/>'),
        (
            "RD209",
            _RIGHT,
            '<mass value="0.12"/><inertia ixx="@3e-10" ixy="0" ixz="0" iyy="2e-10" iyz="0" izz="2e-10"/>',
        ),
        ("RD210", 'value="1.25"', 'value="@12500"'),
        ("RD213", _LENS, f'<link name="lens"><inertial><mass value="@0.2"/>{_CAMERA}</inertial></link>'),
        ("RD301", _ARM, '<inertia ixx="0.6" ixy="0.015" ixz="-0.03" iyy="@0.675" iyz="0.0075" izz="0.12"/>'),
        ("RD302", 'xyz="0 0 0.2" rpy="0 0.1 0"', 'xyz="@0 0 0.5" rpy="0 0.1 0"'),
        ("RD302", 'xyz="0 0 0.2" rpy="0 0.1 0"', 'xyz="@0 0 0.9" rpy="0 0.1 0"'),
        ("RD303", _ARM, '<inertia ixx="4e-4" ixy="1e-5" ixz="-2e-5" iyy="@4.5e-4" iyz="5e-6" izz="8e-5"/>'),
        ("RD304", 'value="3.5"', 'value="@90"'),
        ("RD305", _ARM, '<inertia ixx="40000" ixy="1000" ixz="-2000" iyy="@45000" iyz="500" izz="8000"/>'),
        ("RD305", _ARM, '<inertia ixx="4e7" ixy="1e6" ixz="-2e6" iyy="@4.5e7" iyz="5e5" izz="8e6"/>'),
        ("RD305", _ARM, '<inertia ixx="40" ixy="1" ixz="-2" iyy="@45" iyz="0.5" izz="8"/>'),
        ("RD305", _ARM, '<inertia ixx="4e-8" ixy="1e-9" ixz="-2e-9" iyy="@4.5e-8" iyz="5e-10" izz="8e-9"/>'),
        ("RD305", 'xyz="0 0 0.2" rpy="0 0.1 0"', 'xyz="@0 0 7.874" rpy="0 0.1 0"'),
        ("RD501", '<axis xyz="0 0 1"/>', '<axis xyz="@0 0 0"/>'),
        ("RD501", '<axis xyz="-1 0 0"/>', '<axis xyz="@0 -0.0 0e5"/>'),
        ("RD502", '<axis xyz="0 0 1"/>', '<axis xyz="@0 0 2"/>'),
        ("RD502", '<axis xyz="0.6 0 0.8"/>', '<axis xyz="@1 0 1"/>'),
        ("RD502", '<axis xyz="-1 0 0"/>', '<axis xyz="@-1e29 1e29 0"/>'),
        ("RD503", _SHOULDER, _SHOULDER.replace('"-2.9', '"@3')),
        ("RD503", _GRIP, '<limit upper="@-0.04" effort="25" velocity="0.2"/>'),
        ("RD504", _SHOULDER, '@<limit effort="120" velocity="2.5"/>'),
        ("RD504", 'lower="0" upper="0.05"', 'lower="@0.05" upper="0.05"'),
        ("RD504", _SHOULDER, _SHOULDER.replace("2.8", "@1e16")),
        ("RD505", '<limit lower="0" upper="0.05" effort="20" velocity="0.25"/>', ""),
        ("RD505", f'name="shoulder" {_TO_LIMIT}', f'name="@shoulder" {_TO_LIMIT.replace(_SHOULDER, "")}'),
        ("RD506", 'effort="40"', 'effort="@0"'),
        ("RD506", _GRIP, _GRIP.replace('"25"', '"@0.001"')),
        ("RD506", 'effort="40"', 'effort="@-40"'),
        ("RD506", 'effort="40"', 'effort="@1e9"'),
        ("RD506", 'velocity="2.5"', 'velocity="@0"'),
        ("RD506", '<limit effort="40" velocity="3"/>', '@<limit effort="40"/>'),
        ("RD507", 'rpy="0 0 1.5707963267948966"', 'rpy="@0 0 90"'),
        ("RD507", 'rpy="0 0.1 0"', 'rpy="@0 -45 0"'),
        ("RD507", _SHOULDER, _SHOULDER.replace("2.8", "@170")),
        ("RD508", _SOFT, _SOFT.replace("-2.85", "@-3.1")),
        ("RD508", _SOFT, _SOFT.replace("2.75", "@2.81")),
        ("RD508", _SOFT, 'soft_lower_limit="@1" soft_upper_limit="-1"'),
        ("RD509", 'damping="0.4"', 'damping="@-0.4"'),
        ("RD509", 'friction="0.6"', 'friction="@-1e-3"'),
        ("RD510", '<mimic joint="grip"', '<mimic joint="@grp"'),
        ("RD510", '<mimic joint="grip"', "@<mimic"),
        ("RD511", '<mimic joint="grip"', '<mimic joint="@grip_follower"'),
        ("RD511", _GRIP, _GRIP + '<mimic joint="@grip_follower"/>'),
        ("RD512", 'multiplier="1.1"', 'multiplier="@2"'),
        ("RD512", 'multiplier="1.1"', 'multiplier="@-1.1"'),
        ("RD512", 'multiplier="1.1" offset="0.001"', 'multiplier="@1.1" offset="-0.01"'),
        ("RD513", '<limit effort="40"', '<limit lower="@-1" upper="1" effort="40"'),
        ("RD513", '<limit effort="40"', '<limit upper="@6" effort="40"'),
        ("RD514", f'"grip" {_TO_AXIS}', f'"@grip" {_TO_AXIS.replace(_SLIDING, "")}'),
        ("RD515", 'upper="0.05"', 'upper="@50"'),
        ("RD515", _GRIP, _GRIP.replace("0.2", "@200")),
        ("RD516", 'name="grip" type="prismatic"', 'name="grip" type="@revolute"'),
        ("RD601", '<cylinder radius="0.05" length="0.4"/>', "@<mesh/>"),
        ("RD609", _ROD_SEEN, f'{_ROD_SEEN}<collision>@<origin xyz="0 0 0.3"/><geometry>{_ROD}</geometry></collision>'),
        ("RD609", _ROD_SEEN, f"{_ROD_SEEN}@<collision><geometry>{_ROD}</geometry></collision>"),
        ("RD611", _ROD_SEEN, f'{_ROD_SEEN}<collision><geometry>@<box size="0.1 0.1 1e-7"/></geometry></collision>'),
        (
            "RD611",
            _ROD_SEEN,
            f'{_ROD_SEEN}<collision><geometry>@<cylinder radius="0.05" length="9e-6"/></geometry></collision>',
        ),
        ("RD606", 'size="0.3 0.3 0.1"', 'size="@0.3 0 0.1"'),
        ("RD606", 'size="0.3 0.3 0.1"', 'size="@0.3 0.3 -0.1"'),
        ("RD606", 'radius="0.05"', 'radius="@0"'),
        ("RD606", 'length="0.4"', 'length="@-0.4"'),
        ("RD606", _ROD, '<mesh filename="package://a/b.stl" scale="@1 0 1"/>'),
        ("RD606", _ROD, '<mesh filename="package://a/b.stl" scale="@1 -1 1"/>'),
        ("RD601", _ROD, '<mesh filename="@"/>'),
        ("RD601", _ROD, '<mesh filename="@http://localhost/a.stl"/>'),
        ("RD603", _ROD, '<mesh filename="@package://a/../b.stl"/>'),
        ("RD008", _LENS, "@<!-- robodyn: allow RD211 -->" + _LENS),
        ("RD008", _LENS, "@<!-- robodyn: allow RD999 it is so -->" + _LENS),
        ("RD008", _LENS, "@<!-- robodyn: ignore RD211, it is so -->" + _LENS),
        ("RD009", _LENS, "@<!-- robodyn: allow RD207 it is so -->" + _LENS),
        ("RD009", _OPTICS, _OPTICS + "@<!-- robodyn: allow RD501 it is so -->"),
        ("RD205", '<mass value="0.2"/>', '<mass value="@-0e3"/>'),
        ("RD301", _ARM, '<inertia ixx="0.2" ixy="0.001" ixz="-0.002" iyy="@0.245" iyz="0.0005" izz="0.1"/>'),
        ("RD303", _ARM, '<inertia ixx="1e-4" ixy="0" ixz="0" iyy="@1.2e-4" iyz="0" izz="9e-5"/>'),
        ("RD304", 'value="3.5"', 'value="@60"'),
        ("RD701", '<gazebo reference="arm">', '<gazebo reference="@amr">'),
        ("RD701", _OPTICS, f'{_OPTICS}<transmission name="t"><type>x</type><joint name="@rol"/></transmission>'),
        ("RD701", _OPTICS, f'{_OPTICS}<ros2_control name="s" type="system"><joint name="@rol"/></ros2_control>'),
        ("RD007", ' k_velocity="10"', ""),
        ("RD007", '<dynamics damping="0.4" friction="0.6"/>', "@<dynamics/>"),
        ("RD010", '<robot name="picker">', '<robot name="picker" version="@1">'),
        ("RD506", _MOUNT, _MOUNT + '@<limit effort="1"/>'),
        ("RD608", _LENS, '<link name="lens">@<visual/></link>'),
        ("RD608", _LENS, '<link name="lens"><collision>@<geometry/></collision></link>'),
        ("RD621", "</visual>", '<material name="@red"/></visual>'),
        ("RD621", "</visual>", '@<material><color rgba="1 0 0 1"/></material></visual>'),
        ("RD621", _LENS, _LENS + _RED + _RED.replace('"red', '"@red')),
        ("RD622", _LENS, _LENS + _RED.replace('"1 0 0', '"@1 0 -1')),
        ("RD623", _LENS, _LENS + '<material name="red"><texture filename="@package:///red.png"/></material>'),
        ("RD702", _LENS, _LENS + _CONTROL.format("@<state_interface/>")),
        ("RD702", _LENS, _LENS + _CONTROL.format("").replace('"roll', '"@mount')),
        (
            "RD703",
            _LENS,
            _LENS + '<transmission name="t"><type>x</type><joint name="roll"/><joint name="@roll"/></transmission>',
        ),
        (
            "RD704",
            _LENS,
            _LENS + _CONTROL.format(_RANGE),
        ),
        ("RD705", _LENS, _LENS + _CONTROL.format("").replace('roll"', 'roll" mimic="@true"')),
        ("RD701", _LENS, _LENS + "<gazebo>@<plugin/></gazebo>"),
        (
            "RD701",
            _LENS,
            _LENS + '<gazebo><plugin name="p" filename="p.so">@<jointName>rol</jointName></plugin></gazebo>',
        ),
        ("RD801", 'effort="40"', 'effort="@0.03"'),
        ("RD803", 'effort="120"', 'effort="@95000"'),
        ("RD804", 'damping="0.4"', 'damping="@4000"'),
    )
)

_ROLL = '<joint name="roll" type="continuous">'
_ZERO = '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
_TURNING = '<limit effort="40" velocity="3"/>'
SOUND = tuple(
    Defect("", old, new)
    for old, new in (
        (_LENS, _LENS + "<sensor_suite><Link/></sensor_suite><calibration_of_the_factory_as_of_last_year/>"),
        ('robot name="picker"', 'robot name="picker" version="1.0" xmlns="http://ros.org" xmlns:d="u" d:a="1"'),
        ("</visual>", f"</visual>{_ROD_SEEN}{2 * _ROD_SEEN.replace('visual', 'collision')}"),
        (_LENS, '<link name="lens"><contact><lateral_friction value="1"/></contact></link>'),
        (_LENS, f'<link name="lens"><inertial><mass value="0"/>{_ZERO}</inertial></link>'),
        (_MOUNT, _MOUNT + '<axis xyz="0 0 0"/><limit effort="0" velocity="0"/>'),
        (_MOUNT, _MOUNT + '<axis xyz="0 0 2"/>'),
        (_TURNING, '<limit lower="3" upper="-3" effort="40" velocity="3"/>'),
        (_TURNING, '<limit lower="1e17" upper="1e17" effort="40" velocity="3"/>'),
        (_TURNING, ""),
        (
            _TURNING,
            '<limit lower="-4" upper="4" effort="40" velocity="3"/>'
            '<safety_controller soft_upper_limit="5" k_velocity="1"/>',
        ),
        (_TURNING, '<limit lower="-3.14" upper="3.14" effort="40" velocity="3"/>'),
        (_ROLL, '<joint name="roll" type="continuous" dont_collapse="true">'),
        ('upper="0.05"', 'upper="7"'),
        (_GRIP, '<limit upper="0.04" effort="25" velocity="0.2"/>'),
        (_GRIP, '<limit lower="-0.04" effort="25" velocity="0.2"/>'),
        (_SHOULDER, _SHOULDER.replace("2.8", "6.2832")),
        (_SHOULDER, _SHOULDER.replace("2.5", "9999")),
        (_SOFT, 'soft_lower_limit="-2.9"'),
        (_SOFT, ""),
        ('<axis xyz="0.6 0 0.8"/>', '<axis xyz="0.7071 0 0.7071"/>'),
        ('<mimic joint="grip" multiplier="1.1" offset="0.001"/>', '<mimic joint="grip"/>'),
        ('<mimic joint="grip" multiplier="1.1" offset="0.001"/>', '<mimic joint="roll" multiplier="9"/>'),
        (
            '<mimic joint="grip" multiplier="1.1" offset="0.001"/>',
            '<mimic joint="grip" multiplier="-1" offset="0.045"/>',
        ),
        (_WRIST, _WRIST.replace("0.0035", "0.007")),
        (_WRIST, '<inertia ixx="0.01" ixy="0.001" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>'),
        ('ixx="3.1e-4" ixy="0" ixz="0" iyy="2.1e-4"', 'ixx="3e-4" ixy="0" ixz="0" iyy="2e-4"'),
        ('damping="0.4" friction="0.6"', 'damping="0" friction="-0"'),
    )
)
"""What may look like a defect and is none."""

MESSAGES = tuple(
    (Defect(code, old, new), words)
    for code, old, new, words in (
        ("RD001", "<!-- A base, an", "<!-- A base -- an", "two hyphens in a comment, where only its end has them"),
        ("RD005", 'origin xyz="0 0 0.05"', 'origin xzy="0 0 0.05"', "did you mean 'xyz'?"),
        ("RD005", 'limit lower="-2.9"', 'limit min="-2.9"', "did you mean 'lower'?"),
        ("RD107", 'joint name="grip_follower"', 'joint name=""', "<joint> to link 'right_finger' has an empty name"),
        ("RD004", '<mass value="3.5"', '<mass value="${arm_mass}"', "link 'arm': value='${arm_mass}' is left over"),
        ("RD001", '<mass value="3.5"', '<mass\u00a0value="3.5"', "a non-breaking space (U+00A0) inside <inertial>"),
        ("RD003", "<gazebo ref", "<drake:x/><gazebo ref", 'add xmlns:drake="http://drake.mit.edu" to <robot>'),
        (
            "RD005",
            _MOUNT,
            _MOUNT + "<controller_gains/>",
            "Drake reads it as <drake:controller_gains> in the <actuator>",
        ),
        (
            "RD007",
            'value="3.5"',
            'value="3.5\u00a0"',
            "has a no-break space (U+00A0): '3.5\u00a0' (write a plain blank in",
        ),
        (
            "RD007",
            'lower="-2.9"',
            'lower="\u22122.9"',
            "has a minus sign (U+2212): '\u22122.9' (write a hyphen for minus",
        ),
        ("RD006", _WRIST, _WRIST.replace("iyy", 'iyx="0.5" iyy'), "iyx = 0.5 is ignored, and differs from ixy = 0"),
        ("RD006", _WRIST, _WRIST.replace("iyy", 'iyx="0" iyy'), "iyx = 0 is ignored: "),
        ("RD101", '<child link="wrist"/>', '<child link="wirst"/>', "did you mean 'wrist'?"),
        ("RD101", '<child link="wrist"/>', "", "it names no child link"),
        ("RD103", '<parent link="base"/>', '<parent link="arm"/>', "link 'arm' is its parent and its child"),
        ("RD103", '<parent link="base"/>', '<parent link="wrist"/>', "a cycle of 2 links"),
        ("RD105", _LENS, _LENS + _LENS, "the first is in line 35"),
        ("RD107", _LENS, '<link name=""/>', "<link> has an empty name"),
        ("RD107", _LENS, "<link/>", "<link> has no name"),
        ("RD110", _ROLL, _ROLL.replace("roll", "arm::roll"), "SDF keeps ::"),
        ("RD110", _ROLL, _ROLL.replace("roll", "__roll__"), "SDF keeps ::"),
        ("RD110", _ROLL, _ROLL.replace("roll", "arm/roll"), "take / for a path"),
        ("RD110", _ROLL, _ROLL.replace("roll", "2nd"), "does not begin with a digit"),
        ("RD110", _ROLL, _ROLL.replace("roll", "arm-roll"), "USD takes letters"),
        ("RD110", _ROLL, _ROLL.replace("roll", "arm"), "different names for a link and a joint"),
        ("RD202", 'name="optics" type="fixed"', 'name="optics" type="floating"', "joint 'optics' moves it, and it"),
        ("RD207", _WRIST, _WRIST.replace("0.0035", "0.014"), "the two smaller add up to 0.007, 50 % less"),
        ("RD503", _GRIP, '<limit upper="-0.04" effort="25" velocity="0.2"/>', "(lower is absent, and so 0)"),
        ("RD503", _SHOULDER, _SHOULDER.replace("-2.9", "3"), "lower 3 is greater than upper 2.8: there"),
        ("RD504", _SHOULDER, '<limit effort="120" velocity="2.5"/>', "neither lower nor upper"),
        ("RD504", _SHOULDER, _SHOULDER.replace('lower="-2.9" upper="2.8"', 'lower="0"'), "are both 0"),
        ("RD504", _SHOULDER, _SHOULDER.replace("-2.9", "-1e5"), "lower is -100000, which limits nothing"),
        ("RD505", _SHOULDER, "", "or make it continuous"),
        ("RD506", _TURNING, _TURNING.replace("40", "1e9"), "effort is 1e+09, a stand-in"),
        ("RD506", _TURNING, _TURNING.replace("40", "-1"), "effort is -1, not positive"),
        ("RD511", '<mimic joint="grip"', '<mimic joint="grip_follower"', "it mimics itself"),
        ("RD511", _GRIP, _GRIP + '<mimic joint="grip_follower"/>', "in a cycle: 'grip"),
    )
)
"""What a finding says."""

MEASURED = tuple(
    (Defect(code, old, new), measured, bound)
    for code, old, new, measured, bound in (
        ("RD006", _WRIST, _WRIST.replace("iyy", 'iyx="0.5" iyy'), 0.5, 0.0),
        ("RD104", _OPTICS, "", 2, 1),
        ("RD201", 'value="3.5"', 'value="-3.5"', -3.5, 0.0),
        ("RD202", 'name="optics" type="fixed"', 'name="optics" type="floating"', 0.0, None),
        ("RD204", _WRIST, _ZERO, 0.0, None),
        ("RD205", '<mass value="0.2"/>', '<mass value="0"/>', 4e-4 + 5e-4 + 6e-4, 0.0),
        ("RD206", _WRIST, _WRIST.replace('iyy="0.004', 'iyy="0'), 0.0, 1e-9 * 0.0035),
        ("RD207", _WRIST, _WRIST.replace("0.0035", "0.014"), 0.014, 0.003 + 0.004),
        ("RD210", 'value="3.5"', 'value="80000"', 10000.0, 1000.0),
        ("RD501", '<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>', 0.0, 1.0),
        ("RD502", '<axis xyz="0 0 1"/>', '<axis xyz="0 0 2"/>', 2.0, 1.0),
        ("RD503", _SHOULDER, _SHOULDER.replace("-2.9", "3"), 3.0, 2.8),
        ("RD504", _SHOULDER, _SHOULDER.replace("-2.9", "2.8"), 2.8, None),
        ("RD506", _TURNING, _TURNING.replace("40", "-1"), -1.0, 0.0),
        ("RD506", _TURNING, _TURNING.replace("40", "1e9"), 1e9, 1e5),
        ("RD507", 'rpy="0 0.1 0"', 'rpy="0 -45 0"', 45.0, 2 * pi),
        ("RD508", _SOFT, _SOFT.replace("2.75", "2.875"), 2.875, 2.8),
        ("RD509", 'damping="0.4"', 'damping="-0.4"', -0.4, 0.0),
        ("RD512", 'multiplier="1.1" offset="0.001"', 'multiplier="2"', 2 * 0.04 - 0.05, 1e-3),
    )
)
"""The numbers of a finding."""
