"""xacro files are expanded before they are checked; what cannot be expanded is one line."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from helpers.clean_arm import IDENTITY, arm
from helpers.command_line import run

import robodyn
from robodyn.checks.check import Options, check_tasks, fix_task, tasks_for
from robodyn.checks.rule import Finding
from robodyn.errors import InputError, RobodynWarning
from robodyn.report.renderers.findings import check_github, check_junit
from robodyn.robot.urdf.xacro import expanded
from robodyn.support import children

HEAD = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
MACRO = f"""{HEAD}
  <xacro:macro name="part" params="name">
    <link name="${{name}}"><inertial><mass value="${{2 * kilo}}"/>{IDENTITY}</inertial></link>
  </xacro:macro>
</robot>
"""
ROBOT = f"""<?xml version="1.0"?>
{HEAD}
  <xacro:arg name="kilo" default="1"/>
  <xacro:property name="kilo" value="$(arg kilo)"/>
  <xacro:include filename="INCLUDE"/>
  <xacro:part name="upper"/>
</robot>
"""


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "part.xacro").write_text(MACRO)
    return written(tmp_path, "parts/part.xacro")


def written(folder: Path, include: str) -> Path:
    path = folder / "arm.urdf.xacro"
    path.write_text(ROBOT.replace("INCLUDE", include))
    return path


def findings(path: Path, options: Options = Options()) -> tuple[Finding, ...]:  # noqa: B008
    checked = check_tasks(tasks_for([str(path)], options))
    for unread in checked.unread:
        raise unread.error
    return checked.findings


def test_places_are_those_of_the_file_that_made_it(
    robot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The tensor is written in a macro that another file includes; its mass is an expression there. Reports of suites
    and annotations tell the description, too."""
    monkeypatch.chdir(tmp_path)
    checked = check_tasks(tasks_for([robot.name]))
    (finding,) = checked.findings
    macro = Path("parts") / "part.xacro"
    assert (finding.code, finding.file) == ("RD208", str(macro))
    line = macro.read_text().splitlines()[finding.line - 1]
    assert line[finding.column - 1 :].startswith('1" ixy="0"')
    assert macro.read_bytes()[finding.start : finding.end] == b"1"
    assert finding.excerpt.text[finding.excerpt.start :].startswith('1" ixy="0"')
    suite = ElementTree.fromstring(check_junit(checked)).findall("testsuite")
    assert [one.get("name") for one in suite] == [robot.name]
    assert [case.get("classname") for case in suite[0].findall("testcase")] == [str(macro)]
    (line,) = check_github(checked.findings).splitlines()
    assert f"file={macro}," in line
    assert f"(in {robot.name})" in line
    assert "RD201" in {finding.code for finding in robodyn.check(robot, xacro_args={"kilo": "-1"})}


def test_places_in_a_block_and_in_an_expression(robot: Path) -> None:
    """What is given to a macro stands where it is given; an attribute is found though its value is an expression."""
    text = ROBOT.replace("INCLUDE", "parts/part.xacro").replace(
        "</robot>",
        """  <xacro:macro name="hinge" params="child *limit">
    <joint name="${child}_hinge" type="revolute"><parent link="base"/><child link="${child}"/>
      <axis xyz="0 ${1 + 1} 0"/><xacro:insert_block name="limit"/></joint>
  </xacro:macro>
  <link name="base"/>
  <xacro:hinge child="upper"><limit lower="1" upper="-1" effort="9" velocity="9"/></xacro:hinge>
</robot>""",
    )
    robot.write_text(text)
    lines = text.splitlines()
    places = {one.code: lines[one.line - 1][one.column - 1 :] for one in findings(robot) if one.file == str(robot)}
    assert places["RD502"].startswith("0 ${1 + 1} 0")
    assert places["RD503"].startswith('1" upper="-1"')


@pytest.mark.parametrize("needs", ["", '<xacro:include filename="$(arg folder)/none.xacro"/>'])
def test_a_file_that_only_defines_parts_is_skipped(robot: Path, needs: str) -> None:
    """Also one that cannot be expanded by itself."""
    (robot.parent / "lids").mkdir()
    part = str(robot.parent / "lids" / "lid.xacro")
    Path(part).write_text(MACRO.replace(HEAD, HEAD + needs))
    with pytest.warns(RobodynWarning, match=r"lid\.xacro: it defines parts and describes no robot .*: skipped"):
        checked = check_tasks(tasks_for([part, str(robot)]))
    assert (checked.files, checked.unread) == ((str(robot),), ())


def test_of_changed_macros_the_descriptions_that_include_them_are_checked(robot: Path) -> None:
    """Also through another file of macros; each once. In a folder without .urdf all that describe a robot are."""
    parts = robot.parent / "parts"
    assert tasks_for([str(parts / "part.xacro")])[0].name == str(robot)
    with pytest.warns(RobodynWarning, match="1 xacro file is part of others, judged where they are included"):
        assert check_tasks(tasks_for([str(robot.parent)])).files == (str(robot),)
    (parts / "screw.xacro").write_text(MACRO.replace('"part"', '"screw"'))
    (parts / "part.xacro").write_text(MACRO.replace(HEAD, f'{HEAD}<xacro:include filename="screw.xacro"/>'))
    (parts / "crew.xacro").write_text(MACRO.replace('"part"', '"crew"'))
    given = [str(parts / "screw.xacro"), str(parts / "part.xacro"), str(robot)]
    assert [task.name for task in tasks_for(given)] == [str(robot)]
    with pytest.warns(RobodynWarning, match=r"crew\.xacro: it defines parts and describes no robot .*: skipped"):
        assert tasks_for([str(parts / "crew.xacro")]) == ()
    (robot.parent / "arm.urdf").write_text(arm())
    with pytest.warns(RobodynWarning, match="3 xacro files are parts of others"):
        tasks = tasks_for([str(robot.parent)])
    assert [task.name for task in tasks] == [str(robot.parent / "arm.urdf"), str(robot)]


