"""Results in notebooks: lines, tables, a frame of the joints, and the page of a robot."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.html_pages import Page
from helpers.oracles import ROBOTS

import robodyn
from robodyn.loads.result import JointLoad

TX40 = Path(__file__).parents[1] / "data" / "tx40_log"
PUMA = robodyn.load(ROBOTS / "puma560.urdf")
STRANGE = "</td><script>alert(1)</script>\u202e"


@pytest.fixture(scope="module")
def results() -> dict[str, Any]:
    tx40 = robodyn.load(TX40 / "tx40.urdf")
    return {
        "Model": PUMA,
        "Result": robodyn.torques(PUMA, str(ROBOTS / "puma560_sweep.csv")),
        "Linearized": robodyn.linearize(PUMA, step=0.01),
        "Log": robodyn.read_log(str(TX40 / "log.parquet"), tx40),
    }


def cells(value: Any) -> list[list[str]]:
    """The rows of its table, without the header."""
    page = Page(value._repr_html_())
    wide = len(page.all("th"))
    texts = [cell.text for cell in page.all("td")]
    assert len(texts) % wide == 0
    return [texts[k : k + wide] for k in range(0, len(texts), wide)]


@pytest.mark.parametrize("name", ["Model", "Result", "Linearized", "Log"])
def test_three_lines_and_a_short_table(name: str, results: dict[str, Any]) -> None:
    text = repr(results[name])
    assert text.startswith(f"<{name} ")
    assert text.endswith(">")
    assert text.count("\n") <= 2
    assert len(text) < 500
    page = Page(results[name]._repr_html_())
    assert page.all("p")[0].text == text[1:-1].replace("\n ", "")
    assert len(page.source) < 6000
    assert cells(results[name])


def test_tables_have_the_figures(results: dict[str, Any]) -> None:
    upper_arm = ["upper_arm", "17.4", "shoulder", "revolute", "-0.78", "3.92", "186.4", "1.5", "rad, N m, rad/s"]
    assert cells(results["Model"])[2] == upper_arm
    assert cells(results["Result"])[1] == ["shoulder", "N m", "53.24", "1.94", "33.81", "186.4", "-0.8639", "1.5"]
    assert [row[0] for row in cells(results["Log"])] == [f"joint_{k}" for k in range(1, 7)]
    assert {tuple(row[3:]) for row in cells(results["Log"])} == {("-", "-")}
    modes = results["Linearized"].modes.modes
    rows = cells(results["Linearized"])
    assert [float(row[4]) for row in rows] == pytest.approx([mode.real for mode in modes], rel=1e-3, abs=1e-6)
    assert [row[3] for row in rows[:3]] == ["-"] * 3  # neither grows nor decays


def test_words_say_what_is_so(results: dict[str, Any]) -> None:
    assert repr(results["Result"]).endswith("within all limits; 2 warnings>")
    assert "12 states, 6 inputs, in steps of 0.01 s" in repr(results["Linearized"])
    assert "6 of 6 torques measured, 4500 samples from 0 to 8.998 s" in repr(results["Log"])
    fast = robodyn.motion(PUMA, np.arange(50) / 50, q=np.sin(np.arange(50) / 5)[:, None] * np.ones(6))
    assert "\n beyond limits; " in repr(robodyn.torques(PUMA, fast))


def test_a_frame_has_a_row_for_each_joint(results: dict[str, Any]) -> None:
    joints, frame = results["Result"].joints, results["Result"].to_frame()
    numbers = {each.name for each in fields(JointLoad)} - {"shares"}
    assert set(frame.columns) == numbers | {"effort_margin", "velocity_margin"}
    assert frame["name"].to_list() == [joint.name for joint in joints]
    for name in frame.columns:
        assert frame[name].to_list() == [getattr(joint, name) for joint in joints]
    kinds = {str(kind) for name, kind in frame.schema.items() if name not in ("name", "unit")}
    assert kinds == {"Float64", "Int64"}


def test_what_no_joint_has_is_null_of_numbers() -> None:
    robot = robodyn.load(
        b'<robot name="r"><link name="a"/><link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" '
        b'ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="j" type="continuous"><parent link="a"/>'
        b'<child link="b"/></joint></robot>'
    )
    frame = robodyn.torques(robot, robodyn.motion(robot, np.arange(9.0), q=np.zeros((9, 1)))).to_frame()
    assert frame["effort_limit"].to_list() == [None]
    assert str(frame.schema["effort_limit"]) == "Float64"


def test_names_are_text_in_tables() -> None:
    escaped = STRANGE.replace("<", "&lt;").encode()
    model = robodyn.load(b'<robot name="%s"><link name="%s"/></robot>' % (escaped, escaped))
    page = Page(model._repr_html_())
    assert not page.all("script")
    assert cells(model)[0][0] == "</td><script>alert(1)</script>\\u202e"


def test_a_long_table_is_cut() -> None:
    links = "".join(f'<link name="l{k}"/>' for k in range(71))
    joints = "".join(
        f'<joint name="j{k}" type="continuous"><parent link="l{k}"/><child link="l{k + 1}"/></joint>' for k in range(70)
    )
    page = Page(robodyn.load(f"<robot name='r'>{links}{joints}</robot>".encode())._repr_html_())
    assert page.all("td")[-1].text == "and 11 more"
    assert len(page.all("tr")) == 1 + 60 + 1


def test_a_view_is_the_page_in_a_frame() -> None:
    view = robodyn.view(PUMA, at={"elbow": 0.5})
    assert repr(view) == "View(name='puma560')"
    (frame,) = Page(view._repr_html_()).all("iframe")
    assert frame.attributes["srcdoc"] == view.html
    assert frame.attributes["sandbox"] == "allow-scripts"
    assert "Along the motion" in robodyn.view(PUMA, str(ROBOTS / "puma560_sweep.csv")).html
