"""`robodyn inertia`: what it prints of meshes with known properties, and how it refuses."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from helpers import mesh_samples
from helpers import mesh_samples as samples
from helpers.command_line import refused, run
from helpers.mesh_samples import binary_stl, box
from helpers.round_shapes import SOLIDS

EPS = np.finfo(float).eps
TETRAHEDRON = [[9.375, 2.5, 1.875], [2.5, 12.75, 1.5], [1.875, 1.5, 15.375]]
ROBOT = """<robot name="r"><link name="l"><visual><geometry><mesh filename="part.stl" scale="0.1 0.1 0.1"/></geometry>
</visual></link></robot>"""


@pytest.fixture
def wedge(tmp_path):
    """Mirtich's tetrahedron as binary STL."""
    path = tmp_path / "wedge.stl"
    path.write_bytes(mesh_samples.binary_stl(mesh_samples.tetrahedron()))
    return str(path)


def mesh(outcome):
    assert (outcome.status, outcome.err) == (0, "")
    (only,) = json.loads(outcome.out)["meshes"]
    return only


def one_mesh(*args):
    return mesh(run("inertia", *args, "--format", "json"))


def test_json_of_a_published_tetrahedron(wedge):
    found = one_mesh(wedge, "--density", "1")
    assert found["volume"] == found["mass"] == pytest.approx(10, rel=4 * EPS)
    assert found["com"] == pytest.approx([1.25, 1, 0.75], rel=4 * EPS)
    np.testing.assert_allclose(found["inertia"], TETRAHEDRON, rtol=0, atol=4 * EPS * 15.375)
    assert found["area"] == pytest.approx(6 + 7.5 + 10 + np.sqrt(769) / 2, rel=4 * EPS)
    assert found["box"] == {"lo": [0, 0, 0], "hi": [5, 4, 3]}
    assert found["closed"] is True
    assert found["repairs"] == found["warnings"] == []
    assert 0 < found["error"]["arithmetic"] < 1e-14


def test_about_the_origin_and_in_turned_axes(wedge):
    """Parallel axis theorem: I_o = I_c + m (|c|^2 1 - c c^T); a quarter turn about z exchanges x and y."""
    c = np.array([1.25, 1, 0.75])
    expected = np.array(TETRAHEDRON) + 10 * (c @ c * np.eye(3) - np.outer(c, c))
    about = one_mesh(wedge, "--density", "1", "--about", "origin")["inertia_about"]
    assert about["point"] == [0, 0, 0]
    np.testing.assert_allclose(about["matrix"], expected, rtol=0, atol=16 * EPS * 60)
    quarter = ("--rpy", f"0,0,{np.pi / 2!r}")
    turned = one_mesh(wedge, "--density", "1", "--about", "0,0,0", *quarter)
    R = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    np.testing.assert_allclose(turned["inertia_about"]["matrix"], R.T @ expected @ R, rtol=0, atol=16 * EPS * 60)


def test_text(wedge):
    lines = run("inertia", wedge).out.splitlines()
    assert lines[0].endswith("wedge.stl: 4 triangles, closed, 5.000 x 4.000 x 3.000 m")
    assert "mass            10000 kg, at an assumed density" in lines
    assert "centre of mass  (1.250, 1.000, 0.7500) m" in lines
    assert "Inertia about the centre of mass [kg m^2]" in lines
    assert any(re.fullmatch(r"x +9375 +2500 +1875", line) for line in lines)
    assert not any(line.startswith(("warning", "repaired")) for line in lines)


def test_inward_winding_is_turned_and_said(tmp_path):
    path = tmp_path / "inward.stl"
    path.write_bytes(mesh_samples.binary_stl(mesh_samples.flipped(mesh_samples.tetrahedron())))
    found = one_mesh(str(path), "--density", "1")
    (step,) = found["repairs"]
    assert (step["name"], step["count"], step["what"]) == ("orientation", 1, "1 shell turned outwards")
    assert [step["volume_before"], step["volume_after"]] == pytest.approx([-10, 10], rel=4 * EPS)
    assert found["mass"] == pytest.approx(10, rel=4 * EPS)
    np.testing.assert_allclose(found["inertia"], TETRAHEDRON, rtol=0, atol=4 * EPS * 15.375)
    assert "repaired: 1 shell turned outwards; volume -10.00 to 10.00 m^3\n" in run("inertia", str(path)).out
    strict = f"{path}: 1 shell turned outwards (--strict refuses what needs repair)\n"
    refused(run("inertia", str(path), "--strict"), strict)
    raw = one_mesh(str(path), "--density", "1", "--no-repair")
    assert raw["mass"] == pytest.approx(-10, rel=4 * EPS)


