"""`robodyn inertia` of descriptions and of meshes combined: what it prints, and which calls it refuses."""

from __future__ import annotations

import json
import math
import subprocess
import sys

import numpy as np
import pytest
from helpers import mesh_samples
from helpers.command_line import ROBOTS, run
from helpers.terminals import on_terminal

from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.masses.declared import robot_inertia
from robodyn.robot.masses.shapes import link_from_shapes
from robodyn.robot.urdf.description import load_description
from robodyn.solids.inertia.solids import box

EPS = np.finfo(float).eps
ARM = str(ROBOTS / "meshed_arm.urdf")
BODY = ["mass", "volume", "area", "density", "com", "inertia", "inertia_about", "principal"]


@pytest.fixture
def boxes(tmp_path):
    """Two boxes as files."""
    names = []
    for name, size in (("long.stl", (2, 1, 0.5)), ("cube.stl", (1, 1, 1))):
        (tmp_path / name).write_bytes(mesh_samples.binary_stl(mesh_samples.box(size)))
        names.append(str(tmp_path / name))
    return names


def document(*call):
    outcome = run("inertia", *call, "--format", "json")
    assert (outcome.status, outcome.err) == (0, "")
    return json.loads(outcome.out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


def read_back(*call):
    """The inertial element that is printed, as our reader has it."""
    outcome = run("inertia", *call, "--format", "urdf")
    assert (outcome.status, outcome.err) == (0, "")
    found = load_description(f'<robot name="r"><link name="a">{outcome.out}</link></robot>'.encode()).links[0].inertial
    xx, xy, xz, yy, yz, zz = found.inertia
    return found.mass, list(found.origin.xyz), [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]


CALLS = {
    "robot": (ARM, "--at", "0.1,-0.2,0.3,4,0.01"),
    "link": (ARM, "--link", "upper_arm"),
    "shapes": (ARM, "--link", "hand", "--geometry", "visual"),
    "collision": (ARM, "--link", "hand", "--geometry", "collision", "--density", "2700"),
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_urdf_reads_back_as_the_json_has_it(call):
    found = document(*call)
    assert read_back(*call) == (found["mass"], found["com"], found["inertia"])


def test_robot_json():
    found = document(*CALLS["robot"])
    assert list(found) == ["robot", "file", "at", *BODY, "validity", "check", "links_with_mass", "links", "warnings"]
    assert found["at"] == {"waist": 0.1, "shoulder": -0.2, "elbow": 0.3, "wrist": 4.0, "finger_slide": 0.01}
    assert list(found["links"][0]) == ["link", "line", *BODY, "validity", "pose", "com_in_base"]
    assert math.fsum(link["mass"] for link in found["links"]) == pytest.approx(found["mass"], rel=2 * EPS)
    expected = robot_inertia(load_description(ARM), [0.1, -0.2, 0.3, 4, 0.01]).body
    assert (found["com"], found["inertia"]) == (expected.com.tolist(), expected.inertia.tolist())
    assert found["validity"]["physical"] is True
    assert found["warnings"] == []


def test_robot_by_name_about_the_origin_in_turned_axes():
    at = ("--at", "shoulder=-0.2,elbow=0.3")
    found = document(ARM, *at, "--about", "origin", "--rpy", "0.1,0.2,0.3")
    assert found["at"]["shoulder"] == -0.2
    c, I, m = np.array(found["com"]), np.array(found["inertia"]), found["mass"]
    R = rotation_from_rpy(0.1, 0.2, 0.3)
    expected = R.T @ (I + m * (c @ c * np.eye(3) - np.outer(c, c))) @ R
    np.testing.assert_allclose(found["inertia_about"]["matrix"], expected, rtol=0, atol=16 * EPS * expected.max())


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


def test_link_text():
    outcome = run("inertia", str(ROBOTS / "puma560.urdf"), "--link", "forearm")
    assert outcome.status == 0
    assert "puma560.urdf:116: link 'forearm' as declared, in its own frame\n" in outcome.out
    assert (
        "\nnot physical: principal moments 0.0125 + 0.066 < 0.086 kg m^2 break the triangle inequality (" in outcome.out
    )


def test_link_from_shapes():
    found = document(*CALLS["shapes"])
    assert list(found) == ["robot", "link", "line", "geometry", *BODY, "validity", "box", "meshes", "warnings"]
    expected = link_from_shapes(load_description(ARM), "hand").body
    assert (found["mass"], found["inertia"]) == (0.0385, expected.inertia.tolist())
    text = run("inertia", *CALLS["shapes"]).out
    assert "link 'hand' from its <visual> shapes, in its own frame\n" in text
    assert "mass            0.03850 kg, as declared\n" in text
    assert run("inertia", ARM, "--link", "turret", "--geometry", "visual").out.endswith(
        "remark: twisted_block.stl: 5 faces turned to agree with neighbours\n"
    )


def test_compare_json():
    found = document(ARM, "--compare")
    assert list(found) == ["robot", "file", "geometry", "links"]
    assert found["geometry"] == "visual"
    hand = next(link for link in found["links"] if link["link"] == "hand")
    assert list(hand) == ["link", "line", "shapes", "declared", "derived", "difference", "reason", "remarks"]
    keys = ["density", "com_distance", "com_offset", "moment_ratios", "inertia", "box_spread"]
    assert list(hand["difference"]) == keys
    assert hand["shapes"][0]["filename"] == "meshes/bracket.stl"
    assert hand["derived"]["inertia"][0][2] == -hand["declared"]["inertia"][0][2]
    compared = [link["difference"]["inertia"] for link in found["links"] if link["difference"]]
    certain = [difference if difference > 1e-9 else 0.0 for difference in compared]
    assert certain == sorted(certain, reverse=True)
    assert document(ARM, "--compare", "--geometry", "collision")["geometry"] == "collision"


@pytest.mark.parametrize("form", ["text", "json"])
def test_a_comparison_of_no_link_is_a_failure_that_says_why(tmp_path, form):
    """As in a pipeline where the package of the meshes is not found: it must not pass."""
    path = tmp_path / "arm.urdf"
    path.write_text((ROBOTS / "meshed_arm.urdf").read_text().replace('filename="', 'filename="package://missing/'))
    outcome = run("inertia", str(path), "--compare", "--format", form)
    assert outcome.status == 2
    (line,) = outcome.err.splitlines()
    assert line.startswith(f"error: {path}: none of ")
    assert "could be compared (" in line
    assert "missing" in line
    assert ("Not compared" if form == "text" else '"links"') in outcome.out


def test_compare_text(tmp_path):
    text = (ROBOTS / "meshed_arm.urdf").read_text().replace("meshes/", str(ROBOTS / "meshes") + "/")
    (tmp_path / "arm.urdf").write_text(text.replace("hub.stl", "no.stl", 1))
    outcome = run("inertia", str(tmp_path / "arm.urdf"), "--compare")
    assert (outcome.status, outcome.err) == (0, "")
    table, _, rest = outcome.out.partition("Remarks\n")
    assert "hand                    50.3" in table
    assert "turret (line 55): twisted_block.stl: 5 faces turned to agree with neighbours\n" in rest
    (missing,) = (line for line in rest.splitlines() if line.startswith("pedestal"))
    assert missing.startswith("pedestal (line 31): the mesh '")
    assert missing.endswith("no.stl' is not found")


def test_packages_are_found_where_the_option_says(tmp_path):
    """The folder of robots, under the name of a package."""
    text = (ROBOTS / "meshed_arm.urdf").read_text().replace("meshes/", "package://arm_description/meshes/")
    (tmp_path / "arm.urdf").write_text(text)
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "arm_description").symlink_to(ROBOTS)
    call = (str(tmp_path / "arm.urdf"), "--link", "hand", "--geometry", "visual")
    refused = run("inertia", *call)
    assert (refused.status, refused.out) == (2, "")
    assert refused.err == (
        f"error: {tmp_path / 'arm.urdf'}:134: the mesh 'package://arm_description/meshes/bracket.stl' is not found "
        "(--package-path DIR names the package 'arm_description' or the folder it is in)\n"
    )
    assert document(*call, "--package-path", str(tmp_path / "src"))["mass"] == 0.0385


def test_a_description_from_standard_input():
    data = (ROBOTS / "puma.urdf").read_bytes()
    outcome = run("inertia", "-", "--type", "urdf", "--format", "json", stdin=data)
    assert json.loads(outcome.out)["mass"] == document(str(ROBOTS / "puma.urdf"))["mass"]


def test_combined_meshes(boxes):
    places = ("--place", "0,0,0", "--place", "0,0,0.75,0,0,0.5")
    found = document(*boxes, "--combine", *places, "--density", "1000", "--density", "500")
    assert list(found) == ["meshes", "combined"]
    assert list(found["combined"]) == [*BODY, "box", "places", "warnings"]
    expected = box(2, 1, 0.5, density=1000) + box(1, 1, 1, density=500).placed(
        rotation_from_rpy(0, 0, 0.5), np.array([0, 0, 0.75])
    )
    assert found["combined"]["mass"] == 1500
    np.testing.assert_allclose(found["combined"]["com"], expected.com, rtol=0, atol=4 * EPS)
    limit = 16 * EPS * expected.inertia.max()
    np.testing.assert_allclose(found["combined"]["inertia"], expected.inertia, rtol=0, atol=limit)
    assert [mesh["mass"] for mesh in found["meshes"]] == [1000, 500]
    call = (*boxes, "--combine", *places, "--density", "1000", "--density", "500")
    assert read_back(*call) == tuple(found["combined"][key] for key in ("mass", "com", "inertia"))


def test_combined_text_and_mass_of_the_whole(boxes):
    outcome = run("inertia", *boxes, "--combine", "--mass", "4")
    assert outcome.status == 0
    lines = outcome.out.splitlines()
    assert lines[0] == "2 meshes as one rigid body"
    assert [line.split()[0].rpartition("/")[2] for line in lines[4:6]] == ["long.stl", "cube.stl"]
    assert "mass            4.000 kg" in lines
    assert "warning: boxes of 1 pair of bodies overlap: what bodies share counts twice" in lines
    assert document(*boxes, "--combine", "--mass", "3", "--mass", "1")["combined"]["mass"] == 4


def test_units_and_densities_for_each_mesh(boxes):
    first, second = document(*boxes, "--unit", "m", "--unit", "cm", "--mass", "1", "--mass", "2")["meshes"]
    assert (first["volume"], first["mass"], second["mass"]) == (1, 1, 2)
    assert second["volume"] == pytest.approx(1e-6, rel=4 * EPS)


WRONG = [
    ((ARM, "--unit", "mm"), "--unit is not for a whole robot, but for meshes (try: robodyn inertia --help)"),
    ((ARM, "--density", "1"), "--density is not for a whole robot"),
    ((ARM, "--geometry", "visual"), "--geometry is not for a whole robot"),
    ((ARM, "--combine"), "--combine is not for a whole robot"),
    ((ARM, "--link", "hand", "--at", "1"), "--at is not for a link as declared"),
    ((ARM, "--link", "hand", "--density", "1"), "--density is not for a link as declared"),
    ((ARM, "--link", "hand", "--geometry", "visual", "--shell", "1"), "--shell is not for a link's shapes"),
    ((ARM, "--compare", "--about", "origin"), "--about is not for --compare"),
    ((ARM, "--compare", "--link", "hand"), "--link is not for --compare"),
    (
        (ARM, "--compare", "--format", "urdf"),
        "--format urdf is not for --compare; --link NAME --geometry",
    ),
    ((ARM, ARM), "a URDF stands alone: one robot at a time, and no meshes beside it"),
    ((ARM, "part.stl"), "a URDF stands alone"),
    ((ARM, "--at", "1,2"), f"{ARM}: 2 values for 5 coordinates (in the order: 'waist', 'shoulder', 'elbow', 'wrist', "),
    ((ARM, "--at", "elbw=1"), f"{ARM}: no joint 'elbw' to set (did you mean 'elbow'?)"),
    ((ARM, "--at", "right_finger_slide=1"), f"{ARM}: no joint 'right_finger_slide' to set (it follows 'finger_slide')"),
    ((ARM, "--at", "1,2,3,4,5,6"), f"{ARM}: 6 values for 5 coordinates"),
    ((ARM, "--at", "elbow=1,elbow=2"), "invalid value for '--at': 'elbow=1,elbow=2' names 'elbow' twice"),
    ((ARM, "--at", "nan"), "invalid value for '--at': 'nan' is neither numbers"),
    ((ARM, "--at", "elbow=,"), "invalid value for '--at'"),
    ((ARM, "--at", "=1"), "invalid value for '--at'"),
    ((ARM, "--link", "hnad"), f"{ARM}: there is no link 'hnad' (did you mean 'hand'?)"),
    ((ARM, "--link", "hand", "--geometry", "visual", "--density", "1", "--mass", "1"), "both a density and a mass"),
    (
        (ARM, "--link", "hand", "--geometry", "visual", "--mass", "1", "--mass", "1"),
        "--mass is given 2 times for 1",
    ),
    ((ARM, "--link", "turret", "--geometry", "visual", "--strict"), "5 faces turned to agree with neighbours"),
    (
        (ARM, "--compare", "--package-path", "nowhere"),
        "invalid value for '--package-path': 'nowhere': there is no such folder",
    ),
    (("no.urdf",), "no.urdf: there is no such file"),
    (("a.stl", "--place", "0,0,0"), "--place is not for meshes one by one"),
    (("a.stl", "--at", "1"), "--at is not for meshes one by one"),
    (("a.stl", "--combine", "--link", "x"), "--link is not for --combine"),
    (("a.stl", "--combine", "--place", "0,0"), "invalid value for '--place': '0,0' is not three or six finite numbers"),
    (("a.stl", "--density", "1", "--density", "2"), "--density is given 2 times for 1 mesh (give it once, or once for"),
    (("a.stl", "b.stl", "--combine", "--mass", "1", "--density", "2"), "both a density and a mass are given"),
]


@pytest.mark.parametrize(("call", "line"), WRONG, ids=[" ".join(call).replace(ARM, "arm") for call, _ in WRONG])
def test_wrong_calls(call, line):
    outcome = run("inertia", *call)
    assert (outcome.status, outcome.out, outcome.err.count("\n")) == (2, "", 1)
    assert line in outcome.err


def test_places_that_do_not_fit(boxes):
    outcome = run("inertia", *boxes, "--combine", "--place", "0,0,0")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "error: 1 places for 2 meshes (give one for each mesh, in order)\n"


def test_the_repair_of_a_part_is_said_in_a_combination(tmp_path):
    box_ = mesh_samples.box()
    (tmp_path / "in.stl").write_bytes(mesh_samples.binary_stl(mesh_samples.flipped(box_)))
    outcome = run("inertia", str(tmp_path / "in.stl"), "--combine")
    assert f"repaired: {tmp_path / 'in.stl'}: 1 shell turned outwards\n" in outcome.out


def with_bar(*call):
    """The command with a progress bar for files of any length."""
    code = "import robodyn.cli.progress as p; p.LONG_MESHES = 0; from robodyn.cli.main import main; main()"
    return [sys.executable, "-c", code, "inertia", *call, "--format", "json"]


@pytest.mark.parametrize("call", [(ARM, "--compare"), (str(ROBOTS / "meshes" / "hub.stl"),)], ids=["robot", "mesh"])
def test_progress_is_shown_on_a_terminal_alone(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shown, piped = on_terminal(with_bar(*call), stdout=False, stderr=True)
    assert "measuring" in shown
    assert json.loads(piped) == document(*call)
    done = subprocess.run(with_bar(*call), capture_output=True, check=True)
    assert done.stderr == b""
    call_as_is = [part.replace("p.LONG_MESHES = 0; ", "") for part in with_bar(*call)]
    assert on_terminal(call_as_is, stdout=False, stderr=True)[0] == ""
