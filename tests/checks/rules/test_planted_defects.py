"""Each planted defect is found by its rule alone, once, at the line and column of the attribute, in words that help."""

from __future__ import annotations

from math import radians

import pytest
from helpers.planted_defects import DEFECTS, HEALTHY, HERE, MEASURED, MESSAGES, SOUND, Defect, findings, of_code

from robodyn.checks.check import Options, check_one, found_in
from robodyn.checks.examples import arm
from robodyn.checks.fixes import fixed
from robodyn.checks.rule import Severity

IDS = [f"{defect.code}-{k}" for k, defect in enumerate(DEFECTS)]
N, W, E = Severity.NOTE, Severity.WARNING, Severity.ERROR


@pytest.mark.parametrize("defect", DEFECTS, ids=IDS)
def test_found_once_at_its_place_and_by_no_other_rule(defect: Defect) -> None:
    finding = of_code(defect.text, defect.code)
    if HERE in defect.new:
        assert (finding.line, finding.column) == defect.place
    others = [other for other in findings(defect.text) if other.code != defect.code]
    not_there = {"RD601"} if "package://a/" in defect.text else set()  # of text without a file it is not known where
    assert {other.code for other in others if other.severity is not N} <= not_there
    assert finding.message
    assert finding.remedy
    assert "  " not in finding.message + finding.remedy
    assert not finding.measured or any(character.isdigit() for character in finding.message)


def test_a_range_in_degrees_is_an_error() -> None:
    text = arm('<axis xyz="0 1 0"/><limit lower="-90" upper="90" effort="30" velocity="3"/>')
    assert of_code(text, "RD507").severity is E


@pytest.mark.parametrize("change", SOUND, ids=[change.new[:50] for change in SOUND])
def test_what_is_sound_stays_unfound(change: Defect) -> None:
    """But for a remark that some program refuses it: MuJoCo an empty <collision>, Drake lower > upper."""
    found = findings(change.text)
    assert {finding.code for finding in found if finding.severity is not N} == set()
    assert {finding.code for finding in found} <= {"RD211", "RD901"}


def test_words() -> None:
    for defect, words in MESSAGES:
        finding = of_code(defect.text, defect.code)
        assert words in f"{finding.message} ({finding.remedy})"


@pytest.mark.parametrize(("defect", "measured", "bound"), MEASURED, ids=[defect.code for defect, *_ in MEASURED])
def test_measured_value_and_bound(defect: Defect, measured: float, bound: float | None) -> None:
    finding = of_code(defect.text, defect.code)
    assert finding.measured == pytest.approx(measured, rel=1e-14, abs=0)
    assert finding.bound == (None if bound is None else pytest.approx(bound, rel=1e-14, abs=0))


@pytest.mark.parametrize(
    ("encoding", "newline"), [("utf-8-sig", "\n"), ("utf-16", "\r\n"), ("utf-16-le", "\r"), ("utf-16-be", "\n")]
)
def test_places_in_other_encodings_and_line_ends(encoding: str, newline: str) -> None:
    for defect in (one for one in DEFECTS[::17] if HERE in one.new):
        data = defect.text.replace("\n", newline).encode(encoding)
        (finding,) = [finding for finding in check_one(data) if finding.code == defect.code]
        assert (finding.line, finding.column) == defect.place


def test_columns_count_characters_and_a_tab_is_one() -> None:
    line = "<link name='é𝄞'>\t<inertial><mass value='-1'/></inertial></link>"
    finding = of_code(f"<robot name='r'>\n{line}</robot>", "RD201")
    assert (finding.line, finding.column) == (2, line.index("-1") + 1)
    text = '<?xml version="1.0" encoding="ISO-8859-1"?><robot name="é"><link name="ü">ß<visual nam="x"/></link></robot>'
    (finding,) = [finding for finding in check_one(text.encode("latin-1")) if finding.code == "RD005"]
    assert (finding.line, finding.column) == (1, text.index("nam=") + 1)
    assert finding.excerpt.text[finding.excerpt.start :].startswith('nam="x"')


@pytest.mark.parametrize(
    ("inside", "expected"),
    [
        ('<orgin xyz="0 0 1"/>', W),
        ('<rotor_inertia value="1"/>', W),
        ("<self_filter/>", N),
        ('<visual nam="x"/>', W),
        ('<visual xyz="0 0 1"/>', W),
        ('<visual colour="x"/>', N),
        ('<visual name="v" nam="x"/>', N),
    ],
)
def test_names_that_were_meant_for_urdf_are_warnings_and_others_remarks(inside: str, expected: Severity) -> None:
    assert of_code(f'<robot name="r"><link name="l">{inside}</link></robot>', "RD005").severity is expected


