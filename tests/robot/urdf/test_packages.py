"""Where packages are: of ROS, of ROS 2 in both layouts of colcon, in workspaces, and behind symbolic links."""

from __future__ import annotations

import os
import pickle
from pathlib import Path

import pytest

from robodyn.robot.urdf import packages
from robodyn.robot.urdf.packages import VARIABLES, Search

URI = "package://arm/m.stl"


@pytest.fixture(autouse=True)
def _no_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in VARIABLES:
        monkeypatch.delenv(variable, raising=False)


def package(folder: Path, name: str | None = "arm") -> Path:
    """A package with a mesh; without a manifest if it has no name. The mesh."""
    folder.mkdir(parents=True)
    if name is not None:
        (folder / "package.xml").write_text(f"<package><name>{name}</name></package>")
    (folder / "m.stl").touch()
    return folder / "m.stl"


@pytest.mark.parametrize("variable", VARIABLES[1:])
@pytest.mark.parametrize("layout", ["share/arm", "arm/share/arm"], ids=["merged", "isolated"])
def test_installations_of_ros_2(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, variable: str, layout: str) -> None:
    mesh = package(tmp_path / "install" / layout)
    monkeypatch.setenv(variable, os.pathsep.join(("", str(tmp_path / "none"), str(tmp_path / "install"))))
    search = Search(str(tmp_path / "far" / "r.urdf"))
    assert search.find(URI) == mesh
    assert search.knows_packages


def test_each_package_has_a_prefix_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the setup files of an isolated workspace write it."""
    meshes = {name: package(tmp_path / name / "share" / name, name) for name in ("arm", "hand")}
    monkeypatch.setenv("AMENT_PREFIX_PATH", os.pathsep.join(str(tmp_path / name) for name in meshes))
    search = Search(str(tmp_path / "r.urdf"))
    assert {name: search.find(f"package://{name}/m.stl") for name in meshes} == meshes


def test_installations_are_package_paths_too(tmp_path: Path) -> None:
    merged, isolated = package(tmp_path / "a" / "share" / "arm"), package(tmp_path / "b" / "arm" / "share" / "arm")
    for folder, mesh in (("a", merged), ("b", isolated)):
        assert Search("/far/r.urdf", (str(tmp_path / folder),)).find(URI) == mesh


def test_order_of_precedence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    option = package(tmp_path / "option" / "arm")
    by_variable = [package(tmp_path / name / "share" / "arm") for name in VARIABLES]
    above = package(tmp_path / "home" / "arm")
    real = package(tmp_path / "real" / "arm")
    (above.parent / "link.urdf").symlink_to(real.parent / "r.urdf")
    for name in VARIABLES:
        monkeypatch.setenv(name, str(tmp_path / name))
    expected = [option, *by_variable, above, real]
    for mesh in expected:
        search = Search(str(above.parent / "link.urdf"), (str(tmp_path / "option"),))
        assert search.find(URI) == mesh, mesh
        mesh.unlink()


def test_a_link_leads_to_the_package_and_to_the_folder_of_the_real_file(tmp_path: Path) -> None:
    mesh = package(tmp_path / "src" / "checkout")
    (mesh.parent / "urdf").mkdir()
    (mesh.parent / "urdf" / "r.urdf").touch()
    (tmp_path / "file.urdf").symlink_to(mesh.parent / "urdf" / "r.urdf")
    (tmp_path / "folder").symlink_to(mesh.parent / "urdf")
    for name in ("file.urdf", "folder/r.urdf"):
        search = Search(str(tmp_path / name))
        assert search.home == mesh.parent
        found = [search.find(uri) for uri in (URI, "../m.stl")]
        assert all(path is not None and path.samefile(mesh) for path in found)


def test_what_is_beside_a_link_comes_first(tmp_path: Path) -> None:
    for name in ("named", "real"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "m.stl").touch()
    (tmp_path / "named" / "r.urdf").symlink_to(tmp_path / "real" / "r.urdf")
    search = Search(str(tmp_path / "named" / "r.urdf"))
    assert search.find("m.stl") == tmp_path / "named" / "m.stl"
    (tmp_path / "named" / "m.stl").unlink()
    assert search.find("m.stl") == tmp_path / "real" / "m.stl"


def test_a_workspace_of_groups_of_repositories(tmp_path: Path) -> None:
    mesh = package(tmp_path / "src" / "group" / "repository" / "arm_checkout")
    package(mesh.parent / "test" / "arm")
    package(tmp_path / "src" / ".hidden" / "arm")
    assert Search("/far/r.urdf", (str(tmp_path / "src"),)).find(URI) == mesh
    mesh.unlink()
    assert Search("/far/r.urdf", (str(tmp_path / "src"),)).find(URI) is None


def test_a_large_folder_is_not_searched_for_ever(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package(tmp_path / "a" / "b" / "c" / "arm")
    monkeypatch.setattr(packages, "_MOST_FOLDERS", 1)
    assert Search("/far/r.urdf", (str(tmp_path),)).find(URI) is None


def test_folders_are_listed_only_where_nothing_nearer_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh, listed = package(tmp_path / "arm"), []
    monkeypatch.setattr(packages, "_folders_in", lambda folder: listed.append(folder) or [])
    search = Search("/far/r.urdf", (str(tmp_path),))
    assert search.find(URI) == mesh
    assert listed == []
    assert [search.find("package://arm/none.stl") for _ in range(3)] == [None] * 3
    assert listed == [tmp_path]


def test_of_a_package_without_a_file_to_find_the_one_with_a_manifest_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The prefix `install/arm` has the package's name, and is not the package."""
    mesh = package(tmp_path / "install" / "arm" / "share" / "arm")
    search = Search("/far/r.urdf", (str(tmp_path / "install"),))
    assert search.share("arm") == mesh.parent
    assert search.share("none") is None
    (mesh.parent / "package.xml").unlink()
    assert Search("/far/r.urdf", (str(tmp_path / "install"),)).share("arm") == tmp_path / "install" / "arm"


