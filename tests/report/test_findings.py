"""Findings as JUnit and SARIF against their schemas, and as GitHub's commands read back."""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace
from typing import Any

import pytest
from helpers.clean_arm import FAMILIES, IDENTITY, INERTIA, arm
from helpers.schemas import JUNIT, SARIF, json_schema
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft7Validator
from lxml import etree

from robodyn.checks.catalogue import RULES
from robodyn.checks.check import Checked, Options, check_one, found_in
from robodyn.checks.rule import Edit, Excerpt, Finding, Fix, Severity
from robodyn.report.renderers.findings import check_github, check_junit, check_sarif
from robodyn.robot.urdf.document import read
from robodyn.robot.urdf.view import Subject

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


def test_a_test_for_each_finding_and_one_for_a_clean_file() -> None:
    document = junit(("a.urdf", BAD), ("b.urdf", arm().encode()), ("c.urdf", b"<robot"))
    assert [suite.get("name") for suite in document] == ["a.urdf", "b.urdf", "c.urdf"]
    names = [[case.get("name").split()[0] for case in suite] for suite in document]
    assert names == [["RD208", "RD501"], ["no"], ["RD001"]]
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


BOTH = arm(upper=IDENTITY, fore=INERTIA.replace("iyz", 'iyx="0" iyz'), shoulder="0 2 0")


def sarif(data: bytes, name: str = "robots/arm.urdf") -> Any:
    return of_findings(check_one(data, name=name), data)


def of_findings(findings: list[Finding], data: bytes) -> Any:
    """SARIF that keeps to its schema."""
    document = json.loads(check_sarif(findings, RULES, lambda file: read(data, file)), parse_constant=pytest.fail)
    Draft7Validator(json_schema(SARIF)).validate(document)
    return document


def results(data: bytes, name: str = "robots/arm.urdf") -> list[Any]:
    found: list[Any] = sarif(data, name)["runs"][0]["results"]
    return found


def region_text(data: bytes, region: dict[str, int]) -> str:
    """What lies in a region of the text, counted by lines and characters independently of the report."""
    lines = data.decode().splitlines(keepends=True)
    start = sum(map(len, lines[: region["startLine"] - 1])) + region["startColumn"] - 1
    end = sum(map(len, lines[: region["endLine"] - 1])) + region["endColumn"] - 1
    return data.decode()[start:end]


def test_every_rule_gives_valid_sarif() -> None:
    bad = {f"{rule.code}.urdf": rule.bad.encode() for rule in RULES}
    findings = [finding for name, data in bad.items() for finding in check_one(data, name=name)]
    document = json.loads(check_sarif(findings, RULES, lambda file: read(bad[file], file)))
    Draft7Validator(json_schema(SARIF)).validate(document)
    found = document["runs"][0]["results"]
    assert len(found) == len(findings) >= len(RULES)
    for result in found:
        assert RULES[result["ruleIndex"]].code == result["ruleId"]
        assert result["level"] in ("error", "warning", "note")


def test_rules_are_described() -> None:
    described = sarif(BOTH.encode())["runs"][0]["tool"]["driver"]["rules"]
    assert [one["id"] for one in described] == [rule.code for rule in RULES]
    assert all(one["shortDescription"]["text"] and one["help"]["text"] for one in described)
    assert [one["defaultConfiguration"]["level"] for one in described] == [rule.severity.value for rule in RULES]


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("comment", ["", "<!-- Größe ∑ 𝛴 -->"])
def test_regions_are_the_places_of_the_findings(newline: str, comment: str) -> None:
    text = BOTH.replace("<axis", f"{comment}<axis").replace("<inertia ", f"{comment}<inertia ").replace("\n", newline)
    data = text.encode()
    findings = check_one(data)
    assert len(findings) == 3
    for finding, result in zip(findings, results(data), strict=True):
        region = result["locations"][0]["physicalLocation"]["region"]
        assert region_text(data, region) == data[finding.start : finding.end].decode()
        assert (region["startLine"], region["startColumn"]) == (finding.line, finding.column)