def test_open_surface(tmp_path):
    path = tmp_path / "open.stl"
    path.write_bytes(mesh_samples.binary_stl(mesh_samples.box((2, 2, 2))[:-2]))
    line = f"{path}: the surface is not closed (1 gap too large to be filled: "
    refused(run("inertia", str(path)), line)
    sheet = one_mesh(str(path), "--shell", "0.001", "--density", "7800")
    assert sheet["mass"] == pytest.approx(20 * 0.001 * 7800, rel=4 * EPS)
    assert sheet["closed"] is False
    raw = one_mesh(str(path), "--no-repair")
    assert len(raw["warnings"]) == 1


def test_a_part_that_looks_like_millimetres(tmp_path):
    path = tmp_path / "large.stl"
    path.write_bytes(mesh_samples.binary_stl(mesh_samples.box((120, 30, 20))))
    (warning,) = one_mesh(str(path))["warnings"]
    assert warning == "the part is 120 m long: if the file is in millimetres, say --unit mm"
    assert one_mesh(str(path), "--unit", "mm")["warnings"] == []


@pytest.fixture
def files(tmp_path):
    """A mesh of a cube in a cube, and a robot made of it."""
    (tmp_path / "part.stl").write_bytes(binary_stl(np.concatenate([box((3, 3, 3)), box()])))
    (tmp_path / "robot.urdf").write_text(ROBOT)
    return str(tmp_path / "part.stl"), str(tmp_path / "robot.urdf")


def test_both_readings_of_a_mesh(files):
    outcome = run("inertia", files[0])
    assert "volume          27.00 m^3" in outcome.out
    assert "if it is a cavity, say --cavities (1 m^3 less)" in outcome.out
    outcome = run("inertia", files[0], "--cavities", "--format", "json")
    (found,) = json.loads(outcome.out)["meshes"]
    assert (found["volume"], found["warnings"]) == (26, [])

    refused(run("inertia", files[0], "--cavities", "--no-repair"), "")
    link = ("inertia", files[1], "--link", "l", "--geometry", "visual")
    assert "say --cavities (0.001 m^3 less)" in run(*link).out
    assert "0.02600 m^3" in run(*link, "--cavities").out


@pytest.fixture
def lever(tmp_path):
    """Planes y = 0 and z = 0; in float32, so that they hold but for rounding."""
    return saved(tmp_path, SOLIDS["lever"](32).corners)


def saved(folder, corners):
    path = folder / "part.stl"
    path.write_bytes(samples.binary_stl(corners))
    return str(path)


def test_text_of_symmetry(lever):
    out = run("inertia", lever).out
    block = out.partition("\nSymmetry\n")[2].partition("\n\n")[0].splitlines()
    assert block[0].split() == ["normal", "or", "axis", "at", "asymmetry", "verdict"]
    assert [line.split()[0] for line in block[1:-1]] == ["plane", "plane", "axis,"]
    assert all(line.endswith("exact") for line in block[1:-1])
    assert block[-1].startswith("0 by symmetry: Ixy, Ixz, Iyz (computed ")
    assert "if facets are meant flat, nothing is missing; if they stand for smooth faces, the volume is off by" in out
    assert "with smooth faces through the corners: volume 3.287 m^3, principal moments" in out
    assert "if the corners are on them: volume within " in out


def test_average(tmp_path):
    """Of a box with a small hole off its planes: products as large as its tolerance allows, and then none."""
    hole = samples.moved(samples.flipped(samples.box((0.01, 0.01, 0.01))), (0.3, 0.6, 0.9))
    path = saved(tmp_path, np.concatenate([samples.box((1, 2, 3)), hole]))
    as_is, average = one_mesh(path), one_mesh(path, "--symmetrize")
    assert as_is["inertia"][0][1] != 0
    I = np.array(average["inertia"])
    assert np.array_equal(I, np.diag(np.diag(I)))
    np.testing.assert_allclose(I, as_is["inertia"], rtol=0, atol=1e-5 * I.max())
    assert average["mass"] == as_is["mass"]
    assert any(note.startswith("symmetrize: averaged over planes (3) and axes (") for note in average["notes"])
    none = one_mesh(saved(tmp_path, samples.tetrahedron()), "--symmetrize")
    assert "symmetrize: no plane and no axis holds, nothing was changed" in none["notes"]


def test_only_small_meshes_are_asked_unless_told(lever, monkeypatch):
    monkeypatch.setattr("robodyn.solids.mass_properties.SYMMETRY_TRIANGLES", 100)
    monkeypatch.setattr("robodyn.solids.mass_properties.TESSELLATION_TRIANGLES", 100)
    found = one_mesh(lever)
    assert found["symmetry"] is found["error"]["tessellation"] is None
    assert found["notes"][-2:] == [
        "symmetry: not sought unasked above 100 triangles (--symmetry does)",
        "tessellation: not sought unasked above 100 triangles (--tessellation does)",
    ]
    assert len(one_mesh(lever, "--symmetry")["symmetry"]["planes"]) == 3
    assert one_mesh(lever, "--tessellation")["error"]["tessellation"]["volume"]["bar"] > 0
    assert len(one_mesh(lever, "--symmetrize")["symmetry"]["planes"]) == 3
