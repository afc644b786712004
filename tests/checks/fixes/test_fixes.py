"""Fixes: edits of bytes, proven where they are said to be safe, until nothing is left to fix."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.clean_arm import INERTIA, arm

import robodyn
from robodyn.checks.catalogue import RULES
from robodyn.checks.check import Options, check_one, fix_task, tasks_for
from robodyn.checks.fixes import ROUNDS, SAME, Fixed, change_of_dynamics, fixed, together, unproven
from robodyn.checks.rule import Edit, Finding, Fix
from robodyn.robot.urdf.edits import edited

TWICE = INERTIA.replace("iyz", 'iyx="0.000"\n   iyz')
"""A product that stands there under both of its names."""
LOWER = INERTIA.replace("ixy", "iyx").replace('iyx="0"', 'iyx="0.001"')
"""A product that stands there under its other name only."""
PLANTED = arm(upper=TWICE, shoulder="0 2 0", elbow="1 2 3")
OLD = "<!-- robodyn: allow RD208 it was so once -->"


def repaired(text: str | bytes, *, unsafe: bool = False) -> Fixed:
    data = text.encode() if isinstance(text, str) else text
    return fixed(data, "arm.urdf", lambda changed: check_one(changed, name="arm.urdf"), unsafe=unsafe)


def with_fixes(*fixes: Fix | None, code: str = "RD502") -> list[Finding]:
    one = next(finding for finding in check_one(PLANTED.encode()) if finding.code == code)
    return [replace(one, fix=fix) for fix in fixes]


def test_nothing_else_moves() -> None:
    result = repaired(PLANTED)
    normed = [x / np.sqrt(14) for x in (1, 2, 3)]
    found = result.after.decode().split('<axis xyz="')[2].split('"')[0]
    assert np.allclose([float(word) for word in found.split()], normed, rtol=4e-16, atol=0)
    expected = PLANTED.replace('"0 2 0"', '"0.0 1.0 0.0"').replace('"1 2 3"', f'"{found}"')
    assert result.after.decode() == expected.replace(' iyx="0.000"', "")
    assert [made.finding.code for made in result.made] == ["RD006", "RD502", "RD502"]
    assert (result.before, result.refused) == (PLANTED.encode(), ())


def test_numbers_are_as_short_as_they_come_back() -> None:
    words = repaired(arm(shoulder="1 2 3")).after.decode().split('<axis xyz="')[1].split('"')[0].split()
    assert [repr(float(word)) for word in words] == words


@pytest.mark.parametrize("text", [arm(), PLANTED, arm(upper=LOWER), PLANTED.replace("<robot", f"{OLD}\n<robot")])
@pytest.mark.parametrize("unsafe", [False, True])
def test_fixing_again_changes_nothing(text: str, unsafe: bool) -> None:
    once = repaired(text, unsafe=unsafe)
    again = repaired(once.after, unsafe=unsafe)
    assert (again.after, again.made) == (once.after, ())
    assert again.refused == once.refused
    assert (once.after != once.before) == bool(once.made)


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_line_ends_byte_order_mark_and_letters_stay(newline: str) -> None:
    text = arm(upper=TWICE, shoulder="0 2 0").replace("<link", "<!-- ä ∑ -->\n\t<link", 1).replace("\n", newline)
    expected = text.replace("0 2 0", "0.0 1.0 0.0").replace(' iyx="0.000"', "")
    assert repaired(b"\xef\xbb\xbf" + text.encode()).after == b"\xef\xbb\xbf" + expected.encode()


def test_other_encodings() -> None:
    latin = PLANTED.replace('"1.0"?>', '"1.0" encoding="ISO-8859-1"?>').replace("<link", "<!-- ä --><link", 1)
    assert "ä".encode("latin-1") in repaired(latin.encode("latin-1")).after
    assert check_one(repaired(latin.encode("latin-1")).after) == ()
    wide = repaired(PLANTED.encode("utf-16"))
    assert wide.after == wide.before == PLANTED.encode("utf-16")
    assert [refused.why for refused in wide.refused] == ["the file is UTF-16; save it as UTF-8 first"] * 3


def test_safe_fixes_leave_the_dynamics() -> None:
    before, after = PLANTED.encode(), repaired(PLANTED).after
    assert change_of_dynamics(before, after) <= SAME
    q, qd, qdd = np.random.default_rng(5).normal(size=(3, 20, 2))
    torques = [robodyn.inverse_dynamics(robodyn.load(text), q, qd, qdd) for text in (before, after)]
    assert np.max(np.abs(torques[1] - torques[0])) <= SAME * np.max(np.abs(torques[0]))


def test_what_is_not_proven_is_not_made_and_said() -> None:
    heavier = '<mass value="3"/>'

    def lying(data: bytes) -> tuple[Finding, ...]:
        start = data.find(b'<mass value="2"/>')
        fixes = [replace(one.fix, what="honest") for one in check_one(data) if one.fix is not None]
        lie = Fix("lie", (Edit(start, start + len(heavier), heavier),), safe=True)
        return tuple(with_fixes(*([lie] if start >= 0 else []), *fixes))

    result = fixed(PLANTED.encode(), "arm.urdf", lying)
    assert {made.fix.what for made in result.made} == {"honest"}
    assert [refused.fix.what for refused in result.refused] == ["lie"]
    assert result.refused[0].why.startswith("it changes the dynamics by 0.")
    assert result.after == repaired(PLANTED).after


def test_of_a_file_that_cannot_be_loaded_nothing_is_proven() -> None:
    text = PLANTED.replace('<child link="fore"/>', '<child link="for"/>')
    result = repaired(text)
    assert result.after == text.encode()
    assert len(result.refused) == 3
    assert all(one.why.startswith("the dynamics cannot be computed: ") for one in result.refused)


def test_unsafe_fixes_are_asked_for_and_measured() -> None:
    text = arm(upper=LOWER.replace("ixz", 'ixy="x" ixz').replace('ixy="x" ', ""), shoulder="0 2 0")
    assert b"iyx" in repaired(text).after
    result = repaired(text, unsafe=True)
    assert b'ixy="0.001"' in result.after
    assert b"iyx" not in result.after
    assert [made.fix.safe for made in result.made].count(False) == 1


def test_what_an_unsafe_fix_changes() -> None:
    def halving(data: bytes) -> tuple[Finding, ...]:
        start = data.find(b'"0.4 0 0"')
        edit = Edit(start + 1, start + 4, "0.2")
        return tuple(with_fixes(Fix("halve", (edit,), safe=False))) if start >= 0 else ()

    result = fixed(arm().encode(), "arm.urdf", halving, unsafe=True)
    (made,) = result.made
    assert made.change == change_of_dynamics(arm().encode(), arm().replace("0.4 0 0", "0.2 0 0").encode())
    assert made.change is not None
    assert 0.01 < made.change < 1


def test_rules_that_undo_each_other_change_nothing() -> None:
    calls = []

    def flipping(data: bytes) -> tuple[Finding, ...]:
        calls.append(data)
        return tuple(with_fixes(Fix("flip", (Edit(0, 0, " " if data.startswith(b"<r") else "\n"),), safe=True)))

    result = fixed(b'<robot name="a"><link name="b"/></robot>', "a.urdf", flipping)
    assert (result.after, result.made) == (result.before, ())
    assert len(calls) == ROUNDS
    assert {refused.why for refused in result.refused} == {f"the fixes do not settle in {ROUNDS} rounds"}


def test_every_rule_whose_bad_example_can_be_fixed() -> None:
    seen = set()
    for rule in RULES:
        data = rule.bad.encode()
        if any(finding.fix for finding in check_one(data) if finding.code == rule.code):
            result = repaired(data, unsafe=True)
            assert not [one for one in result.refused if one.finding.code == rule.code], rule.code
            assert not [one for one in check_one(result.after) if one.code == rule.code and one.fix], rule.code
            seen.add(rule.code)
    assert {"RD009", "RD502"} <= seen


def test_options_hold_while_fixing(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(PLANTED)
    (task,) = tasks_for([str(path)], Options(ignore=("RD502",)))
    result = fix_task(task)
    assert [made.finding.code for made in result.made] == ["RD006"]
    assert path.read_text() == PLANTED


def test_a_waived_finding_is_not_fixed() -> None:
    text = PLANTED.replace(
        '<axis xyz="0 2 0"/>', '<axis xyz="0 2 0"/> <!-- robodyn: allow RD502 as the maker has it -->'
    )
    assert b'"0 2 0"' in repaired(text).after


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (f"\n  {OLD}\n<robot", "\n<robot"),
        (f"\n  {OLD} \t\r\n<robot", "\n<robot"),
        (f"\n{OLD}<robot", "\n<robot"),
        (f"\n<!-- x --> {OLD}\n<robot", "\n<!-- x -->\n<robot"),
    ],
)
def test_an_unused_waiver_goes_with_its_line(before: str, after: str) -> None:
    text = arm().replace("\n<robot", before)
    assert repaired(text).after.decode() == arm().replace("\n<robot", after)


def chosen(*edits: tuple[int, int] | tuple[tuple[int, int], ...]) -> list[str]:
    fixes = []
    for k, given in enumerate(edits):
        spans = given if isinstance(given[0], tuple) else (given,)
        fixes.append(Fix(str(k), tuple(Edit(a, b, "x") for a, b in spans), safe=True))  # type: ignore[misc]
    return [fix.what for _, fix in together(with_fixes(*fixes, None), True)]


def test_overlapping_edits_are_resolved_by_place() -> None:
    assert chosen((5, 9), (0, 4)) == ["1", "0"]
    assert chosen((5, 9), (0, 6)) == ["1"]
    assert chosen((0, 4), (4, 8)) == ["0", "1"]
    assert chosen((0, 4), (4, 4)) == ["0"]
    assert chosen((4, 4), (4, 4)) == ["0"]
    assert chosen((2, 3), ((0, 1), (2, 5))) == ["1"]
    assert chosen(((0, 3), (2, 5)), (7, 8)) == ["1"]


def test_only_fixes_of_the_kind_asked_for() -> None:
    safe, unsafe = Fix("a", (Edit(0, 1, ""),), safe=True), Fix("b", (Edit(0, 1, ""),), safe=False)
    assert [fix for _, fix in together(with_fixes(safe, unsafe), True)] == [safe]
    assert [fix for _, fix in together(with_fixes(safe, unsafe), False)] == [unsafe]


def test_the_order_of_edits_does_not_matter() -> None:
    edits = [Edit(1, 2, "one"), Edit(4, 4, "ü∑"), Edit(0, 0, "<")]
    assert edited(b"abcdef", edits, "latin-1") == "<aonecdü&#8721;ef".encode("latin-1")
    assert edited(b"abcdef", edits[::-1], "utf-8") == "<aonecdü∑ef".encode()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('ixx="0.01"', 'ixx="0.0100000001"'),
        ('xyz="0.4 0 0"', 'xyz="0.4 1e-12 0"'),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 1 1e-12"/>'),
        ('<mass value="2"/>', '<mass value="2.000000000001"/>'),
        ('<link name="base"/>', f'<link name="base"><inertial><mass value="1"/>{INERTIA}</inertial></link>'),
        ('type="revolute"', 'type="prismatic"'),
    ],
)
def test_the_proof_sees_small_changes_of_the_dynamics(old: str, new: str) -> None:
    assert unproven(arm().encode(), arm().replace(old, new, 1).encode()) is not None


@pytest.mark.parametrize(
    ("old", "new"), [('effort="30"', 'effort="31"'), ('"0 1 0"', '"0 7 0"'), ("  <link", "\n<link")]
)
def test_the_proof_lets_pass_what_is_no_dynamics(old: str, new: str) -> None:
    assert unproven(arm().encode(), arm().replace(old, new, 1).encode()) is None


def test_what_rounding_makes_of_the_same_dynamics_is_below_the_bound() -> None:
    for seed in range(4):
        random = np.random.default_rng(seed)
        axes, factors = random.normal(size=(2, 3)), 10 ** random.uniform(-3, 3, size=2)
        shoulder, elbow = (" ".join(map(repr, axis.tolist())) for axis in axes)
        scaled = [" ".join(map(repr, axis.tolist())) for axis in axes * factors[:, None]]
        before, after = arm(shoulder=shoulder, elbow=elbow), arm(shoulder=scaled[0], elbow=scaled[1])
        assert change_of_dynamics(before.encode(), after.encode()) <= SAME


def test_other_joints_are_other_dynamics() -> None:
    renamed = arm().replace("elbow", "knee").encode()
    assert unproven(arm().encode(), renamed) == "it changes the dynamics by inf of the largest torque"


def test_a_robot_without_mass_has_the_same_dynamics_as_itself() -> None:
    assert unproven(b'<robot name="a"><link name="b"/></robot>', b'<robot name="a"> <link name="b"/></robot>') is None
