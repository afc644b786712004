"""`robodyn inertia` of meshes, of descriptions and of meshes combined: what it prints, and which calls it refuses."""

from __future__ import annotations

import itertools
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from helpers import mesh_samples as samples
from helpers.command_line import ROBOTS, document, refused, run, shown
from helpers.html_pages import checked
from helpers.round_shapes import SOLIDS

from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.load import load_description
from robodyn.robot.masses.declared import robot_inertia
from robodyn.robot.masses.shapes import link_from_shapes
from robodyn.solids.inertia.solids import box

EPS = np.finfo(float).eps
TETRAHEDRON = [[9.375, 2.5, 1.875], [2.5, 12.75, 1.5], [1.875, 1.5, 15.375]]
ROBOT = """<robot name="r"><link name="l"><visual><geometry><mesh filename="part.stl" scale="0.1 0.1 0.1"/></geometry>
</visual></link></robot>"""


@pytest.fixture
def wedge(tmp_path):
    """Mirtich's tetrahedron as binary STL."""
    return saved(tmp_path, samples.tetrahedron(), "wedge.stl")


def saved(folder, corners, name="part.stl"):
    path = folder / name
    path.write_bytes(samples.binary_stl(corners))
    return str(path)


def one_mesh(*args):
    (only,) = document("inertia", *args)["meshes"]
    return only


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
    path = saved(tmp_path, samples.flipped(samples.tetrahedron()))
    found = one_mesh(path, "--density", "1")
    (step,) = found["repairs"]
    assert (step["name"], step["count"], step["what"]) == ("orientation", 1, "1 shell turned outwards")
    assert [step["volume_before"], step["volume_after"]] == pytest.approx([-10, 10], rel=4 * EPS)
    assert found["mass"] == pytest.approx(10, rel=4 * EPS)
    np.testing.assert_allclose(found["inertia"], TETRAHEDRON, rtol=0, atol=4 * EPS * 15.375)
    assert "repaired: 1 shell turned outwards; volume -10.00 to 10.00 m^3\n" in run("inertia", path).out
    strict = f"{path}: 1 shell turned outwards (--strict refuses what needs repair)\n"
    refused(run("inertia", path, "--strict"), strict)
    raw = one_mesh(path, "--density", "1", "--no-repair")
    assert raw["mass"] == pytest.approx(-10, rel=4 * EPS)


def test_open_surface(tmp_path):
    path = saved(tmp_path, samples.box((2, 2, 2))[:-2])
    line = f"{path}: the surface is not closed (1 gap too large to be filled: "
    refused(run("inertia", path), line)
    sheet = one_mesh(path, "--shell", "0.001", "--density", "7800")
    assert sheet["mass"] == pytest.approx(20 * 0.001 * 7800, rel=4 * EPS)
    assert sheet["closed"] is False
    raw = one_mesh(path, "--no-repair")
    assert len(raw["warnings"]) == 1


def test_a_part_that_looks_like_millimetres(tmp_path):
    path = saved(tmp_path, samples.box((120, 30, 20)))
    (warning,) = one_mesh(path)["warnings"]
    assert warning == "the part is 120 m long: if the file is in millimetres, say --unit mm"
    assert one_mesh(path, "--unit", "mm")["warnings"] == []


@pytest.fixture
def files(tmp_path):
    """A mesh of a cube in a cube, and a robot made of it."""
    (tmp_path / "robot.urdf").write_text(ROBOT)
    return saved(tmp_path, np.concatenate([samples.box((3, 3, 3)), samples.box()])), str(tmp_path / "robot.urdf")


def test_both_readings_of_a_mesh(files):
    outcome = run("inertia", files[0])
    assert "volume          27.00 m^3" in outcome.out
    assert "if it is a cavity, say --cavities (1 m^3 less)" in outcome.out
    found = one_mesh(files[0], "--cavities")
    assert (found["volume"], found["warnings"]) == (26, [])

    refused(run("inertia", files[0], "--cavities", "--no-repair"), "")
    link = ("inertia", files[1], "--link", "l", "--geometry", "visual")
    assert "say --cavities (0.001 m^3 less)" in run(*link).out
    assert "0.02600 m^3" in run(*link, "--cavities").out


@pytest.fixture
def lever(tmp_path):
    """Planes y = 0 and z = 0; in float32, so that they hold but for rounding."""
    return saved(tmp_path, SOLIDS["lever"](32).corners)


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


