"""Workflow commands, read back as GitHub's runner reads them."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path

import pytest
from helpers.clean_arm import FAMILIES, IDENTITY, arm
from helpers.command_line import run
from hypothesis import given
from hypothesis import strategies as st

from robodyn.checks.check import Options, check_one
from robodyn.checks.rule import Excerpt, Finding, Severity
from robodyn.report.renderers.findings import check_github
from robodyn.robot.urdf.view import Subject


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


def test_escape_sequences_in_names_of_files_are_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    name = "a\x1b[31m\x1b]8;;b.urdf"
    Path(name).write_text(arm(upper=IDENTITY))
    first = run("check", name, "--format", "github").out.splitlines()[0]
    assert parsed(first)[1]["file"] == r"a\x1b[31m\x1b]8;;b.urdf"


def test_nothing_found() -> None:
    assert check_github(()) == ""


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


def test_severities() -> None:
    text = check_github([replace(finding(), severity=severity) for severity in Severity])
    assert [line.split()[0] for line in text.splitlines()] == ["::error", "::warning", "::notice"]


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