_ZERO = '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
_LIMITS = 'lower="-2.9" upper="2.8"'
_SOFT = 'soft_lower_limit="-2.85" soft_upper_limit="2.75"'


@pytest.mark.parametrize(
    ("defect", "severity"),
    [
        (('<mass value="3.5"/>', '<mass value="0"/>'), ("RD201", W)),
        (('<mass value="3.5"/>', '<mass value="-0.1"/>'), ("RD201", E)),
        (('<inertia ixx="4e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="6e-4"/>', _ZERO), ("RD204", N)),
        (('<inertia ixx="0.05" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.07"/>', _ZERO), ("RD204", W)),
        (('<inertia ixx="0.003" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0035"/>', _ZERO), ("RD204", E)),
        ((_LIMITS, 'lower="-2.9" upper="12.5"'), ("RD507", N)),
        ((_LIMITS, 'lower="-2.9" upper="12.6"'), ("RD507", W)),
    ],
)
def test_severity_follows_the_rigid_group(defect: tuple[str, str], severity: tuple[str, Severity]) -> None:
    assert HEALTHY.count(defect[0]) == 1
    assert severity in [(finding.code, finding.severity) for finding in findings(HEALTHY.replace(*defect))]


def mended(text: str) -> str:
    given = Options(select=("RD507",))
    return fixed(text.encode(), "arm.urdf", lambda data: check_one(data, given), unsafe=True).after.decode()


@pytest.mark.parametrize(("limits", "soft"), [(("-170", "10"), None), (("-5", "90"), ("0", "85"))])
def test_both_ends_of_a_range_are_turned(limits: tuple[str, str], soft: tuple[str, str] | None) -> None:
    text, after = HEALTHY, HEALTHY
    names = ("soft_lower_limit", "soft_upper_limit")
    for old, ends, new in ((_LIMITS, ("lower", "upper"), limits), (_SOFT, names, soft or ("0", "0"))):
        given = list(zip(ends, new, strict=True))
        text = text.replace(old, " ".join(f'{name}="{value}"' for name, value in given))
        after = after.replace(old, " ".join(f'{name}="{radians(float(value))!r}"' for name, value in given))
    assert of_code(text, "RD507").cause == "written in degrees"
    assert mended(text) == after


@pytest.mark.parametrize(
    "text",
    [
        HEALTHY.replace(_LIMITS, 'lower="-90" upper="91"').replace(_SOFT, ""),
        HEALTHY.replace(_LIMITS, 'lower="-90" upper="90"'),
        HEALTHY.replace(_LIMITS, 'lower="-90" upper="a"').replace(_SOFT, ""),
        HEALTHY.replace(_LIMITS, 'lower="-1000" upper="1000"').replace(_SOFT, ""),
    ],
    ids=["not round", "soft limits in radians", "unreadable", "beyond two turns"],
)
def test_or_neither(text: str) -> None:
    finding = of_code(text, "RD507")
    assert (finding.cause, finding.fix, finding.severity) == (None, None, W)
    assert mended(text) == text


@pytest.mark.parametrize(
    ("limits", "free"),
    [
        ("", True),
        ('lower="0" upper="0"', True),
        ('lower="0.3" upper="0.3"', False),
        ('lower="-1e16" upper="1e16"', True),
    ],
)
def test_a_joint_that_turns_freely_is_continuous(limits: str, free: bool) -> None:
    text = HEALTHY.replace(_LIMITS, limits)
    assert ("continuous" in of_code(text, "RD504").remedy) is free
    slide = text.replace('name="shoulder" type="revolute"', 'name="shoulder" type="prismatic"')
    assert "continuous" not in of_code(slide, "RD504").remedy


def test_the_materials_there_are_stand_in_the_order_of_the_file() -> None:
    """In sets names stand in another order in every process."""
    names = ("sand", "teal", "plum", "olive", "ivory", "coral")
    materials = "".join(f'\n  <material name="{name}"><color rgba="0 0 1 1"/></material>' for name in names)
    shape = '<visual><geometry><sphere radius="0.1"/></geometry><material name="zzz"/></visual>'
    text = arm(more=materials).replace('<link name="base"/>', f'<link name="base">{shape}</link>')
    (remedy,) = (finding.remedy for finding in found_in(text.encode()).shown if finding.code == "RD621")
    assert remedy == f"materials: {', '.join(repr(name) for name in names)}"
