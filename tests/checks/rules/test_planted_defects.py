"""Each planted defect is found by its rule alone, once, at the line and column of the attribute."""

from __future__ import annotations

import pytest
from helpers.planted_defects import DEFECTS, HEALTHY, HERE, MEASURED, MESSAGES, SOUND, Defect

from robodyn.checks.check import check_one
from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Severity

IDS = [f"{defect.code}-{k}" for k, defect in enumerate(DEFECTS)]


def test_the_healthy_robot_has_neither_errors_nor_warnings() -> None:
    assert [finding.code for finding in check_one(HEALTHY.encode())] == ["RD211"]


@pytest.mark.parametrize("defect", DEFECTS, ids=IDS)
def test_found_once_and_at_its_place(defect: Defect) -> None:
    (finding,) = [finding for finding in check_one(defect.text.encode()) if finding.code == defect.code]
    if HERE in defect.new:
        assert (finding.line, finding.column) == defect.place


@pytest.mark.parametrize("defect", DEFECTS, ids=IDS)
def test_no_other_rule_fires(defect: Defect) -> None:
    others = [finding for finding in check_one(defect.text.encode()) if finding.code != defect.code]
    assert [finding.code for finding in others if finding.severity is not Severity.NOTE] == []


@pytest.mark.parametrize("defect", DEFECTS, ids=IDS)
def test_message_says_what_to_do(defect: Defect) -> None:
    (finding,) = [finding for finding in check_one(defect.text.encode()) if finding.code == defect.code]
    assert finding.message
    assert finding.remedy
    assert "  " not in finding.message + finding.remedy
    if finding.measured:
        assert any(character.isdigit() for character in finding.message)


@pytest.mark.parametrize("change", SOUND, ids=[change.new[:50] for change in SOUND])
def test_what_is_sound_stays_unfound(change: Defect) -> None:
    """But for a remark that some program refuses it: MuJoCo an empty <collision>, Drake lower > upper."""
    found = check_one(change.text.encode())
    assert {finding.code for finding in found if finding.severity is not Severity.NOTE} == set()
    assert {finding.code for finding in found} <= {"RD211", "RD901"}


@pytest.mark.parametrize(("defect", "words"), MESSAGES, ids=[words for _, words in MESSAGES])
def test_words(defect: Defect, words: str) -> None:
    (finding,) = [finding for finding in check_one(defect.text.encode()) if finding.code == defect.code]
    assert words in f"{finding.message} ({finding.remedy})"


@pytest.mark.parametrize(("defect", "measured", "bound"), MEASURED, ids=[defect.code for defect, *_ in MEASURED])
def test_measured_value_and_bound(defect: Defect, measured: float, bound: float | None) -> None:
    (finding,) = [finding for finding in check_one(defect.text.encode()) if finding.code == defect.code]
    assert finding.measured == pytest.approx(measured, rel=1e-14, abs=0)
    assert finding.bound == (None if bound is None else pytest.approx(bound, rel=1e-14, abs=0))


@pytest.mark.parametrize(
    ("angle", "text"), [("0 45 -90", (0.0, 0.7853981633974483, -1.5707963267948966)), ("0 0 7", None)]
)
def test_round_degrees_have_a_fix(angle: str, text: tuple[float, ...] | None) -> None:
    findings = check_one(HEALTHY.replace("0.3 0 0", angle).encode())
    (finding,) = [finding for finding in findings if finding.code == "RD507"]
    assert (finding.cause is None) == (finding.fix is None) == (text is None)
    if finding.fix is not None and text is not None:
        assert tuple(map(float, finding.fix.edits[0].text.split())) == text
        assert not finding.fix.safe


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_places_in_other_encodings_and_line_ends(encoding: str, newline: str) -> None:
    for defect in DEFECTS[::17]:
        data = defect.text.replace("\n", newline).encode(encoding)
        (finding,) = [finding for finding in check_one(data) if finding.code == defect.code]
        if HERE in defect.new:
            assert (finding.line, finding.column) == defect.place


def test_columns_count_characters_and_a_tab_is_one() -> None:
    line = "<link name='é𝄞'>\t<inertial><mass value='-1'/></inertial></link>"
    (finding,) = [found for found in check_one(f"<robot name='r'>\n{line}</robot>".encode()) if found.code == "RD201"]
    assert (finding.line, finding.column) == (2, line.index("-1") + 1)


