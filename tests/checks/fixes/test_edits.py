"""Which edits go together, and what they make of the bytes."""

from __future__ import annotations

from dataclasses import replace

from helpers.clean_arm import arm

from robodyn.checks.check import check_one
from robodyn.checks.fixes import together
from robodyn.checks.rule import Edit, Finding, Fix
from robodyn.robot.urdf.edits import edited


def with_fixes(*fixes: Fix | None) -> list[Finding]:
    one = check_one(arm(shoulder="0 2 0").encode())[0]
    return [replace(one, fix=fix) for fix in fixes]


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
