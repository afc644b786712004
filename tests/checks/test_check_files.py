"""Which files are checked, by which rules, and what comes of it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from helpers.planted_defects import HEALTHY

import robodyn
from robodyn.checks import sources
from robodyn.checks.catalogue import rules_for
from robodyn.checks.check import Checked, Options, Task, check, check_one, check_tasks
from robodyn.errors import InputError, RobodynWarning

BAD = '<robot name="r"><link name="a"/><link name="a"/></robot>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "more").mkdir()
    (tmp_path / "b.urdf").write_text(HEALTHY)
    (tmp_path / "a.urdf").write_text(BAD)
    (tmp_path / "more" / "c.urdf").write_text(BAD)
    (tmp_path / "notes.xml").write_text("<a>")
    return tmp_path


def check_all(*given: Path | str) -> Checked:
    return check_tasks([Task(file, Options()) for file in sources.files_of(given)])


def test_the_function_of_the_package(folder: Path) -> None:
    (finding,) = robodyn.check(folder / "a.urdf")
    assert (finding.code, finding.file) == ("RD105", str(folder / "a.urdf"))
    assert robodyn.check(BAD.encode())[0].file == "<stdin>"
    assert robodyn.check is check


def test_a_folder_means_every_urdf_below_it(folder: Path) -> None:
    names = [os.path.relpath(file, folder) for file in check_all(folder).files]
    assert names == ["a.urdf", "b.urdf", os.path.join("more", "c.urdf")]


def test_patterns_and_several_files(folder: Path) -> None:
    assert check_all(f"{folder}/*.urdf").files == (f"{folder}/a.urdf", f"{folder}/b.urdf")
    checked = check_all(f"{folder}/more/c.urdf", f"{folder}/a.urdf", f"{folder}/more/c.urdf")
    assert checked.files == (f"{folder}/more/c.urdf", f"{folder}/a.urdf")
    assert [finding.file for finding in checked.findings] == list(checked.files)


def test_a_file_whose_name_looks_like_a_pattern(tmp_path: Path) -> None:
    path = tmp_path / "arm[1].urdf"
    path.write_text(BAD)
    assert check_all(path).files == (str(path),)


def test_what_is_not_there(folder: Path) -> None:
    for missing, why in (("x.urdf", "no such file"), ("*.sdf", "nothing matches"), ("empty", "no .urdf")):
        (folder / "empty").mkdir(exist_ok=True)
        with pytest.raises(InputError, match=why):
            check(folder / missing)


def test_a_folder_without_a_description_among_others_is_passed_over(folder: Path) -> None:
    (folder / "empty").mkdir()
    with pytest.warns(RobodynWarning, match=r"empty: no \.urdf and no \.xacro in the folder .*: skipped"):
        assert check_all(folder / "empty", folder / "a.urdf").files == (str(folder / "a.urdf"),)


PACKAGED = '<robot name="arm"><link name="a"><visual><geometry><mesh filename="{}"/></geometry></visual></link></robot>'


@pytest.mark.parametrize("manifest", [True, False])
def test_of_a_mesh_or_an_srdf_the_descriptions_that_name_it(tmp_path: Path, manifest: bool) -> None:
    package = tmp_path / "arm_description"
    for name in ("urdf", "meshes", "srdf"):
        (package / name).mkdir(parents=True)
    if manifest:
        (package / "package.xml").write_text("<package><name>arm_description</name></package>")
    (package / "urdf" / "arm.urdf").write_text(PACKAGED.format("../meshes/arm.stl"))
    (package / "urdf" / "leg.urdf").write_text(PACKAGED.format("../meshes/leg.stl").replace('"arm"', '"leg"'))
    (package / "srdf" / "arm.srdf").write_text('<robot name="arm"/>')
    for name in ("arm.stl", "leg.stl", "alone.stl"):
        (package / "meshes" / name).touch()
    arm, leg = (str(package / "urdf" / name) for name in ("arm.urdf", "leg.urdf"))
    assert sources.files_of([package / "meshes" / "arm.stl"]) == [arm]
    assert sources.files_of([package / "meshes" / "leg.stl"]) == [leg]
    assert sources.files_of([package / "srdf" / "arm.srdf", arm]) == [arm]
    with pytest.warns(RobodynWarning, match=r"alone\.stl: no description in its package names it .*: skipped"):
        assert sources.files_of([package / "meshes" / "alone.stl"]) == []


def test_processes_find_what_one_process_finds(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    alone = check_all(folder)
    monkeypatch.setattr(sources, "_LEAST_WORK", 0)
    monkeypatch.setattr(sources, "cores", lambda: 2)
    assert sources.worth_processes(alone.files)
    assert check_all(folder) == alone


def test_meshes_count_as_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sources, "cores", lambda: 2)
    assert not sources.worth_processes([b"<robot/>", b"<a/>"])
    assert not sources.worth_processes(["one.urdf"])
    files = [str(tmp_path / name) for name in ("a.urdf", "b.urdf")]
    for text, worth in (("<mesh/>" * 30, False), ("<mesh/>" * 60, True), (" " * 150_000, False), (" " * 300_000, True)):
        for file in files:
            Path(file).write_text(text)
        assert sources.worth_processes(files) is worth


def test_findings_stand_in_the_order_of_the_text(folder: Path) -> None:
    text = HEALTHY.replace('value="3.5"', 'value="-3.5"').replace('axis xyz="0 0 1"', 'axis xyz="0 0 0"')
    findings = check_one(text.encode())
    assert {"RD211", "RD201", "RD501"} <= {finding.code for finding in findings}
    assert sorted(findings, key=lambda finding: finding.start) == list(findings)


@pytest.mark.parametrize(
    ("select", "ignore", "expected"),
    [
        (("RD105",), (), {"RD105"}),
        (("RD1", "RD207"), ("RD11",), {f"RD10{k}" for k in range(1, 10)} | {"RD207"}),
        (("RD2",), ("RD2",), set()),
    ],
)
def test_rules_by_code_or_beginning(select: tuple[str, ...], ignore: tuple[str, ...], expected: set[str]) -> None:
    assert {rule.code for rule in rules_for(select, ignore)} == expected


@pytest.mark.parametrize("code", ["RD999", "X", "", "rd207"])
def test_unknown_codes(code: str) -> None:
    with pytest.raises(InputError, match="there is no rule"):
        rules_for((code,), ())
    with pytest.raises(InputError, match="there is no rule"):
        rules_for((), (code,))


def test_a_rule_finds_the_same_alone(folder: Path) -> None:
    text = HEALTHY.replace('value="3.5"', 'value="nan"').replace('child link="wrist"', 'child link="wirst"').encode()
    for finding in check_one(text):
        assert finding in check_one(text, Options(select=(finding.code,)))
