"""Findings as text, diffs, JUnit and SARIF against their schemas, and as GitHub's commands read back."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from helpers.clean_arm import FAMILIES, IDENTITY, INERTIA, arm
from helpers.command_line import run
from helpers.schemas import JUNIT, SARIF, json_schema
from hypothesis import example, given
from hypothesis import strategies as st
from jsonschema import Draft7Validator
from lxml import etree

from robodyn.checks.catalogue import RULES
from robodyn.checks.check import Checked, Options, check_one, found_in
from robodyn.checks.fixes import Fixed, fixed
from robodyn.checks.rule import Excerpt, Finding, Severity
from robodyn.report.check import check_diff, fix_lines, further, statistics_sections
from robodyn.report.document import text
from robodyn.report.renderers.findings import check_github, check_junit, check_sarif
from robodyn.robot.urdf.document import read

SCHEMA = etree.XMLSchema(etree.fromstring(JUNIT))
BAD = arm(upper=IDENTITY, shoulder="0 0 0").encode()
BOTH = arm(upper=IDENTITY, fore=INERTIA.replace("iyz", 'iyx="0" iyz'), shoulder="0 2 0")
PLANTED = arm(upper=IDENTITY, shoulder="0 2 0", elbow="0 2 0")


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
    text = [*document.iter("failure")][-1].text
    line, column = map(int, text.split(" ")[0].split(":")[1:3])
    assert BAD.decode().splitlines()[line - 1][column - 1 :].startswith('0 0 0"')
    assert "\nremedy: " in text
    outputs = [output.text for output in document.iter("system-out")]
    assert len(outputs) == 2 - len(failed)


@pytest.mark.parametrize("name", ["a\"<&>'.urdf", "a\x1b[31m\x00\x7f.urdf", "\udcff.urdf", "ä\n😀.urdf"])
def test_names_that_xml_does_not_take(name: str) -> None:
    junit((name, BAD))
    junit((name, arm().encode()))


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


def test_every_rule_gives_valid_sarif_and_junit() -> None:
    bad = {f"{rule.code}.urdf": rule.bad.encode() for rule in RULES}
    findings = [finding for name, data in bad.items() for finding in check_one(data, name=name)]
    SCHEMA.assertValid(etree.fromstring(check_junit(Checked((*bad,), tuple(findings))).encode()))
    document = json.loads(check_sarif(findings, RULES, lambda file: read(bad[file], file)))
    Draft7Validator(json_schema(SARIF)).validate(document)
    found = document["runs"][0]["results"]
    assert len(found) == len(findings) >= len(RULES)
    for result in found:
        assert RULES[result["ruleIndex"]].code == result["ruleId"]
        assert result["level"] in ("error", "warning", "note")


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("comment", ["", "<!-- Größe ∑ 𝛴 -->"])
def test_regions_are_the_places_of_the_findings(newline: str, comment: str) -> None:
    text = BOTH.replace("<axis", f"{comment}<axis").replace("<inertia ", f"{comment}<inertia ").replace("\n", newline)
    data = text.encode()
    findings = check_one(data)
    assert len(findings) == 3
    document = sarif(data)["runs"][0]
    assert [one["id"] for one in document["tool"]["driver"]["rules"]] == [rule.code for rule in RULES]
    assert document["results"][-1]["properties"] == {"measured": 2.0, "bound": 1.0}
    for finding, result in zip(findings, document["results"], strict=True):
        region = result["locations"][0]["physicalLocation"]["region"]
        assert region_text(data, region) == data[finding.start : finding.end].decode()
        assert (region["startLine"], region["startColumn"]) == (finding.line, finding.column)


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


def test_places_of_a_finding_are_related_locations_that_its_message_links_to() -> None:
    data = arm(shoulder="0 2 0", elbow="0 3 0").encode()
    found = found_in(data, Options(("RD502",)), "arm.urdf").shown
    document = of_findings(found, data)
    suites = etree.fromstring(check_junit(Checked(("arm.urdf",), found)).encode())
    SCHEMA.assertValid(suites)
    assert any("\nalso: 28:16 joint 'elbow'" in (each.text or "") for each in suites.iter("system-out"))
    (result,) = document["runs"][0]["results"]
    (related,) = result["relatedLocations"]
    assert (result["occurrenceCount"], related["id"]) == (2, 1)
    line = related["physicalLocation"]["region"]["startLine"]
    assert f"Also in [line {line}](1)." in result["message"]["text"]
    assert related["message"]["text"].startswith("joint 'elbow': the axis")
    assert region_text(data, related["physicalLocation"]["region"]) == "0 3 0"
    (fix,) = result["fixes"]
    (change,) = fix["artifactChanges"]
    assert change["artifactLocation"] == result["locations"][0]["physicalLocation"]["artifactLocation"]
    assert fix["description"]["text"]
    edits = [(region_text(data, x["deletedRegion"]), x["insertedContent"]["text"]) for x in change["replacements"]]
    assert edits == [("0 2 0", "0.0 1.0 0.0"), ("0 3 0", "0.0 1.0 0.0")]
    (result,) = of_findings([replace(found[0], others=(found[0],) * 30)], data)["runs"][0]["results"]
    assert result["message"]["text"].count("](") == 20
    assert ", 10 more places. " in result["message"]["text"]


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


@pytest.mark.parametrize("letter", ["\x9b", "\x85", "\u202e", "\u2066", "\x1b", "\x7f", "\u2028", "\ufeff"])
def test_nothing_turns_or_drives_what_shows_a_line(letter: str) -> None:
    """C1 is what C0 is behind an escape; marks of direction show one name for another."""
    text = check_github([finding(f"a{letter}b.urdf", f"m{letter}", f"r{letter}", f"c{letter}")])
    assert letter not in text
    assert len(text.splitlines()) == 1
    _, properties, _ = parsed(text.rstrip("\n"))
    assert properties["file"] == f"a{ascii(letter)[1:-1]}b.urdf"


FOUR = arm(upper=IDENTITY, fore=IDENTITY, shoulder="0 2 0", elbow="0 0 0")
SHORT = """\
robots/both.urdf
  error RD501 zero-axis
    28:16: joint 'elbow': the axis is 0 0 0, which is no direction
  warning RD208 placeholder-tensor
    8:21: link 'upper': the inertia looks like a placeholder: the identity matrix, 1 kg m^2 three times
      also 15:21 link 'fore'
  warning RD502 axis-length
    21:16: joint 'shoulder': the axis has the length 2, not 1

