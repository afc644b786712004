"""`robodyn inertia` of descriptions and of meshes combined: what it prints, and which calls it refuses."""

from __future__ import annotations

import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from helpers import mesh_samples
from helpers.command_line import ROBOTS, run, shown
from helpers.html_pages import checked

from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.load import load_description
from robodyn.robot.masses.declared import robot_inertia
from robodyn.robot.masses.shapes import link_from_shapes
from robodyn.solids.inertia.solids import box

EPS = np.finfo(float).eps
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
    names = []
    for name, size in (("long.stl", (2, 1, 0.5)), ("cube.stl", (1, 1, 1))):
        (tmp_path / name).write_bytes(mesh_samples.binary_stl(mesh_samples.box(size)))
        names.append(str(tmp_path / name))
    return names


def document(*call):
    text = shown("inertia", *call, "--format", "json")
    return json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


def read_back(*call):
    """The inertial element that is printed, as our reader has it."""
    text = shown("inertia", *call, "--format", "urdf")
    found = load_description(f'<robot name="r"><link name="a">{text}</link></robot>'.encode()).links[0].inertial
    xx, xy, xz, yy, yz, zz = found.inertia
    return found.mass, list(found.origin.xyz), [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_urdf_reads_back_as_the_json_has_it(call):
    found = document(*call)
    assert read_back(*call) == (found["mass"], found["com"], found["inertia"])


def test_robot_json():
    found = document(*CALLS["robot"])
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
    found = document(*CALLS["shapes"])
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
    found = document(*boxes, "--combine", *places, "--density", "1000", "--density", "500")
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
