"""Names that transmissions, extensions and the SRDF use."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.example_robots import path_of

from robodyn.checks.check import check_one
from robodyn.checks.examples import arm
from robodyn.checks.rule import Finding, Severity


def found(source: Path | str) -> list[Finding]:
    given = source.encode() if isinstance(source, str) else str(source)
    return [one for one in check_one(given) if one.code == "RD701"]


@pytest.mark.parametrize(
    ("more", "names"),
    [
        ('<gazebo reference="uper"/>', ["uper"]),
        ('<gazebo reference="upper"/><gazebo reference="shoulder"/><gazebo/>', []),
        ('<ros2_control name="c" type="system"><joint name="elbow"/><sensor name="s"/></ros2_control>', ["elbow"]),
        ('<transmission name="t"><joint name="a"/><joint name="b"/></transmission>', ["a", "b"]),
        ('<transmission name="t"><joint/></transmission>', []),
    ],
)
def test_extensions(more: str, names: list[str]) -> None:
    text = arm(more=more)
    places = [text.encode()[one.start : one.end].decode() for one in found(text)]
    assert places == names
    assert names != ["uper"] or found(text)[0].remedy == "did you mean 'upper'?"


SRDF = """<robot name="arm">
  <group name="all"><chain base_link="base" tip_link="{tip}"/><joint name="shoulder"/></group>
  <group_state name="home" group="all"><joint name="{joint}" value="0"/></group_state>
  <virtual_joint name="free" type="floating" parent_frame="odom" child_link="base"/>
  <passive_joint name="free"/>
  <end_effector name="e" parent_link="upper" group="all"/>
  <disable_collisions link1="base" link2="{other}" reason="Never"/>
</robot>"""


def robot(tmp_path: Path, srdf: str, place: str = "arm.srdf") -> Path:
    file = tmp_path / "urdf" / "arm.urdf"
    for path, text in ((file, arm()), (tmp_path / "urdf" / place, srdf)):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.resolve().parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return file


@pytest.mark.parametrize("place", ["arm.srdf", "config/arm.srdf", "../srdf/arm.srdf", "../config/arm.srdf"])
def test_srdf_of_the_same_name(tmp_path: Path, place: str) -> None:
    good = {"tip": "upper", "joint": "shoulder", "other": "upper"}
    assert not found(robot(tmp_path, SRDF.format(**good), place))
    bad = found(robot(tmp_path, SRDF.format(tip="uper", joint="root_joint", other="tool"), place))
    assert [(one.severity, one.line, Path(one.file).name) for one in bad] == [
        (Severity.ERROR, 2, "arm.srdf"),
        (Severity.WARNING, 7, "arm.srdf"),
    ]


def test_srdf_of_another_name_is_one_warning_if_it_is_for_this_robot(tmp_path: Path) -> None:
    text = SRDF.format(tip="uper", joint="elbow", other="tool")
    file = robot(tmp_path, text, "other.srdf")
    (one,) = found(file)
    assert one.severity is Severity.WARNING
    assert "2 more names" in one.message
    assert not found(robot(tmp_path, text.replace('name="arm"', 'name="leg"'), "other.srdf"))


def test_a_broken_srdf_is_no_fault_of_the_robot(tmp_path: Path) -> None:
    assert not found(robot(tmp_path, "<robot name='arm'><group>"))


def test_published_robots() -> None:
    assert not any(found(path_of(stem)) for stem in ("solo12", "go2", "kinova", "panda"))
    assert {one.line for one in found(path_of("pr2"))} == {1188, 1191}