@pytest.mark.parametrize(
    ("inside", "expected"),
    [
        ('<orgin xyz="0 0 1"/>', Severity.WARNING),
        ('<origin xyz="0 0 1"/>', Severity.WARNING),
        ('<rotor_inertia value="1"/>', Severity.WARNING),
        ("<self_filter/>", Severity.NOTE),
        ("<kinematic>1</kinematic>", Severity.NOTE),
        ('<visual nam="x"/>', Severity.WARNING),
        ('<visual xyz="0 0 1"/>', Severity.WARNING),
        ('<visual colour="x"/>', Severity.NOTE),
        ('<visual name="v" nam="x"/>', Severity.NOTE),
    ],
)
def test_names_that_were_meant_for_urdf_are_warnings_and_others_remarks(inside: str, expected: Severity) -> None:
    text = f'<robot name="r"><link name="l">{inside}</link></robot>'
    (found,) = [one.severity for one in check_one(text.encode()) if one.code == "RD005"]
    assert found is expected


def test_an_element_of_which_nothing_is_read() -> None:
    """Panda's <dynamics D="1" K="7000" mu_coulomb="0" mu_viscous="16"/> damps nothing."""
    for attributes, expected in (('D="1" K="7"', [Severity.WARNING] * 2), ('damping="1" K="7"', [Severity.NOTE])):
        text = arm(f'<axis xyz="0 1 0"/><dynamics {attributes}/>{LIMIT}')
        assert [one.severity for one in check_one(text.encode()) if one.code == "RD005"] == expected


def test_places_in_latin_1() -> None:
    text = '<?xml version="1.0" encoding="ISO-8859-1"?><robot name="é"><link name="ü">ß<visual nam="x"/></link></robot>'
    (finding,) = [finding for finding in check_one(text.encode("latin-1")) if finding.code == "RD005"]
    assert (finding.line, finding.column) == (1, text.index("nam=") + 1)
    assert finding.excerpt.text[finding.excerpt.start :].startswith('nam="x"')


@pytest.mark.parametrize(
    ("defect", "severity"),
    [
        (('<mass value="3.5"/>', '<mass value="0"/>'), ("RD201", Severity.WARNING)),
        (('<mass value="3.5"/>', '<mass value="-0.1"/>'), ("RD201", Severity.ERROR)),
        (('<inertia ixx="4e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="6e-4"/>',
          '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'), ("RD204", Severity.NOTE)),
        (('<inertia ixx="0.05" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.07"/>',
          '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'), ("RD204", Severity.WARNING)),
        (('<inertia ixx="0.003" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.0035"/>',
          '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'), ("RD204", Severity.ERROR)),
        (('lower="-2.9" upper="2.8"', 'lower="-2.9" upper="6.4"'), ("RD507", Severity.NOTE)),
        (('lower="-2.9" upper="2.8"', 'lower="-2.9" upper="12.5"'), ("RD507", Severity.NOTE)),
        (('lower="-2.9" upper="2.8"', 'lower="-2.9" upper="12.6"'), ("RD507", Severity.WARNING)),
        (('lower="-2.9" upper="2.8"', 'lower="-2.9" upper="90"'), ("RD507", Severity.WARNING)),
    ],
)  # fmt: skip
def test_severity_follows_the_rigid_group(defect: tuple[str, str], severity: tuple[str, Severity]) -> None:
    assert HEALTHY.count(defect[0]) == 1
    findings = check_one(HEALTHY.replace(*defect).encode())
    assert severity in [(finding.code, finding.severity) for finding in findings]


def test_a_body_without_mass_that_carries_on_is_a_warning() -> None:
    start = HEALTHY.index("<inertial>", HEALTHY.index('link name="arm"'))
    end = HEALTHY.index("</inertial>", start) + len("</inertial>")
    (finding,) = [
        finding for finding in check_one((HEALTHY[:start] + HEALTHY[end:]).encode()) if finding.code == "RD202"
    ]
    assert finding.severity is Severity.WARNING
    assert "1.68 kg; MuJoCo refuses it, Gazebo drops it and what hangs on it" in finding.message
