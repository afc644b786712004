"""`robodyn view`: the page, where it goes, what opens it; of robots in every format, with and without a motion."""

from __future__ import annotations

import json
import re
import tempfile
import webbrowser
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import urlparse
from urllib.request import url2pathname

import numpy as np
import pytest
from helpers.command_line import ROBOTS, refused, run, shown, write_arm
from helpers.html_pages import Page

import robodyn
from robodyn.programs.vectors import product
from robodyn.report.torques_page import view_page
from robodyn.robot.kinematics import body_poses
from robodyn.scene.scene import GROUND

SDF = """<sdf version='1.10'><model name='m'><link name='base'/><link name='arm'/>
<joint name='turn' type='revolute'><parent>base</parent><child>arm</child>
<axis><xyz>0 0 1</xyz><limit><lower>0.5</lower><upper>2</upper></limit></axis></joint></model></sdf>"""
MJCF = """<mujoco model='m'><worldbody><body name='base'><body name='arm'>
<joint name='turn' range='0.5 2' limited='true'/><geom size='.1' mass='1'/></body></body></worldbody>
<compiler angle='radian'/></mujoco>"""
XACRO = """<robot name='m' xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:arg name='low' default='0.5'/>
<link name='base'/><link name='arm'/><joint name='turn' type='revolute'><parent link='base'/><child link='arm'/>
<axis xyz='0 0 1'/><limit lower='$(arg low)' upper='2' effort='1' velocity='1'/></joint></robot>"""
FORMATS = {"m.sdf": (SDF, ""), "m.xml": (MJCF, "mujoco"), "m.xacro": (XACRO, "xacrodoc")}


@pytest.fixture(autouse=True)
def opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What a browser was asked to open."""
    found: list[str] = []
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(webbrowser, "open", lambda url: not found.append(url))
    return found


def looks(path: Path) -> list[Any]:
    """What the page's scripts draw."""
    (text,) = re.findall(r'<script[^>]*type="application/json"[^>]*>(.*?)</script>', path.read_text("utf-8"), re.DOTALL)
    return list(json.loads(text)["looks"])


def sliders(path: Path) -> dict[str, tuple[float, float, float]]:
    (stage,) = looks(path)
    (motion,) = stage["robots"][0]["motions"]
    return {each["name"]: (each["lower"], each["value"], each["upper"]) for each in motion["sliders"]}


def test_without_a_file_to_write_a_browser_opens_it(opened: list[str]) -> None:
    line = shown("view", "arm.urdf", "--at", "elbow=0.5")
    (url,) = opened
    path = Path(url2pathname(urlparse(url).path))
    assert line == f"written: {path}, {path.stat().st_size // 1000} kB\n"
    assert sliders(path) == {"shoulder": (-3.0, 0.0, 3.0), "elbow": (-3.0, 0.5, 3.0)}
    page = Page(path.read_text(encoding="utf-8"))
    assert page.all("h1")[0].text == "arm"
    assert [row.text for row in page.all("th") if row.attributes["scope"] == "row"] == ["base", "  upper", "    fore"]


def test_a_file_is_written_and_nothing_opened(opened: list[str]) -> None:
    assert shown("view", "arm.urdf", "--report", "arm.html").startswith("written: arm.html, ")
    assert sliders(Path("arm.html"))
    assert opened == []


def test_without_a_browser_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(webbrowser, "open", lambda url: False)
    written, said = shown("view", "arm.urdf").splitlines()
    assert said == "no browser was found here: open this file in one"
    assert Path(written.removeprefix("written: ").rpartition(", ")[0]).is_file()


def test_a_motion_is_played_on_the_page_of_torques() -> None:
    shown("view", "arm.urdf", "arm.csv", "--report", "view.html")
    shown("torques", "arm.urdf", "arm.csv", "--report", "torques.html")
    assert looks(Path("view.html")) == looks(Path("torques.html"))
    (stage, *charts) = looks(Path("view.html"))
    assert stage["robots"][0]["motions"][0]["time"] is not None
    assert charts


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_has_sliders_from_the_limit_nearest_to_zero(name: str) -> None:
    text, reader = FORMATS[name]
    if reader:
        pytest.importorskip(reader)
    Path(name).write_text(text)
    shown("view", name, "--report", "m.html")
    assert sliders(Path("m.html")) == {"turn": (0.5, 0.5, 2.0)}


