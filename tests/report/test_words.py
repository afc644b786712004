"""Words and tables of reports: numbers of four digits, probabilities, modes, joints that do nothing."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import run
from helpers.oracles import ROBOTS
from hypothesis import given
from hypothesis import strategies as st

from robodyn.equations.linearized.modes import Mode
from robodyn.report.document import Facts, Paragraph, Table, finite, paragraphs, remarks, text, written
from robodyn.report.equations.linearized import moves
from robodyn.report.measured import bar
from robodyn.report.motor_loads import probability
from robodyn.report.table import NEGLIGIBLE, Page, number, printable

ARM, MOTION = str(ROBOTS / "puma560.urdf"), str(ROBOTS / "puma560_sweep.csv")
SCENE = str(ROBOTS / "puma560_uncertain.toml")
LINK = """<link name="{0}"><inertial><origin xyz="0.3 0 0"/><mass value="{1}"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>"""
JOINT = """<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin rpy="{3:.{digits}f} 0 0"/>
<axis xyz="0 0 1"/><limit effort="500" velocity="5" lower="-3" upper="3"/></joint>"""
FINITE = st.floats(allow_nan=False, allow_infinity=False)


@pytest.mark.parametrize(
    ("p", "said"),
    [(1.0, "more than 99.9 %"), (0.994, "99.4 %"), (0.5, "50 %"), (0.004, "0.4 %"), (0.0, "less than 0.1 %")],
)
def test_probabilities_are_told_as_precisely_as_they_are_known(p, said):
    assert probability(p) == said


def numbers_of(text, title, joint):
    """The numbers of a joint's row in the table of this title."""
    lines = text.partition(title)[2].splitlines()
    row = next(line for line in lines if line.startswith(f"{joint} "))
    return [float(x) for x in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", row.removeprefix(joint))]


def test_text_says_what_json_says(tmp_path):
    page = tmp_path / "o.md"
    text = run("torques", ARM, MOTION, "--scene", SCENE, "--report", str(page)).out
    for said in ("uncertain parameter", "All limits are kept with", "Which parameters matter most", "mass of forearm"):
        assert said in page.read_text(encoding="utf-8")
    data = json.loads(run("torques", ARM, MOTION, "--scene", SCENE, "--format", "json").out)["uncertainty"]
    for joint in data["joints"]:
        peak, rms = joint["load"]["peak"], joint["load"]["rms"]
        found = numbers_of(text, "Error bars of 22", joint["load"]["name"])
        assert len(found) == 8
        expected = [peak["value"], peak["standard_error"], peak["low"], peak["high"]]
        assert found[:4] == pytest.approx(expected, rel=0.05)
        assert found[4:8] == pytest.approx([rms["value"], rms["standard_error"], rms["low"], rms["high"]], rel=0.05)
        assert sum(joint["load"]["shares"].values()) == pytest.approx(1.0)
    assert data["suffices"] < 0.95
    assert f"all joints   suffice with {100 * data['suffices']:.0f} %" in text
    assert "with the parameters as they are given" in text
    assert "probability of" in text


@pytest.mark.parametrize(
    ("shape", "shares", "words"),
    [
        ((1.0, 0.5), (1.0, 0.2), "a 1, b 0.5"),
        ((-0.25, 1.0), (0.01, 1.0), "b 1, a 0.25 against"),
        ((1.0, 31.0), (1.0, 0.7), "a 1, b 31"),
        ((0.02, 1.0, 40.0), (0.5, 1.0, 0.9), "b 1, c 40"),
        ((1.0, 0.01), (1.0, 0.9), "a 1"),
        ((1.0, 0.5j, -0.5j), (1.0, 0.3, 0.2), "a 1, b 0.5 ahead by 90 deg, c 0.5 behind by 90 deg"),
    ],
)
def test_who_moves_how_much(shape, shares, words):
    """The first is the one that the others are measured by, whatever their units."""
    mode = Mode(-1.0, 2.0, 0.0, tuple(map(complex, shape)), shares)
    assert moves("abc"[: len(shape)], mode) == words


@pytest.mark.parametrize(("digits", "mass"), [(9, 1.0), (12, 20.0)])
def test_a_joint_that_does_nothing(digits: int, mass: float, tmp_path: Path) -> None:
    """Its axis is vertical but for the digits of a right angle, and it stands still beside one that moves."""
    quarter = np.pi / 2
    links = "".join(LINK.format(*each) for each in (("lift", 10.0 * mass), ("turn", mass)))
    joints = JOINT.format("first", "base", "lift", quarter, digits=digits)
    joints += JOINT.format("idle", "lift", "turn", -quarter, digits=digits)
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="base"/>{links}{joints}</robot>')
    time = np.arange(0.0, 2.0, 0.01)
    q = 0.2 * np.sin(3.0 * time)
    table = np.column_stack((time, q, 0.6 * np.cos(3.0 * time), -1.8 * np.sin(3.0 * time), *([0.0 * time] * 3)))
    head = "time,q_first,qd_first,qdd_first,q_idle,qd_idle,qdd_idle"
    table[:, 1:4] *= [[0.0, 0.0, 0.0]] if mass == 1.0 else [[1.0, 1.0, 1.0]]
    np.savetxt(tmp_path / "m.csv", table, delimiter=",", header=head, comments="")
    out = run("torques", str(tmp_path / "r.urdf"), str(tmp_path / "m.csv"), "--sizing").out
    if mass == 1.0:
        row = next(line for line in out.splitlines() if line.startswith("idle "))
        assert re.split(r"  +", row)[1].split()[0] == "0"
    assert not re.search(r"e-(0[89]|1\d) (N m|%)", out)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_errors_of_nothing_are_zero(scale: float) -> None:
    assert bar(4.2e-13 * scale, 4.2e-13 * scale, scale) == "0"
    assert bar(4.2e-3 * scale, 4.2e-4 * scale, scale) != "0"


@pytest.mark.parametrize(
    ("x", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (1.0, "1.000"),
        (12.3456, "12.35"),
        (999.94, "999.9"),
        (999.96, "1000"),
        (-1234567.8, "-1234568"),
        (1e7, "1.000e+07"),
        (0.001, "0.001000"),
        (0.00099999, "1.000e-03"),
        (-4.5678e-12, "-4.568e-12"),
        (1e300, "1.000e+300"),
        (5e-324, "4.941e-324"),
    ],
)
def test_number(x: float, text: str) -> None:
    assert number(x) == text


@given(FINITE, FINITE)
def test_what_vanishes_beside_the_scale_is_zero(x: float, scale: float) -> None:
    assert (number(x, scale) == "0") == (abs(x) <= NEGLIGIBLE * abs(scale))


def test_decimal_points_are_in_line_and_units_behind() -> None:
    rows = [
        ("waist", "-28.64 N m", "+- 0.5"),
        ("z", "117.1 N", ""),
        ("tip", "0.003 N m", "+- 12.25"),
        ("o", "5 N", "-"),
    ]
    assert Page().table((("joint", "peak", "noise"), rows)).splitlines() == [
        "joint         peak      noise",
        "waist  -28.64  N m   +- 0.5",
        "z      117.1   N",
        "tip      0.003 N m  +- 12.25",
        "o        5     N            -",
    ]  # without blanks at the ends


def test_columns_that_do_not_fit_follow_below() -> None:
    rows = [(f"joint {i}", "1.25 N m", "2.5", "3.75", "99% of 5") for i in range(3)]
    head = ("joint", "peak", "RMS", "mean", "of limit")
    narrow = Page(24).table((head, rows))
    assert max(map(len, narrow.splitlines())) <= 24
    pages = narrow.split("\n\n")
    assert len(pages) > 1
    assert all(
        [line.split("  ")[0] for line in page.splitlines()] == ["joint", *(r[0] for r in rows)] for page in pages
    )
    assert sorted(re.findall(r"peak|RMS|mean|of limit", narrow)) == sorted(head[1:])
    assert Page(200).table((head, rows)) == Page().table((head, rows))


def test_wide_and_combining_characters() -> None:
    lines = Page().table((("name", "x"), [("\u8155", "1.0"), ("e\u0301", "1.0"), ("ab", "1.0")])).splitlines()
    assert [line.index("1.0") for line in lines[1:]] == [5, 7, 6]


@given(st.text())
def test_printable_keeps_the_terminal_safe(text: str) -> None:
    safe = printable(text)
    assert safe.isprintable()
    if text.isprintable():
        assert safe == text


ROWS = (("name", "value"), [("a  b", "1"), ("warning: c", "2")])
SECTIONS = [
    [Paragraph("robot: 3 links")],
    [Table("Links by mass", *ROWS), Paragraph("after the table")],
    [Facts((("mass", "3 kg"), ("centre", "(0, 0) m")))],
    [],
    [Table("", *ROWS)],
    paragraphs(["escape \x1b[1m"]),
    [*remarks("warning", ["odd"]), *remarks("note", ["even"]), *remarks("repaired", [])],
]
TABLE = "name        value\na  b            1\nwarning: c      2\n"


def test_sections_stand_apart_and_tables_below_their_captions():
    assert text(SECTIONS) == (
        f"robot: 3 links\n\nLinks by mass\n{TABLE}after the table\n\nmass    3 kg\ncentre  (0, 0) m\n\n"
        f"{TABLE}\nescape \\x1b[1m\n\nwarning: odd\nnote: even\n"
    )


def test_numbers_that_are_none() -> None:
    assert [finite(x) for x in (1.5, np.inf, -np.inf, np.nan, None)] == [1.5, None, None, None, None]
    for value in (np.inf, np.nan):
        with pytest.raises(ValueError, match="JSON"):
            written({"x": np.array([value])})