2 files checked: 1 error, 2 warnings, 0 notes at 4 places: not fit for use as it is
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "both.urdf").write_text(FOUR)
    (tmp_path / "robots" / "clean.urdf").write_text(arm())
    return tmp_path


def places(amount: int, alike: bool) -> Finding:
    finding = check_one(FOUR.encode(), Options(("RD208",)))[0]
    message = finding.message
    others = (replace(finding, line=100 + k, message=message + f" {k}" * (not alike)) for k in range(amount - 1))
    return replace(finding, others=tuple(others))


def test_the_short_form_is_by_file_and_rule_the_most_severe_first(folder: Path) -> None:
    found = run("check", str(folder), "--format", "short")
    assert (found.status, found.out) == (1, SHORT)
    assert run("check", "robots", "--format", "short").out == SHORT


def test_what_is_hidden_is_counted_and_named_by_the_statistics(folder: Path) -> None:
    (folder / "both.urdf").write_text(FOUR.replace('"shoulder"', '"shoulder/1"').replace('"elbow"', '"elbow/1"'))
    flags = ("check", "both.urdf", "--ignore", "RD9")
    assert "\n\nnot shown: 1 minor finding of 1 rule (--select ALL)\n1 file checked: 1 error, " in run(*flags).out
    out = run(*flags, "--statistics").out
    assert [line.split() for line in out.splitlines()[-1:]] == [["RD110", "name-portability", "1", "2", "1", "-", "-"]]
    assert "\nNot shown, since they are minor; --select ALL shows them\n" in out
    assert "Not shown" not in run("check", "both.urdf", "--statistics", "--select", "ALL").out
    only = run("check", "robots/clean.urdf", "--statistics").out
    assert only == "no findings\n"


def test_few_places_are_listed_in_a_row_and_many_cut() -> None:
    assert further(places(1, True)) == []
    assert further(places(3, True)) == ["100:21 link 'upper', 101:21 link 'upper'"]
    assert further(places(3, False))[1].startswith("101:21 link 'upper': the inertia looks")
    row = " ".join(further(places(60, True)))
    assert (row.count("link"), row.endswith(", 19 more places")) == (40, True)
    lines = further(places(60, False))
    assert (len(lines), lines[-1]) == (11, "49 more places")
    assert all(len(line) <= 100 for line in further(places(60, True)))


def repaired(data: bytes) -> Fixed:
    return fixed(data, "robots/arm.urdf", lambda changed: check_one(changed, name="robots/arm.urdf"))


def applied(diff: str, before: bytes, folder: Path) -> bytes:
    """What the program patch makes of a text."""
    path = folder / "arm.urdf"
    path.write_bytes(before)
    data = diff.encode("utf-8", "surrogateescape")
    subprocess.run(["patch", "--binary", "--silent", str(path)], input=data, check=True, capture_output=True)
    return path.read_bytes()


@pytest.mark.skipif(shutil.which("patch") is None, reason="there is no patch")
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("end", ["", "\n\n"])
def test_patch_makes_the_same(newline: str, end: str, tmp_path: Path) -> None:
    text = (PLANTED.rstrip("\n") + end).replace("<link", "<!-- ä\u2028\x85 -->\n<link", 1)
    result = repaired(text.replace("\n", newline).encode())
    assert result.after != result.before
    assert applied(check_diff(result), result.before, tmp_path) == result.after


@example(b"", b"\0")
@given(st.binary(max_size=30), st.binary(max_size=30))
def test_any_bytes(before: bytes, after: bytes) -> None:
    diff = check_diff(Fixed("a", before, after))
    assert (diff == "") == (before == after)
    assert not diff or diff.endswith("\n")


def test_a_line_for_each_fix() -> None:
    assert fix_lines([repaired(PLANTED.encode())], "fixed") == [
        "fixed: robots/arm.urdf:21: RD502, joint shoulder: divide the axis by its length "
        "(safe: the dynamics stay as they are)",
        "fixed: robots/arm.urdf:28: RD502, joint elbow: divide the axis by its length "
        "(safe: the dynamics stay as they are)",
    ]
    broken = PLANTED.replace('<child link="fore"/>', "").encode()
    assert [line.split(": ")[0] for line in fix_lines([repaired(broken)], "fixed")] == ["not fixed", "not fixed"]


def test_statistics() -> None:
    findings = [one for name in ("a", "b") for one in check_one(PLANTED.encode(), name=name)]
    findings += check_one(arm(upper=IDENTITY).encode(), name="a")
    head, *rows = text(statistics_sections(Checked(("a", "b"), tuple(findings)))).splitlines()
    assert head.split("  ")[0] == "rule"
    assert [row.split() for row in rows] == [
        ["RD502", "axis-length", "4", "4", "2", "4", "-"],
        ["RD208", "placeholder-tensor", "3", "3", "2", "-", "-"],
    ]
    assert text(statistics_sections(Checked((), ()))) == "no findings\n"