def test_a_search_goes_to_other_processes(tmp_path: Path) -> None:
    mesh = package(tmp_path / "arm")
    search = Search("/far/r.urdf", (str(tmp_path),))
    assert search.find(URI) == pickle.loads(pickle.dumps(search)).find(URI) == mesh


def test_packages_beside_that_of_the_description(tmp_path: Path) -> None:
    """By their names, whatever their folders are called."""
    own = package(tmp_path / "ws" / "robot_description", "robot")
    mesh = package(tmp_path / "ws" / "arm-main")
    assert Search(str(own.parent / "urdf" / "r.urdf")).find(URI) == mesh


@pytest.mark.parametrize("root", ["ws/src", "repository"])
def test_packages_of_the_same_workspace_or_repository(tmp_path: Path, root: str) -> None:
    own = package(tmp_path / root / "robots" / "robot_description", "robot")
    mesh = package(tmp_path / root / "parts" / "arms" / "arm-main")
    (tmp_path / "repository" / ".git").mkdir(parents=True, exist_ok=True)
    assert Search(str(own.parent / "r.urdf")).find(URI) == mesh


def test_the_folder_entered_through_a_symbolic_link(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The name of the package is that of the link."""
    real = package(tmp_path / "checkout" / "arm-main", None)
    (tmp_path / "ws").mkdir()
    (tmp_path / "ws" / "arm").symlink_to(real.parent)
    (real.parent / "urdf").mkdir()
    monkeypatch.chdir(tmp_path / "ws" / "arm")
    monkeypatch.setenv("PWD", str(tmp_path / "ws" / "arm"))
    found = Search("urdf/r.urdf").find(URI)
    assert found is not None
    assert found.samefile(real)
    monkeypatch.setenv("PWD", str(tmp_path))
    assert Search("urdf/r.urdf").find(URI) is None
