"""`robodyn info`: counts, tree, mass and centre, meshes, findings, and what to run next."""

from __future__ import annotations

from functools import partial
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ARM, document, run, shown

EPS = float(np.finfo(float).eps)
BODY = '<inertial><mass value="{mass}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
JOINT = '<joint name="{name}" type="{type}"><parent link="{parent}"/><child link="{child}"/>{rest}</joint>'


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    Path("arm.urdf").write_text(ARM)


def robot(*parts: str) -> str:
    Path("robot.urdf").write_text(f'<robot name="r">{"".join(parts)}</robot>')
    return "robot.urdf"


def link(name: str, inside: str = "") -> str:
    return f'<link name="{name}">{inside}</link>'


def joint(name: str, kind: str, parent: str, child: str, rest: str = "") -> str:
    return JOINT.format(name=name, type=kind, parent=parent, child=child, rest=rest)


found = partial(document, "info")


def test_text() -> None:
    text = shown("info", "arm.urdf")
    assert text == (
        "arm.urdf: robot 'arm'\n"
        "links: 3, 2 with mass\n"
        "joints: 2 (2 revolute)\n"
        "degrees of freedom: 2\n"
        "mass: 3.000 kg, centre of mass (0.3000, 0, 0.006667) m in the frame of 'base', where every joint is zero\n"
        "\n"
        "link      mass [kg]  joint     type      axis   lower      upper     effort     velocity\n"
        "base\n"
        "  upper       2.000  shoulder  revolute  y     -3.000  3.000 rad  50.00 N m  5.000 rad/s\n"
        "    fore      1.000  elbow     revolute  y     -3.000  3.000 rad  50.00 N m  5.000 rad/s\n"
        "\n"
        "meshes: none\n"
        "check: 0 errors, 1 warning, 0 notes\n"
        "\n"
        "next:\n"
        "  robodyn check arm.urdf\n"
        "  robodyn fbd arm.urdf\n"
        "  robodyn torques arm.urdf motion.csv --example --report report.html\n"
    )


def test_a_joint_whose_range_does_not_hold_zero_is_at_the_limit_nearest_to_it() -> None:
    limits = ((0.5, 2.0), (-2.0, -0.25), (-1.0, 1.0))
    slides = [
        joint(f"j{k}", "prismatic", "a", f"b{k}", f'<limit lower="{low}" upper="{high}" effort="1" velocity="1"/>')
        for k, (low, high) in enumerate(limits)
    ]
    file = robot(link("a"), *(link(f"b{k}", BODY.format(mass=1)) for k in range(3)), *slides)
    document = found(file)
    assert document["at"] == {"j0": 0.5, "j1": -0.25, "j2": 0.0}
    assert document["at_zero"] is False
    assert np.abs(np.array(document["com"]) - (0.25 / 3, 0, 0)).max() <= 2 * EPS
    assert "zero or at its limit nearest to zero: j0 0.5, j1 -0.25\n" in run("info", file).out


def test_types_axes_mimics_and_the_order_of_the_tree() -> None:
    slide = '<axis xyz="0 0 -2"/><limit lower="0" upper="1" effort="3" velocity="4"/>'
    follow = '<axis xyz="0 1 1"/><mimic joint="lift" multiplier="-2" offset="0.5"/><limit effort="1" velocity="1"/>'
    file = robot(
        *(link(name, BODY.format(mass=1)) for name in "abcd"),
        joint("turn", "revolute", "a", "d", follow),
        joint("lift", "prismatic", "a", "b", slide),
        joint("weld", "fixed", "b", "c"),
    )
    document = found(file)
    counts = document["counts"]
    assert counts["joints_by_type"] == {"revolute": 1, "prismatic": 1, "fixed": 1}
    names = ("links", "mimic_joints", "merged_fixed_joints", "degrees_of_freedom", "base_degrees_of_freedom")
    assert [counts[name] for name in names] == [4, 1, 1, 1, 0]
    assert [(each["name"], each["depth"]) for each in document["links"]] == [("a", 0), ("d", 1), ("b", 1), ("c", 2)]
    turn, lift, weld = document["joints"]
    assert (turn["mimic"], turn["lower"]) == ({"joint": "lift", "multiplier": -2.0, "offset": 0.5}, None)
    assert (lift["axis"], lift["upper"], weld["axis"]) == ([0, 0, -2], 1.0, None)
    lines = run("info", file).out.splitlines()
    rows = {line.split()[0]: line for line in lines[lines.index("") + 2 :] if line}
    assert rows["d"].startswith("  d ")
    assert rows["c"].startswith("    c ")
    assert rows["d"].endswith("lift * -2 + 0.5")
    assert f"({0:.4g}, {sqrt(0.5):.4g}, {sqrt(0.5):.4g})" in rows["d"]
    assert rows["b"].split()[2:] == ["lift", "prismatic", "-z", "0", "1.000", "m", "3.000", "N", "4.000", "m/s"]


def test_meshes_found_and_missing() -> None:
    shapes = [
        f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
        for name in ("package://arms/part.stl", "lost.stl", "lost.stl")
    ]
    file = robot(link("a", BODY.format(mass=1) + "".join(shapes)))
    assert found(file)["meshes"]["references"] == 3
    missing = [each["filename"] for each in found(file)["meshes"]["missing"]]
    assert missing == ["package://arms/part.stl", "lost.stl"]
    assert "meshes: 3 in 2 files, 2 not found:\n  package://arms/part.stl (link 'a', line 1)\n" in run("info", file).out
    assert f"robodyn info {file} --package-path DIR" in found(file)["next"]
    Path("ws/arms").mkdir(parents=True)
    Path("ws/arms/part.stl").write_bytes(b"")
    document = found(file, "--package-path", "ws")
    assert [each["filename"] for each in document["meshes"]["missing"]] == ["lost.stl"]
    assert not [command for command in document["next"] if "--package-path" in command]


def test_no_centre_of_mass_is_a_note() -> None:
    note = "no centre of mass: the masses of the parts add up to zero"
    inertials = [BODY.format(mass=mass) for mass in ("1", "-1")]
    file = robot(link("a", inertials[0]), link("b", inertials[1]), joint("j", "continuous", "a", "b"))
    document = found(file)
    assert document["com"] is None
    assert document["notes"][0].startswith(note)
    assert f"note: {note}" in run("info", file).out


def test_a_floating_base_counts_its_own_freedoms() -> None:
    file = robot(link("w"), link("b", BODY.format(mass=1)), joint("j", "floating", "w", "b"))
    assert "degrees of freedom: 6, 6 of them the base's\n" in run("info", file).out
    assert found(file)["com_frame"] == "b"
    assert found(robot(link("a")))["notes"] == ["no centre of mass: the robot has no mass"]