ARM = str(ROBOTS / "meshed_arm.urdf")
CALLS = {
    "robot": (ARM, "--at", "0.1,-0.2,0.3,4,0.01"),
    "link": (ARM, "--link", "upper_arm"),
    "shapes": (ARM, "--link", "hand", "--geometry", "visual"),
    "collision": (ARM, "--link", "hand", "--geometry", "collision", "--density", "2700"),
}
MASS = '<inertial><mass value="{mass}"/><inertia ixx=".02" ixy="0" ixz="0" iyy=".03" iyz="0" izz=".04"/></inertial>'
ZERO = '<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
CUBE = '<visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>'
HUGE = (
    '<inertial><mass value="2"/><inertia ixx="0.8" ixy="0" ixz="0" iyy="0.8" iyz="0" izz="0.8"/></inertial>'
    f'{CUBE}<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
)
"""An inertia of 240 times that of the box."""


@pytest.fixture
def boxes(tmp_path):
    """Two boxes as files."""
    sizes = {"long.stl": (2, 1, 0.5), "cube.stl": (1, 1, 1)}
    return [saved(tmp_path, samples.box(size), name) for name, size in sizes.items()]


def read_back(*call):
    """The inertial element that is printed, as our reader has it."""
    text = shown("inertia", *call, "--format", "urdf")
    found = load_description(f'<robot name="r"><link name="a">{text}</link></robot>'.encode()).links[0].inertial
    xx, xy, xz, yy, yz, zz = found.inertia
    return found.mass, list(found.origin.xyz), [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_urdf_reads_back_as_the_json_has_it(call):
    found = document("inertia", *call)
    assert read_back(*call) == (found["mass"], found["com"], found["inertia"])


def test_robot_json():
    found = document("inertia", *CALLS["robot"])
    assert found["at"] == {"waist": 0.1, "shoulder": -0.2, "elbow": 0.3, "wrist": 4.0, "finger_slide": 0.01}
    assert math.fsum(link["mass"] for link in found["links"]) == pytest.approx(found["mass"], rel=2 * EPS)
    expected = robot_inertia(load_description(ARM), [0.1, -0.2, 0.3, 4, 0.01]).body
    assert (found["com"], found["inertia"]) == (expected.com.tolist(), expected.inertia.tolist())
    assert found["validity"]["physical"] is True
    assert found["warnings"] == []


def test_robot_text():
    outcome = run("inertia", ARM, "--at", "wrist=1,elbow=3")
    assert outcome.status == 0
    lines = outcome.out.splitlines()
    assert lines[0].endswith("meshed_arm.urdf: robot 'meshed_arm', 9 of 9 links with mass, in the frame of the base")
    assert lines[1] == "at waist 0, shoulder 0, elbow 3, wrist 1, finger_slide 0"
    assert [line.split()[0] for line in lines[5:14]][:2] == ["upper_arm", "turret"]
    assert "mass            3.734 kg" in lines
    assert "Inertia about the centre of mass [kg m^2]" in lines
    assert any(
        line.startswith("physical as a whole: no second moment is negative (I_1 + I_2 - I_3 = ") for line in lines
    )
    assert lines[-1] == "warning: joint 'elbow' at 3 rad is above its upper limit 2.2"


def test_link_from_shapes():
    found = document("inertia", *CALLS["shapes"])
    expected = link_from_shapes(load_description(ARM), "hand").body
    assert (found["mass"], found["inertia"]) == (0.0385, expected.inertia.tolist())
    text = run("inertia", *CALLS["shapes"]).out
    assert "link 'hand' from its <visual> shapes, in its own frame\n" in text
    assert "mass            0.03850 kg, as declared\n" in text
    assert run("inertia", ARM, "--link", "turret", "--geometry", "visual").out.endswith(
        "remark: twisted_block.stl: 5 faces turned to agree with neighbours\n"
    )


def test_a_comparison_of_no_link_is_a_failure_that_says_why(tmp_path):
    """As in a pipeline where the package of the meshes is not found: it must not pass."""
    path = tmp_path / "arm.urdf"
    path.write_text((ROBOTS / "meshed_arm.urdf").read_text().replace('filename="', 'filename="package://missing/'))
    outcome = run("inertia", str(path), "--compare")
    assert outcome.status == 2
    (line,) = outcome.err.splitlines()
    assert line.startswith(f"error: {path}: none of ")
    assert "could be compared (" in line
    assert "missing" in line
    assert "Not compared" in outcome.out


def test_compare_text(tmp_path):
    text = (ROBOTS / "meshed_arm.urdf").read_text().replace("meshes/", str(ROBOTS / "meshes") + "/")
    (tmp_path / "arm.urdf").write_text(text.replace("hub.stl", "no.stl", 1))
    printed = shown("inertia", str(tmp_path / "arm.urdf"), "--compare")
    table, _, rest = printed.partition("Remarks\n")
    assert "hand                    50.3" in table
    assert "turret (line 55): twisted_block.stl: 5 faces turned to agree with neighbours\n" in rest
    (missing,) = (line for line in rest.splitlines() if line.startswith("pedestal"))
    assert missing.startswith("pedestal (line 31): the mesh '")
    assert missing.endswith("no.stl' is not found")


def test_combined_meshes(boxes):
    places = ("--place", "0,0,0", "--place", "0,0,0.75,0,0,0.5")
    call = (*boxes, "--combine", *places, "--density", "1000", "--density", "500")
    found = document("inertia", *call)
    expected = box(2, 1, 0.5, density=1000) + box(1, 1, 1, density=500).placed(
        rotation_from_rpy(0, 0, 0.5), np.array([0, 0, 0.75])
    )
    assert found["combined"]["mass"] == 1500
    np.testing.assert_allclose(found["combined"]["com"], expected.com, rtol=0, atol=4 * EPS)
    limit = 16 * EPS * expected.inertia.max()
    np.testing.assert_allclose(found["combined"]["inertia"], expected.inertia, rtol=0, atol=limit)
    assert [mesh["mass"] for mesh in found["meshes"]] == [1000, 500]
    assert read_back(*call) == tuple(found["combined"][key] for key in ("mass", "com", "inertia"))


def test_combined_text_and_mass_of_the_whole(boxes):
    outcome = run("inertia", *boxes, "--combine", "--mass", "4")
    assert outcome.status == 0
    lines = outcome.out.splitlines()
    assert lines[0] == "2 meshes as one rigid body"
    assert [line.split()[0].rpartition("/")[2] for line in lines[4:6]] == ["long.stl", "cube.stl"]
    assert "mass            4.000 kg" in lines
    assert "warning: boxes of 1 pair of bodies overlap: what bodies share counts twice" in lines
    assert document("inertia", *boxes, "--combine", "--mass", "3", "--mass", "1")["combined"]["mass"] == 4


@pytest.fixture
def unfit(tmp_path: Path) -> str:
    """A robot whose whole is possible, whose hand is not; two links have an <inertial> without mass."""
    links = {"world": ZERO, "base": MASS.format(mass=5), "hand": HUGE, "tool": ZERO, "eye": ""}
    return chain(tmp_path / "arm.urdf", links)


def chain(file: Path, links: dict[str, str]) -> str:
    """A chain of these links, fixed to one another but for the hand, which turns."""
    parts = [f'<link name="{name}">{inside}</link>' for name, inside in links.items()]
    for parent, child in itertools.pairwise(links):
        kind = "revolute" if child == "hand" else "fixed"
        limit = '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="9" velocity="1"/>' if child == "hand" else ""
        ends = f'<parent link="{parent}"/><child link="{child}"/>'
        parts.append(f'<joint name="{child}_joint" type="{kind}">{ends}{limit}</joint>')
    file.write_text(f'<robot name="r">{"".join(parts)}</robot>')
    return str(file)


def test_the_verdict_of_check_is_that_of_info_and_inertia(unfit: str, tmp_path: Path) -> None:
    said = run("check", unfit).out.splitlines()[-1].partition("checked: ")[2]
    assert said.endswith(": not fit for use as it is")
    assert f"check: {said}\n" in run("info", unfit).out
    assert f"check: {said} (robodyn check {unfit})\n" in run("inertia", unfit).out
    assert "check: 1 error, " in (of_link := run("inertia", unfit, "--link", "hand").out)
    assert ": not fit for use as it is (" in of_link
    assert "check: nothing found\n" in run("inertia", unfit, "--link", "base").out
    fit = [
        json.loads(run(*call, "--format", "json").out)
        for call in (("check", unfit), ("info", unfit), ("inertia", unfit))
    ]
    assert {key: fit[0]["summary"][key] for key in fit[1]["check"]} == fit[1]["check"] == fit[2]["check"]
    assert fit[2]["check"]["fit"] is False
    assert fit[1]["counts"]["links_with_mass"] == fit[2]["links_with_mass"] == 2


def test_the_page_of_an_unfit_robot_is_not_green(unfit: str, tmp_path: Path) -> None:
    file = tmp_path / "r.html"
    assert "2 of 5 links with mass" in run("inertia", unfit, "--report", str(file)).out
    page = checked(file.read_text(encoding="utf-8"))
    (verdict,) = (each for each in page.elements if (each.attributes.get("class") or "").startswith("verdict"))
    assert verdict.attributes["class"] == "verdict bad"
    assert "1 error: not fit for use as it is" in verdict.text
    assert "link 'hand'" in verdict.text
    assert "Physically possible" not in verdict.text
    assert "2 of 5 links with mass" in page.source
    assert "links: 5, 2 with mass\n" in run("info", unfit).out
