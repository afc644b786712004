"""Shapes of links: where the files of their meshes are - in folders, packages of ROS, workspaces, behind links -, and
their triangles, closed, as large as they should be, in place."""

from __future__ import annotations

import logging
import os
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.command_line import ROBOTS

from robodyn.report.stage import shapes_of
from robodyn.robot.load import load_description
from robodyn.robot.urdf import sources
from robodyn.robot.urdf.description import link_shapes, missing_mesh
from robodyn.robot.urdf.sources import VARIABLES, Search

TWO = """<robot name="r"><link name="a">
<visual><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><geometry><mesh filename="m.stl" scale="1 -2 3"/></geometry></visual>
<collision><geometry><box size="1 2 3"/></geometry></collision>
<visual><geometry><mesh filename="absent.stl"/></geometry></visual></link><link name="b"/>
<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint></robot>"""


@pytest.fixture(autouse=True)
def _no_ros(monkeypatch):
    for variable in VARIABLES:
        monkeypatch.delenv(variable, raising=False)


def resolve(uri, folder, package_paths=()):
    return Search(str(Path(folder) / "r.urdf"), tuple(map(str, package_paths))).find(uri)


def touched(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()
    return path


def test_shapes_in_order_with_lines_and_files(tmp_path):
    (tmp_path / "r.urdf").write_text(TWO)
    mesh = touched(tmp_path / "m.stl")
    description = load_description(tmp_path / "r.urdf")
    first, second, third = link_shapes(description, "a")
    assert (first.path, first.missing, first.geometry.line) == (mesh, False, 2)
    assert first.geometry.scale == (1, -2, 3)
    assert (second.path, second.missing, second.geometry.size) == (None, False, (1, 2, 3))
    assert (third.path, third.missing) == (None, True)
    assert link_shapes(description, "a", "collision") == (second,)
    assert link_shapes(description, "a", "visual") == (first, third)
    assert link_shapes(description, "b") == ()
    fetched = load_description(TWO.replace("absent.stl", "http://host/m.stl").encode())
    assert "files are not fetched" in str(missing_mesh(fetched, link_shapes(fetched, "a", "visual")[1].geometry))
    error = missing_mesh(description, third.geometry)
    assert str(error) == f"{tmp_path / 'r.urdf'}:4: the mesh 'absent.stl' is not found " + (
        "(names are relative to the description's folder)"
    )


def test_relative_and_absolute_names(tmp_path):
    mesh = touched(tmp_path / "meshes" / "with blank.stl")
    assert resolve("meshes/with blank.stl", tmp_path) == mesh
    assert resolve("../meshes/with blank.stl", mesh.parent) == mesh.parent / "../meshes/with blank.stl"
    assert resolve(str(mesh), "elsewhere") == mesh
    assert resolve(f"file://{mesh}", "elsewhere") == mesh
    assert resolve(f"file://localhost{mesh}", "elsewhere") == mesh
    assert resolve(f"file://{mesh}".replace(" ", "%20"), "elsewhere") == mesh


@pytest.mark.parametrize(
    "uri",
    [
        *("", "absent.stl", ".", "file://", "package://", "package://p", "package://p/x.stl", "http://h/m.stl"),
        *("m\0.stl", "x" * 5000, "package://" + "x" * 5000 + "/m.stl", "package://*/m.stl", "://m.stl"),
    ],
)
def test_names_without_a_file(uri, tmp_path):
    touched(tmp_path / "a" / "m.stl")
    touched(tmp_path / "m.stl")
    assert resolve(uri, tmp_path, [tmp_path]) is None


def test_the_manifest_names_the_package_and_not_its_folder(tmp_path):
    mesh = touched(tmp_path / "checkout-main" / "m.stl")
    (mesh.parent / "package.xml").write_text("<package>\n <name> arm </name></package>")
    assert resolve("package://arm/m.stl", mesh.parent / "urdf") == mesh
    assert resolve("package://arm/m.stl", tmp_path / "far", [mesh.parent]) == mesh
    assert resolve("package://checkout-main/m.stl", "/", [mesh.parent]) is None


URI = "package://arm/m.stl"


def package(folder: Path, name: str | None = "arm") -> Path:
    """A package with a mesh; without a manifest if it has no name. The mesh."""
    folder.mkdir(parents=True)
    if name is not None:
        (folder / "package.xml").write_text(f"<package><name>{name}</name></package>")
    (folder / "m.stl").touch()
    return folder / "m.stl"


PLACES = {
    "merged installation": ("install/share/arm", "far/r.urdf", "install"),
    "isolated installation": ("install/arm/share/arm", "far/r.urdf", "install"),
    "group of repositories": ("src/group/repository/arm_checkout", "far/r.urdf", "src"),
    "beside that of the description": ("ws/arm-main", "ws/robot_description/urdf/r.urdf", None),
    "in the same workspace": ("ws/src/parts/arms/arm-main", "ws/src/robots/robot_description/r.urdf", None),
    "in the same repository": ("repository/parts/arms/arm-main", "repository/robots/robot_description/r.urdf", None),
    "below a hidden folder": ("src/.hidden/arm", "far/r.urdf", "src"),
    "among the tests of another": ("src/other/test/arm", "far/r.urdf", "src"),
}
"""Of the package, of the description, and of what --package-path names."""


@pytest.mark.parametrize("case", PLACES)
def test_where_packages_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, case: str) -> None:
    """By their names, whatever their folders are called."""
    folder, description, given = PLACES[case]
    (tmp_path / "repository" / ".git").mkdir(parents=True)
    package(tmp_path / "src" / "other", "other")
    for own in Path(description).parents:
        if own.name == "robot_description":
            package(tmp_path / own, "robot")
    mesh = package(tmp_path / folder)
    expected = None if "hidden" in folder or "test" in folder else mesh
    assert Search(str(tmp_path / description), () if given is None else (str(tmp_path / given),)).find(URI) == expected
    if "installation" in case:
        monkeypatch.setenv(VARIABLES[2], os.pathsep.join(("", str(tmp_path / "none"), str(tmp_path / "install"))))
        search = Search(str(tmp_path / description))
        assert search.find(URI) == mesh
        assert search.knows_packages


