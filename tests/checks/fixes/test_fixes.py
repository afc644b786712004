"""Fixes: edits of bytes, proven where they are said to be safe, until nothing is left; in the whole corpus."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from helpers.clean_arm import INERTIA, arm
from helpers.importers import answers
from helpers.planted_defects import DEFECTS, SOUND
from pinned_findings import name_of, published

import robodyn
from robodyn.checks.check import check_one
from robodyn.checks.fixes import ROUNDS, SAME, Fixed, change_of_dynamics, fixed, together, unproven
from robodyn.checks.rule import Edit, Finding, Fix, Severity

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


@pytest.mark.parametrize("newline", ["\r\n", "\r"])
def test_line_ends_byte_order_mark_and_letters_stay(newline: str) -> None:
    text = PLANTED.replace("<link", "<!-- ä ∑ -->\n\t<link", 1)
    expected = repaired(text).after.decode().replace("\n", newline)
    assert expected != text.replace("\n", newline)
    assert repaired(b"\xef\xbb\xbf" + text.replace("\n", newline).encode()).after == b"\xef\xbb\xbf" + expected.encode()


def test_other_encodings() -> None:
    latin = PLANTED.replace('"1.0"?>', '"1.0" encoding="ISO-8859-1"?>').replace("<link", "<!-- ä --><link", 1)
    assert "ä".encode("latin-1") in repaired(latin.encode("latin-1")).after
    assert check_one(repaired(latin.encode("latin-1")).after) == ()
    wide = repaired(PLANTED.encode("utf-16"))
    assert wide.after == wide.before == PLANTED.encode("utf-16")
    assert [refused.why for refused in wide.refused] == ["the file is UTF-16; save it as UTF-8 first"] * 3


def test_safe_fixes_leave_torques_as_they_were() -> None:
    q, qd, qdd = np.random.default_rng(5).normal(size=(3, 20, 2))
    before, after = (
        robodyn.inverse_dynamics(robodyn.load(text), q, qd, qdd) for text in (PLANTED.encode(), repaired(PLANTED).after)
    )
    assert np.abs(after - before).max() <= SAME * np.abs(before).max()


def test_a_waived_finding_is_not_fixed() -> None:
    axis = '<axis xyz="0 2 0"/>'
    text = PLANTED.replace(axis, f"{axis} <!-- robodyn: allow RD502 as the maker has it -->")
    assert b'"0 2 0"' in repaired(text).after


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
    text = arm(upper=LOWER, shoulder="0 2 0")
    assert b"iyx" in repaired(text).after
    result = repaired(text, unsafe=True)
    assert b'ixy="0.001"' in result.after
    assert [made.fix.safe for made in result.made].count(False) == 1

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


@pytest.mark.parametrize(
    ("old", "new", "proven"),
    [
        ('ixx="0.01"', 'ixx="0.0100000001"', False),
        ('xyz="0.4 0 0"', 'xyz="0.4 1e-12 0"', False),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 1 1e-12"/>', False),
        ('<mass value="2"/>', '<mass value="2.000000000001"/>', False),
        ('<link name="base"/>', f'<link name="base"><inertial><mass value="1"/>{INERTIA}</inertial></link>', False),
        ('type="revolute"', 'type="prismatic"', False),
        ('name="elbow"', 'name="knee"', False),
        ('effort="30"', 'effort="31"', True),
        ('"0 1 0"', '"0 7 0"', True),
        ("  <link", "\n<link", True),
    ],
)
def test_the_proof_sees_small_changes_of_the_dynamics_alone(old: str, new: str, proven: bool) -> None:
    assert (unproven(arm().encode(), arm().replace(old, new, 1).encode()) is None) is proven
    massless = b'<robot name="a"><link name="b"/></robot>'
    assert unproven(massless, massless.replace(b"><", b"> <")) is None


def test_what_rounding_makes_of_the_same_dynamics_is_below_the_bound() -> None:
    for seed in range(4):
        random = np.random.default_rng(seed)
        axes, factors = random.normal(size=(2, 3)), 10 ** random.uniform(-3, 3, size=2)
        shoulder, elbow = (" ".join(map(repr, axis.tolist())) for axis in axes)
        scaled = [" ".join(map(repr, axis.tolist())) for axis in axes * factors[:, None]]
        before, after = arm(shoulder=shoulder, elbow=elbow), arm(shoulder=scaled[0], elbow=scaled[1])
        assert change_of_dynamics(before.encode(), after.encode()) <= SAME


CORPUS = {f"{k}-{one.code or 'sound'}.urdf": one.text.encode() for k, one in enumerate((*DEFECTS, *SOUND))}
FIXABLE = (
    *(
        "anymal_c_simple_description/anymal",
        "bolt_description/bolt",
        "double_pendulum_description/double_pendulum_simple",
    ),
    *("finger_edu_description/finger_edu", "laikago_description/laikago", "talos_data/talos_reduced_box"),
    *("romeo_description/romeo_laas_small", "so_arm_description/so100", "talos_data/talos_full_v2"),
    *("talos_data/talos_left_arm", "talos_data/talos_reduced", "tiago_description/tiago"),
)
"""Robots in which something can be fixed."""
ROBOTS = {name_of(path): path for path in published() if name_of(path) in FIXABLE}
_SHAPES = re.compile(rb"<!--.*?-->|<(visual|collision)\b[^>]*/>|<(visual|collision)\b.*?</\2>", re.DOTALL)
_ATTRIBUTE = re.compile(r"""([\w:]+)\s*=\s*("[^"]*"|'[^']*')""")
_WAIVER = re.compile(r"<!-- robodyn: .*? -->")