def test_packages_are_found_on_the_package_path_and_above_the_file(robot: Path, tmp_path: Path) -> None:
    package = tmp_path / "share" / "arm_parts"
    package.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>arm_parts</name></package>")
    (package / "part.xacro").write_text(MACRO)
    written(tmp_path, "$(find arm_parts)/part.xacro")
    with pytest.raises(InputError, match=r"xacro cannot expand it: .*arm_parts"):
        findings(robot)
    assert len(findings(robot, Options(package_path=(str(tmp_path / "share"),)))) == 1
    assert len(findings(written(package, "$(find arm_parts)/part.xacro"))) == 1
    assert tasks_for([str(package / "part.xacro")])[0].name == str(package / "arm.urdf.xacro")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("", "no element found"),
        (f"{HEAD}<xacro:part/></robot>", "unknown macro name: xacro:part"),
        (f"{HEAD}<link name='${{nothing}}'/></robot>", "name 'nothing' is not defined"),
        (f"{HEAD}<xacro:include filename='none.xacro'/></robot>", "No such file or directory"),
        (f"{HEAD}<link name='${{1/0}}'/></robot>", "division by zero"),
    ],
)
def test_what_cannot_be_expanded(robot: Path, text: str, line: str, capfd: pytest.CaptureFixture[str]) -> None:
    robot.write_text(text)
    with pytest.raises(InputError) as error:
        findings(robot)
    place = f"{robot}:1" if "{" in text or "include" in text else f"{robot}"
    assert str(error.value).startswith(f"{place}: xacro cannot expand it: ")
    assert line in str(error.value)
    assert capfd.readouterr() == ("", "")


def test_without_a_file_without_xacrodoc_and_where_the_process_dies(
    robot: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(InputError, match=r"none\.xacro: there is no such file"):
        findings(robot.parent / "none.xacro")
    start = children.start_python
    died = "helpers.processed:leave_at_once"
    monkeypatch.setattr(children, "start_python", lambda _, **how: start(died, **how))
    with pytest.raises(InputError, match="xacro cannot expand it: its process ended with status 7"):
        expanded(str(robot))
    monkeypatch.setitem(sys.modules, "xacrodoc", None)
    with pytest.raises(InputError) as error:
        expanded(str(robot))
    assert str(error.value).startswith(f'{robot}: xacro files need xacrodoc (pip install "robodyn[xacro]"')


def test_expanded_text_is_not_fixed(tmp_path: Path) -> None:
    path = tmp_path / "arm.xacro"
    path.write_text(arm(shoulder="0 2 0").replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" '))
    assert [finding.code for finding in findings(path)] == ["RD502"]
    (task,) = tasks_for([str(path)])
    result = fix_task(task)
    assert (result.after, result.made) == (result.before, ())
    assert result.before == path.read_bytes()


def test_trust_is_of_files_that_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not of those in a folder, of a pattern, or that include macros which are named."""
    path = tmp_path / "a.xacro"
    path.write_text(f"{HEAD}<link name=\"${{(lambda: 'a')()}}\"/></robot>")
    trusting = Options(trust_xacro=True)
    assert tasks_for([str(path)], trusting)[0].options.trust_xacro
    assert list(robodyn.load(path, trust_xacro=True).links) == ["a"]
    for others in (str(tmp_path), str(tmp_path / "*.xacro")):
        assert not tasks_for([others], trusting)[0].options.trust_xacro
    with pytest.raises(InputError, match=r"a\.xacro:1: a lambda in an expression is refused"):
        robodyn.check(str(tmp_path), trust_xacro=True)
    monkeypatch.chdir(tmp_path)
    assert "a.xacro:1: a lambda in an expression is refused (--trust-xacro" in run("info", "a.xacro").err
    assert run("check", "a.xacro", "--trust-xacro").status == 0
    assert "--trust-xacro goes with the names of files" in run("check", ".", "--trust-xacro").err


def test_settings_of_a_project_do_not_widen_what_is_read(robot: Path, tmp_path: Path) -> None:
    """They come with the files: of their package paths outside of the project, only packages are read."""
    project = tmp_path / "project"
    (project / "mine").mkdir(parents=True)
    for folder in (tmp_path / "outside" / "arm_parts", tmp_path / "elsewhere"):
        folder.mkdir(parents=True)
        (folder / "part.xacro").write_text(MACRO)
    path = written(project / "mine", "$(find arm_parts)/part.xacro")
    (project / "robodyn.toml").write_text('[tool.robodyn.check]\npackage-path = ["..", "/", "../outside"]\n')
    with pytest.raises(InputError, match="the package 'arm_parts' is not found"):
        findings(path)
    (tmp_path / "outside" / "arm_parts" / "package.xml").write_text("<package><name>arm_parts</name></package>")
    assert len(findings(path)) == 1
    with pytest.raises(InputError, match="outside of the packages that were found, is refused"):
        findings(written(project / "mine", "../../elsewhere/part.xacro"))


@pytest.mark.skipif(os.name != "posix", reason="needs links")
def test_links_in_a_folder_lead_neither_out_nor_around(robot: Path, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    (folder / "inner").mkdir(parents=True)
    (folder / "inner" / "b.urdf").write_text(arm())
    (folder / ".hidden").mkdir()
    (folder / ".hidden" / "c.urdf").write_text(arm())
    (folder / "out").symlink_to(tmp_path)
    for name in ("x", "y"):
        (folder / name).symlink_to(folder)
    assert [task.name for task in tasks_for([str(folder)])] == [str(folder / "inner" / "b.urdf")]