def test_each_package_has_a_prefix_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the setup files of an isolated workspace write it."""
    meshes = {name: package(tmp_path / name / "share" / name, name) for name in ("arm", "hand")}
    monkeypatch.setenv("AMENT_PREFIX_PATH", os.pathsep.join(str(tmp_path / name) for name in meshes))
    search = Search(str(tmp_path / "r.urdf"))
    assert {name: search.find(f"package://{name}/m.stl") for name in meshes} == meshes


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


def test_a_large_folder_is_not_searched_for_ever(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package(tmp_path / "a" / "b" / "c" / "arm")
    monkeypatch.setattr(sources, "_MOST_FOLDERS", 1)
    assert Search("/far/r.urdf", (str(tmp_path),)).find(URI) is None


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
    assert Search("urdf/r.urdf").share("arm") is None


SHAPES = {
    "box": ((0.1, 0.2, 0.5), 0.01, 0.0),
    "cylinder": ((0.1, 0.4), np.pi * 0.1**2 * 0.4, 0.01),
    "sphere": ((0.3,), 4 / 3 * np.pi * 0.3**3, 0.02),
    "capsule": ((0.1, 0.4), np.pi * 0.1**2 * (0.4 + 4 / 3 * 0.1), 0.02),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_primitives_are_closed_and_as_large_as_they_should_be(shape: str) -> None:
    size, volume, coarse = SHAPES[shape]
    names = {"box": "size", "cylinder": "radius length", "sphere": "radius", "capsule": "radius length"}[shape].split()
    given = (" ".join(map(str, size)),) if shape == "box" else size
    values = " ".join(f'{name}="{x}"' for name, x in zip(names, given, strict=True))
    origin = '<origin xyz="1 2 3" rpy="0.3 -0.2 1.1"/>'
    link = f'<link name="x"><visual>{origin}<geometry><{shape} {values}/></geometry></visual></link>'
    triangles = shapes_of(load_description(f'<robot name="r">{link}</robot>'.encode()))[0]["x"]
    solid = trimesh.Trimesh(**trimesh.triangles.to_kwargs(triangles), process=False)
    solid.merge_vertices(digits_vertex=9)
    solid.update_faces(solid.nondegenerate_faces())
    assert solid.is_watertight
    assert abs(solid.volume) <= volume * (1 + 1e-12)
    assert abs(solid.volume) >= volume * (1 - coarse) * (1 - 1e-12)
    np.testing.assert_allclose(triangles.reshape(-1, 3).mean(axis=0), (1.0, 2.0, 3.0), rtol=0, atol=0.02)


def test_missing_meshes_are_named(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "arm.urdf").write_text((ROBOTS / "meshed_arm.urdf").read_text())
    with caplog.at_level(logging.WARNING):
        found, why = shapes_of(load_description(tmp_path / "arm.urdf"))
    assert why.startswith("8 mesh files are not found or cannot be read, and not drawn: meshes/hub.stl, ")
    assert "hand" not in found
    assert not caplog.records
