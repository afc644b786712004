"""The default set, ALL, and codes: which findings are shown and which are counted only."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.clean_arm import IDENTITY, arm
from helpers.planted_defects import HEALTHY

import robodyn
from robodyn.checks.catalogue import ALL, BY_CODE, DEFAULT, RULES
from robodyn.checks.check import Options, check_one, check_tasks, found_in, select_findings
from robodyn.checks.context import Asked
from robodyn.checks.rule import Severity

ODD = arm(upper=IDENTITY).replace('"shoulder"', '"shoulder/1"')
"""A warning of RD208 and a remark of RD110."""


def codes(text: str, options: Options) -> tuple[list[str], list[str]]:
    found = found_in(text.encode(), options)
    return [one.code for one in found.shown], [one.code for one in found.hidden]


@pytest.mark.parametrize(
    ("select", "ignore", "shown", "hidden"),
    [
        ((), (), ["RD208"], ["RD110"]),
        ((DEFAULT,), (), ["RD208"], ["RD110"]),
        ((ALL,), (), ["RD208", "RD110"], []),
        (("RD110",), (), ["RD110"], []),
        (("RD1",), (), ["RD110"], []),
        (("RD2",), (), ["RD208"], []),
        ((DEFAULT, "RD110"), (), ["RD208", "RD110"], []),
        ((DEFAULT, "RD5"), (), ["RD208"], ["RD110"]),
        ((), ("RD110",), ["RD208"], []),
        ((ALL,), ("RD2",), ["RD110"], []),
    ],
)
def test_what_is_shown(select: tuple[str, ...], ignore: tuple[str, ...], shown: list[str], hidden: list[str]) -> None:
    assert codes(ODD, Options(select, ignore)) == (shown, hidden)


def test_a_robot_without_defects_is_silent() -> None:
    assert codes(HEALTHY, Options()) == ([], ["RD211"])
    assert robodyn.check(HEALTHY.encode()) == ()


def test_what_an_option_asks_for_is_shown() -> None:
    asked = Options(asked=Asked(targets=("kdl",)))
    assert codes(HEALTHY, asked)[0] == ["RD901"]
    assert codes(HEALTHY, Options())[0] == []


@pytest.mark.parametrize("code", ["RD803", "RD804"])
def test_warnings_of_taste_are_shown_when_asked_for(code: str) -> None:
    rule = BY_CODE[code]
    assert not rule.in_default
    assert codes(rule.bad, Options()) == ([], [*codes(rule.bad, Options())[1]])
    assert code in codes(rule.bad, Options())[1]
    assert codes(rule.bad, Options((code,))) == ([code], [])


def test_hidden_and_shown_are_all() -> None:
    for rule in RULES:
        every = check_one(rule.bad.encode())
        by_default, everything = select_findings(every, Options()), select_findings(every, Options((ALL,)))
        assert everything.hidden == ()
        assert not [one for one in by_default.hidden if one.severity is Severity.ERROR]
        together = sorted((one.start, one.code) for one in (*by_default.shown, *by_default.hidden))
        assert together == sorted((one.start, one.code) for one in everything.shown)
        assert len(every) >= len(together)


def test_other_words_are_no_rules() -> None:
    with pytest.raises(robodyn.RobodynError, match="there is no rule 'NONE'"):
        found_in(b"<robot/>", Options(("NONE",)))
    with pytest.raises(robodyn.RobodynError, match="there is no rule 'ALL'"):
        robodyn.check(HEALTHY.encode(), ignore=[ALL])


def test_settings_may_add_to_the_default_set(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(ODD)
    settings = tmp_path / "robodyn.toml"
    for select, found in (('["DEFAULT", "RD110"]', ["RD208", "RD110"]), ('["default"]', ["RD208"])):
        settings.write_text(f"[tool.robodyn.check]\nselect = {select}\n")
        assert [one.code for one in robodyn.check(tmp_path / "arm.urdf")] == found
    assert check_tasks([]).hidden == ()
