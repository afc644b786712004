"""JUnit against its schema, and its counts against the findings."""

from __future__ import annotations

import pytest
from helpers.clean_arm import FAMILIES, IDENTITY, arm
from helpers.schemas import JUNIT
from lxml import etree

from robodyn.checks.catalogue import RULES
from robodyn.checks.check import Checked, Options, check_one, found_in
from robodyn.report.renderers.findings import check_junit

SCHEMA = etree.XMLSchema(etree.fromstring(JUNIT))


def junit(*files: tuple[str, bytes], strict: bool = False) -> etree._Element:
    findings = [finding for name, data in files for finding in check_one(data, Options(FAMILIES), name)]
    text = check_junit(Checked(tuple(name for name, _ in files), tuple(findings)), strict)
    document = etree.fromstring(text.encode())
    SCHEMA.assertValid(document)
    for suite in document:
        assert int(suite.get("tests")) == len(suite) > 0
        assert int(suite.get("failures")) == len(suite.findall("testcase/failure"))
    for count in ("tests", "failures", "errors"):
        assert int(document.get(count)) == sum(int(suite.get(count)) for suite in document)
    return document


BAD = arm(upper=IDENTITY, shoulder="0 0 0").encode()


def test_the_schema_would_refuse_what_is_wrong() -> None:
    document = junit(("a.urdf", BAD))
    del document[0].attrib["errors"]
    assert not SCHEMA.validate(document)


def test_a_test_for_each_finding_and_one_for_a_clean_file() -> None:
    document = junit(("a.urdf", BAD), ("b.urdf", arm().encode()), ("c.urdf", b"<robot"))
    assert [suite.get("name") for suite in document] == ["a.urdf", "b.urdf", "c.urdf"]
    assert [[case.get("name").split()[0] for case in suite] for suite in document] == [
        ["RD208", "RD501"],
        ["no"],
        ["RD001"],
    ]
    assert len(document.findall("testsuite[@name='b.urdf']/testcase/failure")) == 0


@pytest.mark.parametrize(("strict", "failed"), [(False, ["RD501"]), (True, ["RD208", "RD501"])])
def test_what_fails_the_check_is_a_failure(strict: bool, failed: list[str]) -> None:
    document = junit(("a.urdf", BAD), strict=strict)
    assert [failure.get("type") for failure in document.iter("failure")] == failed
    outputs = [output.text for output in document.iter("system-out")]
    assert len(outputs) == 2 - len(failed)


def test_the_text_has_the_place_and_the_remedy() -> None:
    (failure,) = junit(("a.urdf", BAD)).iter("failure")
    place = failure.text.split(" ")[0]
    line, column = map(int, place.split(":")[1:3])
    assert BAD.decode().splitlines()[line - 1][column - 1 :].startswith('0 0 0"')
    assert "\nremedy: " in failure.text


def test_every_rule() -> None:
    junit(*((f"{rule.code}.urdf", rule.bad.encode()) for rule in RULES))


@pytest.mark.parametrize("name", ["a\"<&>'.urdf", "a\x1b[31m\x00\x7f.urdf", "\udcff.urdf", "ä\n😀.urdf"])
def test_names_that_xml_does_not_take(name: str) -> None:
    junit((name, BAD))
    junit((name, arm().encode()))


def test_a_test_for_each_finding_lists_its_places() -> None:
    found = found_in(arm(shoulder="0 0 0", elbow="0 0 0").encode(), Options(("RD501",)), "a.urdf")
    document = etree.fromstring(check_junit(Checked(("a.urdf",), found.shown)).encode())
    SCHEMA.assertValid(document)
    (failure,) = document.iter("failure")
    assert "\nalso: 28:16 joint 'elbow'\n" in failure.text