def test_fixes_make_the_edits() -> None:
    data = BOTH.encode()
    changed = []
    for result in results(data):
        for fix in result.get("fixes", ()):
            (change,) = fix["artifactChanges"]
            assert change["artifactLocation"] == result["locations"][0]["physicalLocation"]["artifactLocation"]
            assert fix["description"]["text"]
            for one in change["replacements"]:
                changed.append((region_text(data, one["deletedRegion"]), one["insertedContent"]["text"]))
    assert changed == [(' iyx="0"', ""), ("0 2 0", "0.0 1.0 0.0")]


def test_an_edit_over_several_lines() -> None:
    data = BOTH.encode()
    finding = check_one(data)[0]
    spread = Fix("join", (Edit(data.index(b"<inertial>"), data.index(b"</inertial>"), ""),), True)
    document = of_findings([replace(finding, fix=spread)], data)
    replacement = document["runs"][0]["results"][0]["fixes"][0]["artifactChanges"][0]["replacements"][0]
    assert region_text(data, replacement["deletedRegion"]).startswith("<inertial>\n")
    assert region_text(data, replacement["deletedRegion"]).endswith(f"{IDENTITY}\n    ")


@pytest.mark.parametrize(
    ("name", "uri"),
    [
        ("robots/arm.urdf", "robots/arm.urdf"),
        ("./robots/../arm.urdf", "arm.urdf"),
        ("my robots/ärm#1.urdf", "my%20robots/%C3%A4rm%231.urdf"),
        ("/opt/my robots/arm.urdf", "file:///opt/my%20robots/arm.urdf"),
        ("<stdin>", "%3Cstdin%3E"),
        ("a:b.urdf", "a%3Ab.urdf"),
    ],
)
def test_names_of_files_are_references(name: str, uri: str) -> None:
    assert results(BOTH.encode(), name)[0]["locations"][0]["physicalLocation"]["artifactLocation"] == {"uri": uri}


def test_fingerprints_stay_when_lines_move() -> None:
    one, two = results(BOTH.encode()), results(BOTH.replace("<link", "\n\n<link").replace("0 2 0", "0 3 0").encode())
    names = [result["partialFingerprints"] for result in one]
    assert names == [result["partialFingerprints"] for result in two]
    assert len({str(name) for name in names}) == len(names)


def test_subject_and_numbers() -> None:
    axis = results(BOTH.encode())[-1]
    assert axis["locations"][0]["logicalLocations"] == [
        {"name": "shoulder", "kind": "joint", "fullyQualifiedName": "joint/shoulder"}
    ]
    assert axis["properties"] == {"measured": 2.0, "bound": 1.0}


def test_what_is_not_utf_8() -> None:
    latin = BOTH.replace('"1.0"?>', '"1.0" encoding="ISO-8859-1"?>').replace("<axis", "<!-- ä --><axis")
    region = results(latin.encode("latin-1"))[-1]["locations"][0]["physicalLocation"]["region"]
    assert region_text(latin.encode(), region) == "0 2 0"
    assert results(b"\xff\xfe\x00")[0]["ruleId"] == "RD001"


def test_places_of_a_finding_are_related_locations_that_its_message_links_to() -> None:
    data = arm(shoulder="0 2 0", elbow="0 3 0").encode()
    found = found_in(data, Options(("RD502",)), "arm.urdf").shown
    document = of_findings(found, data)
    (result,) = document["runs"][0]["results"]
    (related,) = result["relatedLocations"]
    assert (result["occurrenceCount"], related["id"]) == (2, 1)
    line = related["physicalLocation"]["region"]["startLine"]
    assert f"Also in [line {line}](1)." in result["message"]["text"]
    assert related["message"]["text"].startswith("joint 'elbow': the axis")
    assert region_text(data, related["physicalLocation"]["region"]) == "0 3 0"
    replacements = result["fixes"][0]["artifactChanges"][0]["replacements"]
    assert [region_text(data, one["deletedRegion"]) for one in replacements] == ["0 2 0", "0 3 0"]


def test_of_many_places_the_message_links_to_some() -> None:
    data = arm(shoulder="0 2 0").encode()
    finding = check_one(data, Options(("RD502",)), "arm.urdf")[0]
    (result,) = of_findings([replace(finding, others=(finding,) * 30)], data)["runs"][0]["results"]
    assert result["message"]["text"].count("](") == 20
    assert ", 10 more places. " in result["message"]["text"]
    assert len(result["relatedLocations"]) == 30


