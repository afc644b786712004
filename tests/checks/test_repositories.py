"""A folder of xacro files and URDFs: robots are judged once, parts where they are included, meshes where they lie."""

from __future__ import annotations

import json
import shutil
import warnings
from pathlib import Path

import pytest
from helpers.clean_arm import IDENTITY
from helpers.command_line import run
from helpers.mesh_samples import binary_stl

from robodyn.checks.check import Checked, Options, check_tasks, tasks_for
from robodyn.checks.sources import includers
from robodyn.errors import RobodynWarning
from robodyn.robot.urdf.xacro import expanded

HEAD = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
MASS = f'<inertial><mass value="2"/>{IDENTITY}</inertial>'
MESH = '<visual><geometry><mesh filename="./meshes/part.stl"/></geometry></visual>'
TETRAHEDRON = [[[0, 0, 0], [0, 1, 0], [1, 0, 0]], [[0, 0, 0], [1, 0, 0], [0, 0, 1]]]
TETRAHEDRON += [[[0, 0, 0], [0, 0, 1], [0, 1, 0]], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]]


def joint(name: str, parent: str, child: str) -> str:
    limits = '<limit lower="-1" upper="1" effort="9" velocity="9"/>'
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="revolute">{ends}<axis xyz="0 0 1"/>{limits}</joint>'


FILES = {
    "main.xacro": f'<link name="base"/><link name="upper">{MASS}{MESH}</link>{joint("shoulder", "base", "upper")}',
    "hand.xacro": f'<link name="hand">{MASS}</link>{joint("wrist", "upper", "hand").replace("0 0 1", "0 0 2")}',
    "tool.xacro": f'<link name="tool">{MASS}</link>{joint("tool_joint", "upper", "tool")}',
    "bare.urdf.xacro": '<xacro:include filename="main.xacro"/>',
    "handy.urdf.xacro": '<xacro:include filename="main.xacro"/><xacro:include filename="parts/hand.xacro"/>',
    "handier.urdf.xacro": '<xacro:include filename="$(find arm)/xacro/handy.urdf.xacro"/>',
    "other.urdf.xacro": '<xacro:include filename="main.xacro"/><xacro:include filename="parts/hand.xacro"/>',
}


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "arm"
    (folder / "xacro" / "parts").mkdir(parents=True)
    (folder / "meshes").mkdir()
    (folder / "package.xml").write_text("<package><name>arm</name></package>")
    (folder / "meshes" / "part.stl").write_bytes(binary_stl(TETRAHEDRON))
    for name, body in FILES.items():
        file = folder / "xacro" / ("parts" if name in ("hand.xacro", "tool.xacro") else ".") / name
        file.write_text(f"{HEAD}{body}</robot>")
    return folder


RULES = ("RD1", "RD50", "RD6")


