"""Comments that allow findings, and what is said about those that do not."""

from __future__ import annotations

import pytest
from helpers.clean_arm import FAMILIES, IDENTITY, INERTIA, arm

from robodyn.checks.check import Options, check_one
from robodyn.checks.waivers import OWN

REASON = "no tensor is published, see issue 52"
WAIVER = f"<!-- robodyn: allow RD208 {REASON} -->"
PLANTED = arm(upper=IDENTITY, fore=IDENTITY)


def found(text: str, *select: str) -> list[tuple[str, str]]:
    findings = check_one(text.encode(), Options(select or FAMILIES))
    return [(finding.code, finding.subject.name if finding.subject else "") for finding in findings]


def test_the_defect_is_found_without_a_waiver() -> None:
    assert found(PLANTED) == [("RD208", "upper"), ("RD208", "fore")]
    assert found(arm()) == []


@pytest.mark.parametrize(
    ("anchor", "text"),
    [
        ('<link name="upper">', f'{WAIVER}\n  <link name="upper">'),
        ('<link name="upper">', f'{WAIVER} <link name="upper">'),
        ('<link name="upper">', f'{WAIVER}<!-- another --><link name="upper">'),
        ('<link name="upper">', f'{WAIVER}\n\n<!-- more -->\n<link name="upper">'),
        ('<link name="upper">', f'<link name="upper">{WAIVER}'),
        ('<link name="upper">', f'<link name="upper"> <!-- another --> {WAIVER}'),
        ('<link name="upper">', f'<link\n name="upper"> {WAIVER}'),
        ('<link name="upper">', f'{WAIVER}\r<link name="upper">'),
        ('<link name="upper">', f'<!--\n  robodyn:\n  allow RD208\n  {REASON}\n-->\n<link name="upper">'),
        ("<inertial>", f"{WAIVER}\n<inertial>"),
        (IDENTITY, f"{WAIVER}{IDENTITY}"),
        (IDENTITY, f"{IDENTITY} {WAIVER}"),
        ("</inertial>", f"</inertial>{WAIVER}"),
        ("</link>", f"</link > {WAIVER}"),
    ],
)
def test_on_or_above_the_element(anchor: str, text: str) -> None:
    head, tail = PLANTED.split('<link name="upper">')
    assert found(head + ('<link name="upper">' + tail).replace(anchor, text, 1)) == [("RD208", "fore")]


def test_of_the_robot_is_of_the_whole_file() -> None:
    assert found(PLANTED.replace("<robot", f"{WAIVER}<robot")) == []
    assert found(PLANTED.replace('<robot name="arm">', f'<robot name="arm"> {WAIVER}')) == []


def test_several_codes() -> None:
    text = arm(upper=IDENTITY, shoulder="0 2 0")
    assert found(text) == [("RD208", "upper"), ("RD502", "shoulder")]
    waiver = "<!-- robodyn: allow RD208, RD502,RD207: all of this is known -->"
    assert found(text.replace("<robot", f"{waiver}<robot")) == [("RD009", "")]


def test_elsewhere_is_not_waived_and_reported_as_unused() -> None:
    text = PLANTED.replace('<link name="base"/>', f'<link name="base"/> {WAIVER}')
    assert found(text) == [("RD009", ""), ("RD208", "upper"), ("RD208", "fore")]
    assert found(PLANTED.replace("</robot>", f"  {WAIVER}\n</robot>"))[-1] == ("RD009", "")


def test_unused_only_if_the_rule_has_run() -> None:
    text = arm().replace("<robot", f"{WAIVER}<robot")
    assert found(text) == [("RD009", "")]
    assert found(text, "RD5", "RD009") == []
    assert found(text, "RD208") == []
    assert found(text, "RD208", "RD009") == [("RD009", "")]


def test_unused_names_the_code_and_the_place() -> None:
    text = PLANTED.replace('<link name="upper">', '<!-- robodyn: allow RD208,RD207 both -->\n<link name="upper">')
    (finding,) = check_one(text.encode(), Options(("RD009",))) or check_one(text.encode(), Options(("RD009", "RD207")))
    assert finding.message == "the waiver of RD207 has nothing to waive"
    assert text.encode()[finding.start : finding.end] == b"<!-- robodyn: allow RD208,RD207 both -->"


@pytest.mark.parametrize(
    ("comment", "message"),
    [
        ("robodyn: allow RD208", "the waiver of RD208 gives no reason"),
        ("robodyn: allow RD208, RD207 -", "the waiver of RD208, RD207 gives no reason"),
        ("robodyn: allow RD999 why not", "the waiver names 'RD999', which no rule has"),
        ("robodyn: allow rd208 why not", "the waiver names 'rd208', which no rule has"),
        ("robodyn: allow RD2 why not", "the waiver names 'RD2', which no rule has"),
        ("robodyn: ignore RD208 why not", "the comment 'robodyn: ignore RD208 why not' is not understood"),
        ("robodyn: ", "the comment 'robodyn: ' is not understood"),
        ("robodyn: allow RD009 why not", "RD009 cannot be waived"),
        ("robodyn: allow RD208,RD008 why not", "RD008 cannot be waived"),
    ],
)
def test_not_in_force(comment: str, message: str) -> None:
    text = PLANTED.replace("<robot", f"<!-- {comment} -->\n<robot")
    findings = check_one(text.encode(), Options(FAMILIES))
    assert [finding.code for finding in findings] == ["RD008", "RD208", "RD208"]
    assert findings[0].message == message
    assert (findings[0].line, findings[0].column) == (2, 1)


def test_other_comments_are_left_alone() -> None:
    text = PLANTED.replace("<robot", "<!-- robodyn allow RD208 x --><!-- see robodyn: allow RD208 x --><robot")
    assert found(text) == [("RD208", "upper"), ("RD208", "fore")]


def test_nothing_is_waived_in_a_file_that_cannot_be_read() -> None:
    text = f"<!-- robodyn: allow RD001 {REASON} --><robot><link></robot>"
    assert [finding.code for finding in check_one(text.encode())] == ["RD001"]


def test_letters_beyond_ascii() -> None:
    text = PLANTED.replace("<robot", "<!-- robodyn: allow RD208 Prüfgewicht — ohne Tensor --><robot")
    assert found(text) == []
    latin = text.replace("—", "-").replace('<?xml version="1.0"?>', '<?xml version="1.0" encoding="ISO-8859-1"?>')
    assert check_one(latin.encode("latin-1")) == ()
    assert check_one(text.replace("<?xml", "<?xml", 1).encode("utf-16")) == ()


def test_own_rules_are_those_of_the_catalogue() -> None:
    from robodyn.checks.catalogue import RULES

    assert [rule.code for rule in RULES if "waiver" in rule.name] == list(OWN)


def test_unhurt_by_inertia() -> None:
    assert found(arm(upper=f"{INERTIA} {WAIVER}")) == [("RD009", "")]
