"""A robot whose lengths are all in another unit is named once, and what follows from it is not named beside it."""

from __future__ import annotations

import re

import pytest
from helpers.example_robots import path_of
from helpers.sampled import sampled

from robodyn.checks.check import Options, check_one, select_findings
from robodyn.checks.rule import Finding

ROBOTS = ("z1", "panda", "go2", "solo12")
UNITS = {1000.0: "in millimetres", 0.001: "a thousandth of metres"}
LENGTHS = re.compile(r'<axis\b[^>]*>|\b(xyz|size|radius|length)="([^"]*)"')
MESH = re.compile(r"<mesh\b[^>]*?/?>")


def drawn(text: str, times: float) -> str:
    """The description with all its lengths multiplied, but for axes."""

    def scaled(found: re.Match[str]) -> str:
        if found[1] is None:
            return found[0]
        return f'{found[1]}="{" ".join(repr(times * float(number)) for number in found[2].split())}"'

    def mesh(found: re.Match[str]) -> str:
        given = re.search(r'scale="([^"]*)"', found[0])
        old = [float(number) for number in given[1].split()] if given else [1.0] * 3
        scale = f'scale="{" ".join(repr(times * factor) for factor in old)}"'
        return found[0].replace(given[0], scale) if given else found[0].replace("<mesh", f"<mesh {scale}")

    return MESH.sub(mesh, LENGTHS.sub(scaled, text))


def severe(stem: str, times: float) -> list[Finding]:
    path = path_of(stem)
    text = drawn(path.read_text(encoding="utf-8"), times)
    found = select_findings(check_one(text.encode(), name=str(path)), Options()).shown
    return [one for one in found if one.code != "RD403"]


@pytest.mark.parametrize("stem", sampled(ROBOTS, 4))
@pytest.mark.parametrize("times", UNITS)
def test_it_is_named_once(stem: str, times: float) -> None:
    known = {one.code for one in severe(stem, 1.0)}
    assert "RD113" not in known
    found = [one for one in severe(stem, times) if one.code not in known]
    assert [one.code for one in found] == ["RD113"]
    assert UNITS[times] in found[0].message


@pytest.mark.parametrize("times", sampled([0.1, 10.0, 39.37, 100.0], 4))
def test_another_factor_is_not_named(times: float) -> None:
    assert "RD113" not in {one.code for one in severe("z1", times)}
