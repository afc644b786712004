"""`check`, `info` and `inertia` judge a description in the same words, and count its links in the same way."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pytest
from helpers.command_line import run
from helpers.html_pages import checked

BODY = '<inertial><mass value="{mass}"/><inertia ixx=".02" ixy="0" ixz="0" iyy=".03" iyz="0" izz=".04"/></inertial>'
ZERO = '<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
BOX = '<visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>'
HUGE = (
    '<inertial><mass value="2"/><inertia ixx="0.8" ixy="0" ixz="0" iyy="0.8" iyz="0" izz="0.8"/></inertial>'
    f'{BOX}<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
)
"""An inertia of 240 times that of the box."""


@pytest.fixture
def unfit(tmp_path: Path) -> str:
    """A robot whose whole is possible, whose hand is not; two links have an <inertial> without mass."""
    links = {"world": ZERO, "base": BODY.format(mass=5), "hand": HUGE, "tool": ZERO, "eye": ""}
    return robot(tmp_path / "arm.urdf", links)


def robot(file: Path, links: dict[str, str]) -> str:
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


@pytest.mark.parametrize("more", [(), ("--link", "hand")])
def test_the_page_of_an_unfit_robot_is_not_green(unfit: str, tmp_path: Path, more: tuple[str, ...]) -> None:
    file = tmp_path / "r.html"
    assert run("inertia", unfit, *more, "--report", str(file)).status == 0
    page = checked(file.read_text(encoding="utf-8"))
    (verdict,) = (each for each in page.elements if (each.attributes.get("class") or "").startswith("verdict"))
    assert verdict.attributes["class"] == "verdict bad"
    assert "1 error: not fit for use as it is" in verdict.text
    assert "link 'hand'" in verdict.text
    assert "Physically possible" not in verdict.text


def test_a_fit_robot_is_possible(tmp_path: Path) -> None:
    report = tmp_path / "r.md"
    out = run("inertia", robot(tmp_path / "one.urdf", {"one": BODY.format(mass=1)}), "--report", str(report)).out
    assert "check: nothing found\n" in out
    assert "**✅ Physically possible**" in report.read_text(encoding="utf-8")


def test_links_with_mass_are_counted_in_one_way(unfit: str, tmp_path: Path) -> None:
    file = tmp_path / "r.md"
    assert "links: 5, 2 with mass\n" in run("info", unfit).out
    assert "2 of 5 links with mass" in run("inertia", unfit, "--report", str(file)).out
    assert "2 of 5 links with mass" in file.read_text(encoding="utf-8")
    counted = json.loads(run("info", unfit, "--format", "json").out)["counts"]["links_with_mass"]
    assert counted == json.loads(run("inertia", unfit, "--format", "json").out)["links_with_mass"] == 2