def checked(*sources: Path, including: bool = False) -> tuple[Checked, list[str]]:
    """What is found, and the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RobodynWarning)
        found = check_tasks(tasks_for(list(map(str, sources)), Options(RULES, including=including)))
    return found, [str(one.message) for one in caught]


def names(found: Checked) -> list[str]:
    return sorted(Path(file).name for file in found.files)


def test_of_a_folder_the_robots_are_judged_and_parts_where_they_are_included(package: Path) -> None:
    """One that no file includes, and that hangs on a link of another file, is a part, too."""
    found, said = checked(package)
    assert names(found) == ["bare.urdf.xacro", "handier.urdf.xacro", "other.urdf.xacro"]
    assert found.unread == ()
    assert any("3 xacro files are parts of others" in line and "hand.xacro" in line for line in said)
    assert any("tool.xacro: it is a part that hangs on 'upper' of main.xacro" in line for line in said)
    assert {one.code for one in found.findings} == {"RD502"}


def test_a_finding_in_a_file_that_robots_share_is_one_with_their_names(package: Path) -> None:
    said = run("check", str(package), "--select", "RD50").out
    assert said.count("RD502") == 1
    assert "  in: " in said
    (finding,) = json.loads(run("check", str(package), "--select", "RD50", "--format", "json").out)["findings"]
    assert Path(finding["file"]).name == "hand.xacro"
    assert [Path(robot).name for robot in finding["robots"]] == ["handier.urdf.xacro", "other.urdf.xacro"]


def test_a_joint_whose_parent_no_file_has_is_an_error(package: Path) -> None:
    tool = package / "xacro" / "parts" / "tool.xacro"
    tool.write_text(tool.read_text().replace('"upper"', '"uper"'))
    found, _ = checked(package)
    assert "RD101" in {one.code for one in found.findings if one.file == str(tool)}


def test_a_urdf_that_a_xacro_file_expands_to_is_judged_there(package: Path) -> None:
    """One that differs by a digit is a robot of its own."""
    text = expanded(str(package / "xacro" / "bare.urdf.xacro")).text
    (package / "bare.urdf").write_bytes(text)
    found, said = checked(package)
    assert "bare.urdf" not in names(found)
    assert any("1 URDF is what a xacro file expands to, and judged there: " in line for line in said)
    (package / "bare.urdf").write_bytes(text.replace(b'value="2"', b'value="2.5"', 1))
    found, said = checked(package)
    assert "bare.urdf" in names(found)
    assert not any("expands to" in line for line in said)


def test_of_a_changed_part_the_hook_checks_the_robots_that_include_it(package: Path) -> None:
    """Also of one that is a robot by itself. The hook calls it so."""
    main = package / "xacro" / "main.xacro"
    assert names(checked(main)[0]) == ["main.xacro"]
    found = checked(main, including=True)[0]
    assert names(found) == ["bare.urdf.xacro", "handier.urdf.xacro", "other.urdf.xacro"]
    assert names(checked(package / "xacro" / "bare.urdf.xacro", including=True)[0]) == ["bare.urdf.xacro"]
    hooks = (Path(__file__).parents[2] / ".pre-commit-hooks.yaml").read_text()
    assert "entry: robodyn check --including\n" in hooks


def test_meshes_are_relative_to_where_the_expansion_is_written(package: Path, tmp_path: Path) -> None:
    """Of xacro that is not known: the package and the folders above are tried, or the one that is said."""
    robot = package / "xacro" / "bare.urdf.xacro"
    assert checked(robot)[0].findings == ()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    shutil.move(package / "meshes", elsewhere / "meshes")
    assert [one.code for one in checked(robot)[0].findings] == ["RD601"]
    assert run("check", str(robot), "--select", "RD6", "--expanded-to", str(elsewhere)).status == 0


def test_packages_are_those_of_the_file_wherever_it_is_expanded_to(package: Path, tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    main = package / "xacro" / "main.xacro"
    main.write_text(main.read_text().replace("./meshes/", "package://arm/meshes/"))
    robot = str(package / "xacro" / "bare.urdf.xacro")
    assert run("check", robot, "--select", "RD6", "--expanded-to", str(tmp_path / "elsewhere")).status == 0


def test_a_urdf_names_meshes_relative_to_itself(package: Path) -> None:
    """What is found from the package or a folder above only, most programs do not find."""
    (package / "urdf").mkdir()
    urdf = package / "urdf" / "bare.urdf"
    urdf.write_bytes(expanded(str(package / "xacro" / "bare.urdf.xacro")).text)
    (finding,) = checked(urdf)[0].findings
    assert (finding.code, finding.severity.value) == ("RD603", "warning")
    assert "is not relative to this file's folder, but to '..'" in finding.message


def test_a_folder_that_is_named_may_be_read(package: Path) -> None:
    """Without a package.xml the call says what belongs together."""
    (package / "package.xml").unlink()
    found, _ = checked(package)
    assert found.unread == ()
    assert "handier.urdf.xacro" in names(found)


@pytest.mark.parametrize(
    ("written", "includes"),
    [
        ("b.xacro", True),
        ("./b.xacro", True),
        ("c.xacro", False),
        ("$(find p)/b.xacro", True),
        ("${folder}/b.xacro", True),
        ("${name}.xacro", False),
        ("../b.xacro", False),
    ],
)
def test_which_files_include_which(tmp_path: Path, written: str, includes: bool) -> None:
    a, b = tmp_path / "a.xacro", tmp_path / "b.xacro"
    a.write_text(f'{HEAD}<xacro:include\n  filename="{written}"/></robot>')
    b.write_text(f'{HEAD}<xacro:include filename="b.xacro"/></robot>')
    assert includers([a, b]) == {a: set(), b: {a} if includes else set()}


def test_tags_without_end_take_linear_time(tmp_path: Path) -> None:
    """Squared, half a million of them would take hours."""
    file = tmp_path / "a.xacro"
    file.write_text("<xacro:include " * 500_000)
    assert includers([file]) == {file: set()}


def test_texts_without_a_file_are_judged_each(package: Path) -> None:
    """Beside xacro files, too."""
    wrong = b'<robot name="r"><link name="a"/><link name="a"/></robot>'
    found = check_tasks(tasks_for([wrong, wrong.replace(b'"a"', b'"b"'), str(package / "xacro" / "bare.urdf.xacro")]))
    said = [one.message.split("'")[1] for each in found.findings for one in each.places if one.code == "RD105"]
    assert said == ["a", "b"]