@cache
def checked(name: str, text: bytes) -> tuple[Finding, ...]:
    return check_one(text, name=name)


@cache
def result(name: str, unsafe: bool) -> Fixed:
    """A planted defect, or a robot where it stands, so that its meshes and its SRDF are found; nothing is written."""
    file = str(ROBOTS[name]) if name in ROBOTS else name
    data = CORPUS[name] if name in CORPUS else ROBOTS[name].read_bytes()
    return fixed(data, file, partial(checked, file), unsafe=unsafe)


def attributes(line: bytes) -> Counter[tuple[str, str]]:
    return Counter(_ATTRIBUTE.findall(line.decode()))


def other(line: bytes) -> str:
    """What is neither an attribute nor a waiver."""
    return _ATTRIBUTE.sub("", _WAIVER.sub("", line.decode())).replace(" ", "")


def assert_only_values_change(one: Fixed) -> None:
    """Only attributes differ, no more of them than edits, in lines that fixes name, and as their edits say."""
    edits = [edit for made in one.made for edit in made.fix.edits]
    lines = zip(one.before.split(b"\n"), one.after.split(b"\n"), strict=True)
    changed = {number: (old, new) for number, (old, new) in enumerate(lines, 1) if old != new}
    named = {made.finding.line for made in one.made}
    assert named <= set(changed)
    assert all(other(old) == other(new) for old, new in changed.values())
    gone = [pair for old, new in changed.values() for pair in (attributes(old) - attributes(new)).elements()]
    come = [pair for old, new in changed.values() for pair in (attributes(new) - attributes(old)).elements()]
    assert len(come) <= len(gone) <= len(edits)
    assert {value.strip("'\"") for _, value in come} <= {edit.text for edit in edits}


def assert_idempotent(name: str, unsafe: bool) -> None:
    one = result(name, unsafe)
    again = fixed(one.after, one.file, partial(checked, one.file), unsafe=unsafe)
    assert again.after == one.after
    assert not again.made


def assert_load_as_before(results: Sequence[Fixed], folder: Path) -> None:
    """What MuJoCo read without shapes it reads; and what has no error left that is about more than shapes in any
    case."""
    files = []
    for k, text in enumerate(text for one in results for text in (one.before, one.after)):
        files.append(folder / f"{k}.urdf")
        files[-1].write_bytes(_SHAPES.sub(b"", text))
    refusals = [answer.refused for answer in answers("mujoco", files)]
    for one, before, after in zip(results, refusals[::2], refusals[1::2], strict=True):
        errors = [found.code for found in checked(one.file, one.after) if found.severity is Severity.ERROR]
        sound = all(code.startswith(("RD3", "RD6", "RD7")) for code in errors)
        assert after is None or (before is not None and not sound), one.file


@pytest.mark.parametrize(
    ("part", "loading"), [(0, False), *(pytest.param(part, True, marks=pytest.mark.slow) for part in range(8))]
)
def test_planted_defects(part: int, loading: bool, tmp_path: Path) -> None:
    """What has no fix stays as it is."""
    mended = []
    for name in list(CORPUS)[part::8]:
        fixes = [one.fix for one in checked(name, CORPUS[name]) if one.fix]
        for unsafe in (False, True):
            one = result(name, unsafe)
            if any(unsafe or fix.safe for fix in fixes):
                assert_only_values_change(one)
                assert_idempotent(name, unsafe)
            else:
                assert one.after == CORPUS[name]
            mended += [one] * bool(fixes)
        assert not [one for one in checked(name, result(name, True).after) if one.fix]
    if loading:
        assert_load_as_before(mended, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("unsafe", [False, True])
@pytest.mark.parametrize("name", ROBOTS)
def test_robots(name: str, unsafe: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    one = result(name, unsafe)
    assert one.made or one.refused or not unsafe
    assert_only_values_change(one)
    assert_idempotent(name, unsafe)
    assert_load_as_before([one], tmp_path)
