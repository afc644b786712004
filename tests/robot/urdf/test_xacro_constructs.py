"""What xacro files of real packages use: expanded to the byte as xacro itself does, which a trusted file is left to."""

from __future__ import annotations

import sys
from importlib.metadata import distributions
from pathlib import Path

import pytest

from robodyn.errors import InputError
from robodyn.robot.urdf.xacro import expanded

HEAD = '<?xml version="1.0"?>\n<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
LIMITS = """joint_limits:
  shoulder: {has_limits: true, lower: !degrees -180, upper: !degrees "90 + 2 * 45", effort: 330.0}
  elbow: {has_limits: false, lower: !radians -pi, upper: 3, effort: 150}
masses: [1.5, 2, 0.25]
base: &base {mass: 4.0, origin: {xyz: 0 0 0.1}}
tool: {<<: *base, mass: 0.5, length: !millimeters 120}
names: [tool0, flange]
"""
PARTS = """  <xacro:property name="thin" value="${0.1 * 2**-2}"/>
  <xacro:macro name="box" params="m x:=1 y:=${thin} z:=^|${thin} name *origin **extra">
    <link name="${name}"><inertial><xacro:insert_block name="origin"/>
      <mass value="${m}"/><inertia ixx="${m / 12 * (y * y + z * z)}" ixy="0" ixz="0" iyy="${m*(x*x+z*z)/12}" iyz="0"
        izz="${'%0.6f' % (m/12*(x**2 + y**2))}"/></inertial><xacro:insert_block name="extra"/></link>
  </xacro:macro>
  <xacro:macro name="chain" params="n prefix parent:=^ length">
    <xacro:if value="${n > 0}">
      <link name="${prefix}${n}"/>
      <joint name="${prefix}joint_${n}" type="revolute"><parent link="${parent}"/><child link="${prefix}${n}"/>
        <origin xyz="0 0 ${length * cos(radians(n))}" rpy="0 ${pi / n} ${-math.atan2(1, n)}"/></joint>
      <xacro:chain n="${n - 1}" prefix="${prefix}" parent="${prefix}${n}" length="${length}"/>
    </xacro:if>
  </xacro:macro>
"""
ROBOT = """  <xacro:arg name="side" default="left"/>
  <xacro:arg name="count" default="3"/>
  <xacro:arg name="limits_file" default="$(find arm)/config/limits.yaml"/>
  <xacro:property name="side" value="$(arg side)"/>
  <xacro:include filename="$(find arm)/urdf/parts.xacro"/>
  <xacro:include filename="$(find other)/urdf/*.xacro" ns="other"/>
  <xacro:include filename="not_there.xacro" optional="true"/>
  <xacro:property name="config" value="${xacro.load_yaml('$(arg limits_file)')}"/>
  <xacro:property name="limits" value="${config['joint_limits']}"/>
  <xacro:property name="reflect" value="${1 if side == 'left' else -1}"/>
  <xacro:property name="sizes" value="${dict(base=0.3, arm=[0.1, 0.2, 0.4])}"/>
  <xacro:property name="parent" value="world"/>
  <xacro:property name="lazy" value="${later + 1}"/>
  <xacro:property name="later" value="2"/>
  <xacro:property name="text" value="${' '.join([str(round(m * 2, 3)) for m in config.masses])}"/>
  <xacro:property name="names" value="${[n.upper() for n in config.names if 'tool' in n]}"/>
  <xacro:property name="given" default="${later}"/>
  <link name="world" count="${len(sizes['arm'])} ${lazy} ${text} ${names[0]} ${given} $(eval count + 1) $$(dirname)"/>
  <xacro:box m="${config.tool.mass}" name="${side}_box" x="0.2">
    <origin xyz="${config.tool.origin.xyz}" rpy="0 0 ${reflect * radians(90)}"/>
    <extra><visual name="${side[0]}"/><!-- kept --></extra>
  </xacro:box>
  <xacro:chain n="$(arg count)" prefix="${side}_" length="${config.tool.length}"/>
  <xacro:macro name="limit" params="joint">
    <xacro:property name="own" value="${limits[joint]}"/>
    <xacro:if value="${own['has_limits']}"><limit lower="${own['lower']}" upper="${own.upper}"
      effort="${own.effort}" velocity="${max(1.0, 2)}"/></xacro:if>
    <xacro:unless value="${own['has_limits']}"><limit effort="${float(own.effort)}" velocity="${inf}"/></xacro:unless>
    <xacro:property name="last" value="${joint}" scope="parent"/>
  </xacro:macro>
  <xacro:limit joint="shoulder"/><xacro:limit joint="elbow"/>
  <last name="${last}"/>
  <xacro:call macro="other.plate" r="${other.radius}"/>
  <xacro:element xacro:name="${'sensor' if sizes['base'] else 'none'}"><xacro:attribute name="id" value="n${7 // 2}"/>
  </xacro:element>
  <!-- xacro:eval-comments --><!-- ${side} is $(arg side) -->
  <xacro:macro name="each" params="items">
    <xacro:if value="${items}"><item v="${items[0]}"/><xacro:each items="${items[1:]}"/></xacro:if>
  </xacro:macro>
  <xacro:each items="${sizes['arm'] + list(range(2)) + sorted(dict(b=1, a=2).keys())}"/>
  <math v="${sqrt(2)} ${degrees(pi)} ${e} ${tau} ${abs(-1) if False else python.abs(-2)} ${int(2.9)} ${str(1.0)}"/>
  <python v="${python.sum([1, 2])}"/>
  <warned v="${xacro.warning('careful')}${xacro.message('well')}${xacro.arg('side')}${xacro.tokenize('a, b;c')}"/>
  <dotted v="${xacro.dotify(dict(a=dict(b=1))).a.b} ${load_yaml('../config/limits.yaml').masses}"/>
</robot>
"""
OTHER = """  <xacro:property name="radius" value="0.25"/>
  <xacro:macro name="plate" params="r"><plate area="${pi * r ** 2}" of="${radius}"/></xacro:macro>
"""


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    files = {
        "arm/package.xml": "<package><name>arm</name></package>",
        "arm/config/limits.yaml": LIMITS,
        "arm/urdf/parts.xacro": HEAD + PARTS + "</robot>",
        "arm/urdf/arm.urdf.xacro": HEAD + ROBOT,
        "other/package.xml": "<package><name>other</name></package>",
        "other/urdf/plate.xacro": HEAD + OTHER + "</robot>",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path / "arm" / "urdf" / "arm.urdf.xacro"


def same(path: Path, **args: str) -> bytes:
    """The text of a file, which is that of xacro."""
    text = expanded(str(path), args=args).text
    assert text == expanded(str(path), args=args, trusted=True).text
    return text


def test_a_package_with_everything(robot: Path) -> None:
    text = same(robot)
    for part in (b'name="left_3"', b'lower="-3.141592653589793"', b'id="n3"', b'area="0.19634'):
        assert part in text
    assert b"right_1" in same(robot, side="right", count="1")
    assert same(robot, limits_file=str(robot.parents[1] / "config" / "limits.yaml")) == text


def test_long_chains_of_properties_and_macros(robot: Path) -> None:
    """Each needs the one before: a hundred deep, as xacro itself manages."""
    chain = "".join(f'<xacro:property name="p{k + 1}" value="${{p{k} + 1}}"/>\n' for k in range(90))
    robot.write_text(f'{HEAD}{chain}<xacro:property name="p0" value="1"/><link name="a${{p90}}"/></robot>')
    assert b'name="a91"' in same(robot)


INSTALLED = sorted({path for folder in sys.path for path in Path(folder).glob("cmeel.prefix/**/*.xacro")})


@pytest.mark.skipif(not any(one.name == "example-robot-data" for one in distributions()), reason="needs robots")
def test_files_of_installed_packages(robot: Path) -> None:
    found = 0
    for path in INSTALLED:
        try:
            expected = expanded(str(path), trusted=True).text
        except InputError:
            with pytest.raises(InputError, match=r"^(?!.*is refused)"):
                expanded(str(path))
        else:
            assert expanded(str(path)).text == expected
            found += 1
    assert found
