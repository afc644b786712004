"""Shapes of links, and where the files of their meshes are found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yourdfpy
from helpers.example_robots import path_of

from robodyn.errors import InputError
from robodyn.robot.urdf.description import link_shapes, load_description, missing_mesh
from robodyn.robot.urdf.packages import VARIABLES, Search

ROBOTS = Path(__file__).parents[3] / "robots"
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
    error = missing_mesh(description, third.geometry)
    assert str(error) == f"{tmp_path / 'r.urdf'}:4: the mesh 'absent.stl' is not found " + (
        "(names are relative to the description's folder)"
    )


def test_a_link_that_is_not_there():
    with pytest.raises(InputError, match="there is no link 'c'"):
        link_shapes(load_description(TWO.encode()), "c")


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


def test_nothing_is_fetched(tmp_path):
    description = load_description(TWO.replace("absent.stl", "http://host/m.stl").encode())
    shape = link_shapes(description, "a", "visual")[1]
    assert "files are not fetched" in str(missing_mesh(description, shape.geometry))


@pytest.mark.parametrize("source", [ROBOTS / "meshed_arm.urdf", "panda", "solo12", "ur5_robot"], ids=str)
def test_yourdfpy_finds_the_same(source):
    """The same meshes, poses and scales; yourdfpy's own search is given the package folder."""
    path = source if isinstance(source, Path) else path_of(source)
    share = next((folder for folder in path.parents if folder.name == "share"), path.parent)
    description = load_description(path)
    theirs = yourdfpy.URDF.load(path, load_meshes=False, build_scene_graph=False)
    count = 0
    for link in theirs.robot.links:
        for kind, shapes in (("visual", link.visuals), ("collision", link.collisions)):
            ours = link_shapes(description, link.name, kind)
            assert len(ours) == len(shapes)
            for our, their in zip(ours, shapes, strict=True):
                place = np.eye(4) if their.origin is None else their.origin
                np.testing.assert_array_equal(our.geometry.origin.xyz, place[:3, 3])
                if their.geometry.mesh is None:
                    assert our.path is None
                    continue
                name = their.geometry.mesh.filename
                expected = share / name.removeprefix("package://") if "://" in name else path.parent / name
                assert our.path is not None
                assert our.path.samefile(expected)
                scale = 1.0 if their.geometry.mesh.scale is None else their.geometry.mesh.scale
                np.testing.assert_array_equal(our.geometry.scale, np.broadcast_to(scale, 3))
                count += 1
    assert count >= 9
