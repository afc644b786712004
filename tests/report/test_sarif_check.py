"""SARIF against the published schema, and what it says against the text that it speaks of."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest
from helpers.clean_arm import IDENTITY, INERTIA, arm
from helpers.schemas import SARIF, json_schema
from jsonschema import Draft7Validator

from robodyn.checks.catalogue import RULES
from robodyn.checks.check import Options, check_one, found_in
from robodyn.checks.rule import Edit, Fix, Severity
from robodyn.report.renderers.findings import check_sarif
from robodyn.robot.urdf.document import read

BOTH = arm(upper=IDENTITY, fore=INERTIA.replace("iyz", 'iyx="0" iyz'), shoulder="0 2 0")


def sarif(data: bytes, name: str = "robots/arm.urdf") -> Any:
    text = check_sarif(check_one(data, name=name), RULES, lambda file: read(data, file))
    document = json.loads(text, parse_constant=pytest.fail)
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


def test_the_schema_would_refuse_what_is_wrong() -> None:
    validator = Draft7Validator(json_schema(SARIF))
    document = sarif(BOTH.encode())
    document["runs"][0]["results"][0]["locations"][0]["physicalLocation"]["region"]["startLine"] = 0
    assert not validator.is_valid(document)


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


def test_nothing_found() -> None:
    assert results(arm().encode()) == []


def test_rules_are_described() -> None:
    described = sarif(BOTH.encode())["runs"][0]["tool"]["driver"]["rules"]
    assert [one["id"] for one in described] == [rule.code for rule in RULES]
    assert all(one["shortDescription"]["text"] and one["help"]["text"] for one in described)
    levels = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.NOTE: "note"}
    assert [one["defaultConfiguration"]["level"] for one in described] == [levels[rule.severity] for rule in RULES]


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
    for result in results(data):
        for fix in result.get("fixes", ()):
            (change,) = fix["artifactChanges"]
            assert change["artifactLocation"] == result["locations"][0]["physicalLocation"]["artifactLocation"]
            assert fix["description"]["text"]
    changed = [
        (region_text(data, one["deletedRegion"]), one["insertedContent"]["text"])
        for result in results(data)
        for fix in result.get("fixes", ())
        for one in fix["artifactChanges"][0]["replacements"]
    ]
    assert changed == [(' iyx="0"', ""), ("0 2 0", "0.0 1.0 0.0")]


def test_an_edit_over_several_lines() -> None:
    data = BOTH.encode()
    finding = check_one(data)[0]
    spread = Fix("join", (Edit(data.index(b"<inertial>"), data.index(b"</inertial>"), ""),), True)
    changed = [type(finding)(**{name: getattr(finding, name) for name in finding.__slots__} | {"fix": spread})]
    document = json.loads(check_sarif(changed, RULES, lambda file: read(data, file)))
    Draft7Validator(json_schema(SARIF)).validate(document)
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


def test_the_schema_is_named() -> None:
    document = sarif(BOTH.encode())
    assert document["$schema"].endswith("/sarif-schema-2.1.0.json")


def test_places_of_a_finding_are_related_locations_that_its_message_links_to() -> None:
    data = arm(shoulder="0 2 0", elbow="0 3 0").encode()
    found = found_in(data, Options(("RD502",)), "arm.urdf").shown
    document = json.loads(check_sarif(found, RULES, lambda file: read(data, file)))
    Draft7Validator(json_schema(SARIF)).validate(document)
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
    finding = check_one(arm(shoulder="0 2 0").encode(), Options(("RD502",)), "arm.urdf")[0]
    many = [replace(finding, others=(finding,) * 30)]
    document = json.loads(check_sarif(many, RULES, lambda file: read(arm(shoulder="0 2 0").encode(), file)))
    (result,) = document["runs"][0]["results"]
    assert result["message"]["text"].count("](") == 20
    assert ", 10 more places. " in result["message"]["text"]
    assert len(result["relatedLocations"]) == 30
