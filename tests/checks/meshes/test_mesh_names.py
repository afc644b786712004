"""Names of meshes on disks that tell no case and on Windows, by simulated listings."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from helpers.mesh_samples import binary_stl, box

from robodyn.checks.check import check_one
from robodyn.checks.meshes import files as mesh_files
from robodyn.checks.rule import Finding, Severity
from robodyn.robot.urdf.packages import Search

E, W = Severity.ERROR, Severity.WARNING
COMPOSED, DECOMPOSED = "Gerät.stl", "Gera\u0308t.stl"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """urdf/ beside meshes/Upper/part.stl."""
    (tmp_path / "meshes" / "Upper").mkdir(parents=True)
    (tmp_path / "urdf").mkdir()
    (tmp_path / "meshes" / "Upper" / "part.stl").write_bytes(binary_stl(box()))
    return tmp_path / "urdf"


@pytest.fixture
def one_case(monkeypatch: pytest.MonkeyPatch) -> None:
    """A disk that opens a file by its name in any case, as those of Windows and macOS do; listings keep the case."""

    find = Search.find

    def found(search: Search, uri: str) -> Path | None:
        (folder,) = search.folders
        opened = folder
        for part in uri.replace("\\", "/").split("/"):
            names = [part] if part in ("", ".", "..") else os.listdir(opened)
            same = [name for name in names if name.casefold() == part.casefold()]
            if not same:
                return None
            opened /= same[0]
        return find(search, str(opened)) and folder / uri

    monkeypatch.setattr(Search, "find", found)
    monkeypatch.setattr(mesh_files, "facts_of", lambda paths: dict.fromkeys(paths, SOUND))


SOUND = mesh_files.MeshFacts(triangles=12, hi=(1.0, 1.0, 1.0), volume=1.0, closed=True)


def findings(folder: Path, uri: str) -> list[Finding]:
    shape = f'<collision><geometry><mesh filename="{uri}"/></geometry></collision>'
    (folder / "robot.urdf").write_text(f'<robot name="r"><link name="base">{shape}</link></robot>', encoding="utf-8")
    return [one for one in check_one(str(folder / "robot.urdf")) if one.code.startswith("RD6")]


CASES = {
    "../meshes/Upper/part.stl": [],
    "../meshes/Upper/Part.STL": [("RD602", "../meshes/Upper/part.stl")],
    "../Meshes/upper/part.stl": [("RD602", "../meshes/Upper/part.stl")],
    "./../MESHES//UPPER/PART.STL": [("RD602", "./../meshes//Upper/part.stl")],
}


def test_a_disk_that_tells_cases(folder: Path) -> None:
    for uri, expected in CASES.items():
        found = findings(folder, uri)
        assert [(one.code, one.fix.edits[0].text) for one in found if one.fix] == expected
        assert len(found) == len(expected)


@pytest.mark.usefixtures("one_case")
def test_a_disk_that_does_not_finds_the_same(folder: Path) -> None:
    """There the file is opened in any case, and that the description works nowhere else is still said."""
    test_a_disk_that_tells_cases(folder)


@pytest.mark.usefixtures("one_case")
def test_folders_between_backslashes_are_found_on_windows_and_warned_of(folder: Path) -> None:
    (one,) = findings(folder, "..\\meshes\\Upper\\part.stl")
    assert (one.code, one.severity) == ("RD603", W)
    assert "has \\ between folders, which Windows alone reads" in one.message


def test_folders_between_backslashes_are_not_found_elsewhere(folder: Path) -> None:
    (one,) = findings(folder, "..\\meshes\\Upper\\part.stl")
    assert (one.code, one.severity) == ("RD601", E)
    assert one.fix is not None
    assert one.fix.edits[0].text == "../meshes/Upper/part.stl"
    (other,) = findings(folder, "..\\meshes\\none.stl")
    assert (other.code, other.fix) == ("RD601", None)


def test_of_two_files_that_differ_in_case_none_is_meant(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    listed = os.listdir

    def listing(path: Path) -> list[str]:
        return [*listed(path), "Part.stl"] if Path(path).name == "Upper" else listed(path)

    monkeypatch.setattr(os, "listdir", listing)
    (one,) = findings(folder, "../meshes/Upper/PART.stl")
    assert (one.code, one.severity, one.fix) == ("RD601", E, None)


def test_a_listing_that_decomposes_letters_is_no_other_case(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on macOS: the file opens by the composed name, and is listed by the decomposed one."""
    (folder / COMPOSED).write_bytes(binary_stl(box()))
    listed = os.listdir
    monkeypatch.setattr(os, "listdir", lambda path: [name.replace(COMPOSED, DECOMPOSED) for name in listed(path)])
    assert findings(folder, COMPOSED) == []


@pytest.mark.parametrize(
    "uri", ["C:/arm/part.stl", "c:\\arm\\part.stl", "\\\\server\\arm\\part.stl", "file:///C:/part.stl"]
)
def test_absolute_names_of_windows(folder: Path, uri: str) -> None:
    assert [(one.code, one.severity) for one in findings(folder, uri)] == [("RD601", E), ("RD603", W)]
