"""Findings that are known: robust to moved lines and changed numbers, and only those."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.clean_arm import FAMILIES, IDENTITY, arm

from robodyn.checks.baseline import compared, fingerprints, identity, write_baseline
from robodyn.checks.check import Options, check, check_one
from robodyn.checks.rule import Finding
from robodyn.errors import InputError

PLANTED = arm(upper=IDENTITY, shoulder="0 2 0")


def findings_in(path: Path, text: str) -> tuple[Finding, ...]:
    path.write_text(text)
    return check(path, Options(FAMILIES))


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    return tmp_path / "robots" / "arm.urdf"


@pytest.fixture
def baseline(tmp_path: Path, urdf: Path) -> str:
    urdf.parent.mkdir()
    path = str(tmp_path / "baseline.json")
    assert write_baseline(findings_in(urdf, PLANTED), path) == 2
    return path


@pytest.mark.parametrize(
    "text",
    [
        PLANTED,
        PLANTED.replace("<link", "\n\n  <!-- moved -->\n <link"),
        arm(upper=IDENTITY, shoulder="0 1.003e3 0"),
        arm(upper=IDENTITY, shoulder="0 -0.25 0"),
        PLANTED.replace('<link name="base"/>', "").replace("</robot>", '<link name="base"/></robot>'),
    ],
)
def test_lines_may_move_and_numbers_change(urdf: Path, baseline: str, text: str) -> None:
    result = compared(findings_in(urdf, text), baseline)
    assert (result.new, result.known, result.gone) == ((), 2, 0)


@pytest.mark.parametrize(
    ("text", "new", "known"),
    [
        (arm(upper=IDENTITY, shoulder="0 2 0", elbow="0 2 0"), ["RD502"], 2),
        (arm(fore=IDENTITY, shoulder="0 2 0"), ["RD208"], 1),
        (arm(shoulder="0 0 0"), ["RD501"], 0),
    ],
)
def test_what_is_new_counts(urdf: Path, baseline: str, text: str, new: list[str], known: int) -> None:
    result = compared(findings_in(urdf, text), baseline)
    assert ([finding.code for finding in result.new], result.known, result.gone) == (new, known, 2 - known)


def test_another_file_is_new(urdf: Path, baseline: str) -> None:
    other = urdf.with_name("leg.urdf")
    result = compared(findings_in(other, PLANTED), baseline)
    assert ([finding.code for finding in result.new], result.known) == (["RD208", "RD502"], 0)


def test_the_current_folder_does_not_matter(urdf: Path, baseline: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(urdf.parent)
    assert compared(check("arm.urdf"), "../baseline.json").known == 2


def test_as_often_as_it_was_there(urdf: Path, baseline: str) -> None:
    finding = check(urdf)[0]
    write_baseline([finding] * 2, baseline)
    assert Path(baseline).read_text().count('"count": 2') == 1
    result = compared([finding] * 3, baseline)
    assert (len(result.new), result.known) == (1, 2)
    assert write_baseline([], baseline) == 0
    assert compared(check(urdf), baseline).known == 0


def test_one_line_for_each_in_order_and_the_same_again(urdf: Path, baseline: str) -> None:
    text = Path(baseline).read_text()
    write_baseline(reversed(check(urdf)), baseline)
    assert Path(baseline).read_text() == text
    lines = [line.strip() for line in text.splitlines() if '"code"' in line]
    assert ['"RD208"' in lines[0], '"RD502"' in lines[1], len(lines)] == [True, True, 2]
    assert lines[1].startswith('{"file": "robots/arm.urdf", "code": "RD502", "subject": "joint shoulder", "message": ')


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{}", '{"robodyn_baseline": 2, "findings": []}', '{"robodyn_baseline": 1}', "[" * 100_000, "\xff"]
    + [f'{{"robodyn_baseline": 1, "findings": {value}}}' for value in ("[1]", "1", '[{"file": "a"}]')],
    ids=lambda text: text[:50],
)
def test_no_baseline(tmp_path: Path, text: str) -> None:
    path = tmp_path / "some.json"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(InputError, match=r"some\.json: this is no baseline"):
        compared([], str(path))


def test_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such baseline"):
        compared([], str(tmp_path / "no.json"))
    with pytest.raises(InputError, match="cannot be written: no such file"):
        write_baseline([], str(tmp_path / "no" / "baseline.json"))


def test_names_keep_their_digits() -> None:
    first, second = (
        check_one(arm(upper=IDENTITY).replace("upper", name).encode(), name="a.urdf")[0] for name in ("l1", "l2")
    )
    assert identity(first) != identity(second)


def test_fingerprints_tell_the_same_findings_apart_and_stay() -> None:
    finding = check_one(PLANTED.encode(), name="a.urdf")[0]
    moved = check_one(f"\n{PLANTED[22:]}\n".encode(), name="a.urdf")[0]
    one, two = fingerprints([finding, finding])
    assert one != two
    assert moved.start != finding.start
    assert list(fingerprints([moved])) == [one]
