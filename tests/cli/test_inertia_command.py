"""`robodyn inertia`: what it prints of meshes with known properties, and how it refuses."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from helpers import mesh_samples
from helpers.command_line import run

import robodyn
from robodyn.robot.urdf.description import load_description

EPS = np.finfo(float).eps
TETRAHEDRON = [[9.375, 2.5, 1.875], [2.5, 12.75, 1.5], [1.875, 1.5, 15.375]]


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


def test_json_of_a_published_tetrahedron(wedge):
    found = mesh(run("inertia", wedge, "--density", "1", "--format", "json"))
    assert found["volume"] == found["mass"] == pytest.approx(10, rel=4 * EPS)
    assert found["com"] == pytest.approx([1.25, 1, 0.75], rel=4 * EPS)
    np.testing.assert_allclose(found["inertia"], TETRAHEDRON, rtol=0, atol=4 * EPS * 15.375)
    assert found["area"] == pytest.approx(6 + 7.5 + 10 + np.sqrt(769) / 2, rel=4 * EPS)
    assert found["box"] == {"lo": [0, 0, 0], "hi": [5, 4, 3]}
    assert found["closed"] is True
    assert found["repairs"] == found["warnings"] == []
    assert 0 < found["error"]["arithmetic"] < 1e-14


def test_keys(wedge):
    found = mesh(run("inertia", wedge, "--format", "json"))
    expected = (
        "name triangles mass volume area density com inertia inertia_about principal symmetry box closed repairs error "
        "arithmetic notes warnings"
    )
    assert list(found) == expected.split()
    assert found["density"] == 1000


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254), ("m", 1.0)])
def test_units(wedge, unit, metres):
    found = mesh(run("inertia", wedge, "--density", "1", "--unit", unit, "--format", "json"))
    assert found["volume"] == pytest.approx(10 * metres**3, rel=8 * EPS)
    np.testing.assert_allclose(found["inertia"], np.array(TETRAHEDRON) * metres**5, rtol=16 * EPS)


def test_mass_in_place_of_density(wedge):
    found = mesh(run("inertia", wedge, "--mass", "5", "--format", "json"))
    assert found["mass"] == 5
    np.testing.assert_allclose(found["inertia"], np.array(TETRAHEDRON) / 2, rtol=8 * EPS)


def test_about_the_origin_and_in_turned_axes(wedge):
    """Parallel axis theorem: I_o = I_c + m (|c|^2 1 - c c^T); a quarter turn about z exchanges x and y."""
    c = np.array([1.25, 1, 0.75])
    expected = np.array(TETRAHEDRON) + 10 * (c @ c * np.eye(3) - np.outer(c, c))
    about = mesh(run("inertia", wedge, "--density", "1", "--about", "origin", "--format", "json"))["inertia_about"]
    assert about["point"] == [0, 0, 0]
    np.testing.assert_allclose(about["matrix"], expected, rtol=0, atol=16 * EPS * 60)
    quarter = ("--rpy", f"0,0,{np.pi / 2!r}")
    turned = mesh(run("inertia", wedge, "--density", "1", "--about", "0,0,0", *quarter, "--format", "json"))
    R = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    np.testing.assert_allclose(turned["inertia_about"]["matrix"], R.T @ expected @ R, rtol=0, atol=16 * EPS * 60)


def test_urdf_reads_back(wedge):
    text = run("inertia", wedge, "--density", "1", "--format", "urdf").out
    described = load_description(f'<robot name="r"><link name="a">{text}</link></robot>'.encode())
    inertial = described.links[0].inertial
    found = mesh(run("inertia", wedge, "--density", "1", "--format", "json"))
    I = found["inertia"]
    assert (inertial.mass, list(inertial.origin.xyz)) == (found["mass"], found["com"])
    assert inertial.inertia == (I[0][0], I[0][1], I[0][2], I[1][1], I[1][2], I[2][2])


def test_text(wedge):
    lines = run("inertia", wedge).out.splitlines()
    assert lines[0].endswith("wedge.stl: 4 triangles, closed, 5.000 x 4.000 x 3.000 m")
    assert "mass            10000 kg, at an assumed density" in lines
    assert "centre of mass  (1.250, 1.000, 0.7500) m" in lines
    assert "Inertia about the centre of mass [kg m^2]" in lines
    assert any(re.fullmatch(r"x +9375 +2500 +1875", line) for line in lines)
    assert not any(line.startswith(("warning", "repaired")) for line in lines)


def test_several_meshes_and_standard_input(wedge):
    data = mesh_samples.binary_stl(mesh_samples.box((2, 2, 2)))
    outcome = run("inertia", wedge, "-", "--type", "stl", "--format", "json", stdin=data)
    first, second = json.loads(outcome.out)["meshes"]
    assert (second["name"], second["volume"]) == ("<stdin>", 8)
    assert first["volume"] == pytest.approx(10, rel=4 * EPS)


def test_inward_winding_is_turned_and_said(tmp_path):
    path = tmp_path / "inward.stl"
    path.write_bytes(mesh_samples.binary_stl(mesh_samples.flipped(mesh_samples.tetrahedron())))
    found = mesh(run("inertia", str(path), "--density", "1", "--format", "json"))
    (step,) = found["repairs"]
    assert (step["name"], step["count"], step["what"]) == ("orientation", 1, "1 shell turned outwards")
    assert [step["volume_before"], step["volume_after"]] == pytest.approx([-10, 10], rel=4 * EPS)
    assert found["mass"] == pytest.approx(10, rel=4 * EPS)
    np.testing.assert_allclose(found["inertia"], TETRAHEDRON, rtol=0, atol=4 * EPS * 15.375)
    assert "repaired: 1 shell turned outwards; volume -10.00 to 10.00 m^3\n" in run("inertia", str(path)).out
    refused = run("inertia", str(path), "--strict")
    assert (refused.status, refused.out) == (2, "")
    assert refused.err == f"error: {path}: 1 shell turned outwards (--strict refuses what needs repair)\n"
    raw = mesh(run("inertia", str(path), "--density", "1", "--no-repair", "--format", "json"))
    assert raw["mass"] == pytest.approx(-10, rel=4 * EPS)


def test_open_surface(tmp_path):
    path = tmp_path / "open.stl"
    path.write_bytes(mesh_samples.binary_stl(mesh_samples.box((2, 2, 2))[:-2]))
    outcome = run("inertia", str(path))
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {path}: the surface is not closed (1 gap too large to be filled: ")
    sheet = mesh(run("inertia", str(path), "--shell", "0.001", "--density", "7800", "--format", "json"))
    assert sheet["mass"] == pytest.approx(20 * 0.001 * 7800, rel=4 * EPS)
    assert sheet["closed"] is False
    raw = mesh(run("inertia", str(path), "--no-repair", "--format", "json"))
    assert len(raw["warnings"]) == 1


def test_mixed_winding(tmp_path):
    path = tmp_path / "mixed.stl"
    box = mesh_samples.box()
    path.write_bytes(mesh_samples.binary_stl(np.concatenate((box[:3], mesh_samples.flipped(box[3:])))))
    found = mesh(run("inertia", str(path), "--format", "json"))
    assert found["volume"] == pytest.approx(1, rel=4 * EPS)
    assert "winding" in [step["name"] for step in found["repairs"]]
    assert mesh(run("inertia", str(path), "--no-repair", "--format", "json"))["closed"] is False


def test_a_part_that_looks_like_millimetres(tmp_path):
    path = tmp_path / "large.stl"
    path.write_bytes(mesh_samples.binary_stl(mesh_samples.box((120, 30, 20))))
    (warning,) = mesh(run("inertia", str(path), "--format", "json"))["warnings"]
    assert warning == "the part is 120 m long: if the file is in millimetres, say --unit mm"
    assert mesh(run("inertia", str(path), "--unit", "mm", "--format", "json"))["warnings"] == []


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--density", "1", "--mass", "2"), "both a density and a mass are given (give one of them)"),
        (("--density", "0"), "a density of 0 kg/m^3 is not positive and finite"),
        (("--mass", "-1"), "a mass of -1 kg is not positive and finite"),
        (("--mass", "nan"), "a mass of nan kg is not positive and finite"),
        (("--shell", "inf"), "a thickness of inf m is not positive and finite"),
        (
            ("--about", "centre"),
            "'centre' is neither com nor origin nor X,Y,Z in m",
        ),
    ],
)
def test_bad_calls(wedge, options, message):
    outcome = run("inertia", wedge, *options)
    assert (outcome.status, outcome.out) == (2, "")
    assert message in outcome.err
    assert outcome.err.count("\n") == 1


def test_bad_files(tmp_path):
    (tmp_path / "empty.stl").write_bytes(b"")
    (tmp_path / "cut.stl").write_bytes(mesh_samples.binary_stl(mesh_samples.box())[:-7])
    for name in ("empty.stl", "cut.stl", "absent.stl"):
        outcome = run("inertia", str(tmp_path / name))
        assert (outcome.status, outcome.out, outcome.err.count("\n")) == (2, "", 1)
        assert outcome.err.startswith(f"error: {tmp_path / name}: ")


def test_from_python():
    part = robodyn.mass_properties(mesh_samples.tetrahedron(), density=1)
    np.testing.assert_allclose(part.body.inertia, TETRAHEDRON, rtol=0, atol=4 * EPS * 15.375)
    assert part.body.com == pytest.approx([1.25, 1, 0.75], rel=4 * EPS)