def test_weights_are_those_of_the_scene() -> None:
    shown("view", "arm.urdf", "--gravity", "0,0,-1.62", "--payload", "fore=3@0.1,0,0", "--report", "m.html")
    (stage,) = looks(Path("m.html"))
    arrows = stage["robots"][0]["motions"][0]["arrows"]
    assert {arrow["kind"] for arrow in arrows} == {"weight"}
    assert arrows[-1]["point"] == [0.1, 0.0, 0.0]
    assert [arrow["values"][2] for arrow in arrows] == [pytest.approx([-1.62 * mass]) for mass in (2.0, 1.0, 3.0)]


def test_loops_are_closed_at_first_and_said_to_open() -> None:
    model = robodyn.load(ROBOTS / "five_bar.urdf")
    scene = robodyn.scene_of(model, robodyn.load_scene(ROBOTS / "five_bar_reach.toml"))
    for at in (None, {"left": 0.4}):
        view, words = view_page(model, None, scene, at).blocks[:2]
        assert (
            words.text == "Loops: tip, closed at first. Sliders move the joints of the tree one by one, and open loops."
        )
        q = np.array(view.look["robots"][0]["motions"][0]["rest"])
        assert at is None or q[0] == pytest.approx(0.4)
        poses = body_poses(model, q)
        (loop,) = scene.loops
        ends = []
        for link, point in ((loop.link, loop.point), (loop.to, loop.to_point)):
            if link == GROUND:
                ends.append(np.array(point))
                continue
            frame = model.links[link]
            pose = poses[frame.body]
            ends.append(product(pose.R, product(frame.R, np.array(point)) + frame.p) + pose.p)
        assert np.abs(ends[0] - ends[1]).max() < 1e-9
    apart = replace(scene, loops=(replace(loop, to_point=(9.0, 9.0, 9.0)),))
    view, words = view_page(model, None, apart, None).blocks[:2]
    assert words.text.startswith("Loops: tip, which do not close near this pose. ")
    assert view.look["robots"][0]["motions"][0]["rest"] == [0.0] * 4


@pytest.mark.parametrize("missing", [True, False])
def test_bars_stand_for_meshes_that_are_not_there(missing: bool) -> None:
    mesh = "there.stl" if missing else str(ROBOTS / "meshes" / "bracket.stl")
    shapes = f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual>'
    Path("m.urdf").write_text(f'<robot name="m"><link name="a">{shapes}</link></robot>')
    shown("view", "m.urdf", "--report", "m.html")
    (stage,) = looks(Path("m.html"))
    assert (stage["bars"], len(stage["meshes"])) == (missing, not missing)
    text = Page(Path("m.html").read_text(encoding="utf-8")).all("main")[0].text
    assert ("not found or cannot be read, and not drawn: there.stl" in text) == missing


def test_names_of_a_robot_are_text() -> None:
    name = "</script><script>alert(1)</script>"
    escaped = name.replace("<", "&lt;")
    Path("m.urdf").write_text(f'<robot name="{escaped}"><link name="{escaped}"/></robot>')
    shown("view", "m.urdf", "--report", "m.html")
    page = Page(Path("m.html").read_text(encoding="utf-8"))
    assert page.all("h1")[0].text == name
    assert not any("alert" in script.text and "looks" not in script.text for script in page.all("script"))
    assert looks(Path("m.html"))[0]["robots"][0]["name"] == name


@pytest.mark.parametrize(
    ("call", "line"),
    [
        ("arm.urdf --report arm.md", "--report of view is an .html file"),
        ("arm.urdf arm.csv --at 0,0", "--at is for a robot without a trajectory"),
        ("arm.urdf --time-unit ms", "--time-unit goes with a trajectory"),
        ("arm.urdf --at elbw=1", "arm.urdf: no joint 'elbw' to set (did you mean 'elbow'?)"),
        ("arm.csv arm.urdf", "arm.csv: this is a table, and a robot description is expected here"),
        ("arm.urdf arm.urdf", "arm.urdf: this is a robot description, and a table is expected here"),
    ],
)
def test_wrong_calls(call: str, line: str, opened: list[str]) -> None:
    refused(run("view", *call.split()), line)
    assert opened == []