def finding(file: str = "a.urdf", message: str = "m", remedy: str = "r", cause: str | None = None) -> Finding:
    place = {"line": 3, "column": 7, "start": 0, "end": 1, "subject": None, "measured": None, "bound": None}
    text = {"code": "RD208", "name": "some-rule", "severity": Severity.ERROR, "fix": None, "excerpt": Excerpt("", 0, 1)}
    return Finding(file=file, message=message, remedy=remedy, cause=cause, **place, **text)  # type: ignore[arg-type]


def parsed(line: str) -> tuple[str, dict[str, str], str]:
    """Command, properties and message, as actions/runner takes them apart: at `::`, `,` and `=`, then unescaped."""
    match = re.fullmatch(r"::(\w+) (.*?)::(.*)", line)
    assert match is not None, line
    properties = dict(part.split("=", 1) for part in match[2].split(","))
    return match[1], {key: _plain(value) for key, value in properties.items()}, _plain(match[3])


def _plain(text: str) -> str:
    for code, character in (("%3A", ":"), ("%2C", ","), ("%0D", "\r"), ("%0A", "\n"), ("%25", "%")):
        text = text.replace(code, character)
    return text


def test_a_line_for_each_finding() -> None:
    data = arm(upper=IDENTITY, shoulder="0 0 0").encode()
    text = check_github(check_one(data, Options(FAMILIES), "robots/arm.urdf"))
    (first, second) = [parsed(line) for line in text.splitlines()]
    assert (first[0], second[0]) == ("warning", "error")
    assert second[1] == {"file": "robots/arm.urdf", "line": "21", "col": "16", "title": "RD501 zero-axis"}
    assert second[2].startswith("joint 'shoulder': ")
    assert "\nremedy: " in second[2]


@pytest.mark.parametrize(
    ("file", "shown"), [("./robots/a.urdf", "robots/a.urdf"), ("a/../b.urdf", "b.urdf"), ("<stdin>", "<stdin>")]
)
def test_paths_as_the_repository_has_them(file: str, shown: str) -> None:
    assert parsed(check_github([finding(file)]).rstrip("\n"))[1]["file"] == shown


def test_escapes() -> None:
    line = check_github([finding("a,b:c%0A.urdf", "50 % :: of\r\na, b", cause="100%")])
    assert line == (
        "::error file=a%2Cb%3Ac%250A.urdf,line=3,col=7,title=RD208 some-rule"
        "::50 %25 :: of\\r\\na, b%0Acause: 100%25%0Aremedy: r\n"
    )


@given(st.text(min_size=1), st.text(), st.text())
def test_any_text_stays_on_one_line_and_comes_back(file: str, message: str, remedy: str) -> None:
    line = check_github([finding(file, message, remedy)])
    assert line.endswith("\n")
    assert (line.count("\n"), line.count("\r")) == (1, 0)
    command, properties, _ = parsed(line[:-1])
    assert (command, properties["line"], properties["col"]) == ("error", "3", "7")
    if "%" not in file and file.isprintable():
        assert properties["file"] == os.path.normpath(file)


def test_one_annotation_for_a_finding_and_its_places() -> None:
    others = tuple(replace(finding(), line=line, subject=Subject("link", f"l{line}")) for line in (5, 9))
    line = check_github([replace(finding(), others=others)])
    assert line.count("\n") == 1
    assert "%0Aalso: 5:7 link 'l5', 9:7 link 'l9'%0Aremedy: " in line


@pytest.mark.parametrize("letter", ["\x9b", "\x85", "\u202e", "\u2066", "\x1b", "\x7f", "\u2028", "\ufeff"])
def test_nothing_turns_or_drives_what_shows_a_line(letter: str) -> None:
    """C1 is what C0 is behind an escape; marks of direction show one name for another."""
    text = check_github([finding(f"a{letter}b.urdf", f"m{letter}", f"r{letter}", f"c{letter}")])
    assert letter not in text
    assert len(text.splitlines()) == 1
    _, properties, _ = parsed(text.rstrip("\n"))
    assert properties["file"] == f"a{ascii(letter)[1:-1]}b.urdf"
