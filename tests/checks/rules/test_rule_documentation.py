"""Every rule's documentation is true, its bad example found and its good one not; names that others use."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.example_robots import path_of

from robodyn.checks.catalogue import RULES
from robodyn.checks.check import Options, check_one
from robodyn.checks.examples import arm
from robodyn.checks.rule import Finding, Rule, Severity

BOX = '<collision><geometry><box size="0.1 0.1 0.25"/></geometry></collision>'
CODES = [rule.code for rule in RULES]
ASKING = ("RD802", "RD902", "RD602", "RD604", "RD605", "RD607", "RD624")
ABOUT_SRDF = ("RD706", "RD707", "RD708", "RD709")
ALONE = [rule for rule in RULES if rule.code not in (*ASKING, *ABOUT_SRDF)]
"""The rules that need nothing but the file; test_asked and test_mesh_rules give the others what they ask for."""
SRDF = [rule for rule in RULES if rule.code in ABOUT_SRDF]
DESCRIPTIONS = [rule for rule in RULES if rule.code not in ABOUT_SRDF]
SHAPED_ARM = (
    arm().replace('<link name="base"/>', f'<link name="base">{BOX}</link>').replace("</inertial>", f"</inertial>{BOX}")
)


def found(text: str) -> tuple[Finding, ...]:
    return check_one(text.encode())


def test_codes_and_names_are_unique_and_in_order() -> None:
    assert sorted(set(CODES)) == CODES
    assert len({rule.name for rule in RULES}) == len(RULES)


@pytest.mark.parametrize("rule", ALONE, ids=lambda rule: rule.code)
def test_bad_example_is_found_by_this_rule_and_raises_no_other_error(rule: Rule) -> None:
    findings = found(rule.bad)
    assert (rule.code, rule.name) in {(finding.code, finding.name) for finding in findings}
    assert {finding.code for finding in findings if finding.severity is Severity.ERROR} <= {rule.code}


@pytest.mark.parametrize("rule", SRDF, ids=lambda rule: rule.code)
def test_examples_that_are_srdfs(rule: Rule, tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(SHAPED_ARM)
    for text, times in ((rule.bad, 1), (rule.good, 0)):
        (tmp_path / "arm.srdf").write_text(text)
        findings = [finding for finding in check_one(str(file)) if finding.code == rule.code]
        assert len(findings) == times
        assert all(finding.file == str(tmp_path / "arm.srdf") for finding in findings)


@pytest.mark.parametrize("rule", DESCRIPTIONS, ids=lambda rule: rule.code)
def test_good_example_is_not_found_and_has_no_error(rule: Rule) -> None:
    findings = found(rule.good)
    assert rule.code not in {finding.code for finding in findings}
    assert not [finding for finding in findings if finding.severity is Severity.ERROR]


def test_documentation_is_complete() -> None:
    for rule in RULES:
        assert re.fullmatch(r"RD\d{3}", rule.code)
        assert re.fullmatch(r"[a-z]+(-[a-z]+)*", rule.name)
        assert rule.summary.endswith(".")
        assert ". " not in rule.summary, "one sentence"
        assert rule.explanation.endswith(".")
        assert rule.check.__module__.startswith("robodyn.checks.rules.")


def unnamed(file: Path) -> list[Finding]:
    return list(check_one(str(file), Options(select=("RD701",))))


GROUPS = """<robot name="arm">
  <group name="all"><chain base_link="base" tip_link="{tip}"/><joint name="shoulder"/></group>
  <group_state name="home" group="all"><joint name="{joint}" value="0"/></group_state>
  <virtual_joint name="free" type="floating" parent_frame="odom" child_link="base"/>
  <passive_joint name="free"/>
  <end_effector name="e" parent_link="upper" group="all"/>
  <disable_collisions link1="base" link2="{other}" reason="Never"/>
</robot>"""


def robot(tmp_path: Path, srdf: str, place: str = "arm.srdf") -> Path:
    file = tmp_path / "urdf" / "arm.urdf"
    for path, text in ((file, arm()), (tmp_path / "urdf" / place, srdf)):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.resolve().parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return file


@pytest.mark.parametrize("place", ["arm.srdf", "config/arm.srdf", "../srdf/arm.srdf", "../config/arm.srdf"])
def test_srdf_of_the_same_name(tmp_path: Path, place: str) -> None:
    good = {"tip": "upper", "joint": "shoulder", "other": "upper"}
    assert not unnamed(robot(tmp_path, GROUPS.format(**good), place))
    bad = unnamed(robot(tmp_path, GROUPS.format(tip="uper", joint="root_joint", other="tool"), place))
    assert [(one.severity, one.line, Path(one.file).name) for one in bad] == [
        (Severity.ERROR, 2, "arm.srdf"),
        (Severity.WARNING, 7, "arm.srdf"),
    ]


def test_srdf_of_another_name_is_one_warning_if_it_is_for_this_robot(tmp_path: Path) -> None:
    text = GROUPS.format(tip="uper", joint="elbow", other="tool")
    file = robot(tmp_path, text, "other.srdf")
    (one,) = unnamed(file)
    assert one.severity is Severity.WARNING
    assert "2 more names" in one.message
    assert not unnamed(robot(tmp_path, text.replace('name="arm"', 'name="leg"'), "other.srdf"))


def test_a_broken_srdf_is_no_fault_of_the_robot(tmp_path: Path) -> None:
    assert not unnamed(robot(tmp_path, "<robot name='arm'><group>"))


def test_published_robots() -> None:
    assert not any(unnamed(path_of(stem)) for stem in ("solo12", "go2", "kinova", "panda"))
    assert {one.line for one in unnamed(path_of("pr2"))} == {1188, 1191}
