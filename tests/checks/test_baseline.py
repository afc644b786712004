"""Findings that are known, whatever moves about them, and those that comments allow."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.clean_arm import FAMILIES, IDENTITY, INERTIA, arm

from robodyn.checks.check import Options, check, check_one
from robodyn.checks.groups import compared, fingerprints, identity, write_baseline
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
    assert compared(findings_in(urdf, text), baseline) == ((), 2, 0)


@pytest.mark.parametrize(
    ("text", "new", "known"),
    [
        (arm(upper=IDENTITY, shoulder="0 2 0", elbow="0 2 0"), ["RD502"], 2),
        (arm(fore=IDENTITY, shoulder="0 2 0"), ["RD208"], 1),
        (arm(shoulder="0 0 0"), ["RD501"], 0),
    ],
)
def test_what_is_new_counts(urdf: Path, baseline: str, text: str, new: list[str], known: int) -> None:
    found, *counts = compared(findings_in(urdf, text), baseline)
    assert ([finding.code for finding in found], counts) == (new, [known, 2 - known])


def test_another_file_is_new_and_the_current_folder_does_not_matter(
    urdf: Path, baseline: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    new, known, _ = compared(findings_in(urdf.with_name("leg.urdf"), PLANTED), baseline)
    assert ([finding.code for finding in new], known) == (["RD208", "RD502"], 0)
    urdf.write_text(PLANTED)
    monkeypatch.chdir(urdf.parent)
    assert compared(check("arm.urdf"), "../baseline.json")[1] == 2


def test_as_often_as_it_was_there(urdf: Path, baseline: str) -> None:
    finding = check(urdf)[0]
    write_baseline([finding] * 2, baseline)
    assert Path(baseline).read_text().count('"count": 2') == 1
    new, known, _ = compared([finding] * 3, baseline)
    assert (len(new), known) == (1, 2)
    assert write_baseline([], baseline) == 0
    assert compared(check(urdf), baseline)[1] == 0


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
    with pytest.raises(InputError, match="there is no such baseline"):
        compared([], str(tmp_path / "no.json"))
    with pytest.raises(InputError, match="cannot be written: no such file"):
        write_baseline([], str(tmp_path / "no" / "baseline.json"))


def test_fingerprints_tell_the_same_findings_apart_and_stay() -> None:
    """Names keep their digits."""
    named = [check_one(arm(upper=IDENTITY).replace("upper", name).encode())[0] for name in ("l1", "l2")]
    assert identity(named[0]) != identity(named[1])
    finding = check_one(PLANTED.encode(), name="a.urdf")[0]
    moved = check_one(f"\n{PLANTED[22:]}\n".encode(), name="a.urdf")[0]
    one, two = fingerprints([finding, finding])
    assert one != two
    assert moved.start != finding.start
    assert list(fingerprints([moved])) == [one]


REASON = "no tensor is published, see issue 52"
WAIVER = f"<!-- robodyn: allow RD208 {REASON} -->"
PLACEHOLDERS = arm(upper=IDENTITY, fore=IDENTITY)


def found(text: str, *select: str) -> list[tuple[str, str]]:
    findings = check_one(text.encode(), Options(select or FAMILIES))
    return [(finding.code, finding.subject.name if finding.subject else "") for finding in findings]


@pytest.mark.parametrize(
    ("anchor", "text"),
    [
        ('<link name="upper">', f'{WAIVER} <link name="upper">'),
        ('<link name="upper">', f'{WAIVER}<!-- another --><link name="upper">'),
        ('<link name="upper">', f'{WAIVER}\n\n<!-- more -->\n<link name="upper">'),
        ('<link name="upper">', f'<link name="upper"> <!-- another --> {WAIVER}'),
        ('<link name="upper">', f'<link\n name="upper"> {WAIVER}'),
        ('<link name="upper">', f'{WAIVER}\r<link name="upper">'),
        ('<link name="upper">', f'<!--\n  robodyn:\n  allow RD208\n  {REASON}\n-->\n<link name="upper">'),
        ("<inertial>", f"{WAIVER}\n<inertial>"),
        (IDENTITY, f"{IDENTITY} {WAIVER}"),
        ("</inertial>", f"</inertial>{WAIVER}"),
        ("</link>", f"</link > {WAIVER}"),
    ],
)
def test_on_or_above_the_element(anchor: str, text: str) -> None:
    head, tail = PLACEHOLDERS.split('<link name="upper">')
    assert found(head + ('<link name="upper">' + tail).replace(anchor, text, 1)) == [("RD208", "fore")]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (arm(), []),
        (PLACEHOLDERS, [("RD208", "upper"), ("RD208", "fore")]),
        (PLACEHOLDERS.replace("<robot", f"{WAIVER}<robot"), []),
        (PLACEHOLDERS.replace('<robot name="arm">', f'<robot name="arm"> {WAIVER}'), []),
        (
            PLACEHOLDERS.replace("</robot>", f"  {WAIVER}\n</robot>"),
            [("RD208", "upper"), ("RD208", "fore"), ("RD009", "")],
        ),
        (
            PLACEHOLDERS.replace('<link name="base"/>', f'<link name="base"/> {WAIVER}'),
            [("RD009", ""), ("RD208", "upper"), ("RD208", "fore")],
        ),
        (arm(upper=f"{INERTIA} {WAIVER}"), [("RD009", "")]),
        (
            PLACEHOLDERS.replace("<robot", "<!-- robodyn allow RD208 x --><!-- see robodyn: allow RD208 x --><robot"),
            [("RD208", "upper"), ("RD208", "fore")],
        ),
    ],
    ids=["nothing", "no waiver", "before the robot", "in its tag", "at the end", "elsewhere", "unused", "others"],
)
def test_of_the_robot_elsewhere_and_none(text: str, expected: list[tuple[str, str]]) -> None:
    assert found(text) == expected


def test_nothing_is_waived_in_a_file_that_cannot_be_read() -> None:
    text = f"<!-- robodyn: allow RD001 {REASON} --><robot><link></robot>"
    assert [finding.code for finding in check_one(text.encode())] == ["RD001"]


def test_unused_only_if_the_rule_has_run_and_of_several_codes_the_one() -> None:
    several = arm(upper=IDENTITY, shoulder="0 2 0")
    waiver = "<!-- robodyn: allow RD208, RD502,RD207: all of this is known -->"
    assert found(several.replace("<robot", f"{waiver}<robot")) == [("RD009", "")]
    text = arm().replace("<robot", f"{WAIVER}<robot")
    assert found(text) == [("RD009", "")]
    assert found(text, "RD5", "RD009") == []
    assert found(text, "RD208") == []
    assert found(text, "RD208", "RD009") == [("RD009", "")]


def test_unused_names_the_code_and_the_place() -> None:
    text = PLACEHOLDERS.replace('<link name="upper">', '<!-- robodyn: allow RD208,RD207 both -->\n<link name="upper">')
    (finding,) = check_one(text.encode(), Options(("RD009",))) or check_one(text.encode(), Options(("RD009", "RD207")))
    assert finding.message == "the waiver of RD207 has nothing to waive"
    assert text.encode()[finding.start : finding.end] == b"<!-- robodyn: allow RD208,RD207 both -->"


@pytest.mark.parametrize(
    ("comment", "message"),
    [
        ("robodyn: allow RD208", "the waiver of RD208 gives no reason"),
        ("robodyn: allow RD208, RD207 -", "the waiver of RD208, RD207 gives no reason"),
        ("robodyn: allow RD999 why not", "the waiver names 'RD999', which no rule has"),
        ("robodyn: allow RD2 why not", "the waiver names 'RD2', which no rule has"),
        ("robodyn: ignore RD208 why not", "the comment 'robodyn: ignore RD208 why not' is not understood"),
        ("robodyn: ", "the comment 'robodyn: ' is not understood"),
        ("robodyn: allow RD208,RD008 why not", "RD008 cannot be waived"),
    ],
)
def test_not_in_force(comment: str, message: str) -> None:
    text = PLACEHOLDERS.replace("<robot", f"<!-- {comment} -->\n<robot")
    findings = check_one(text.encode(), Options(FAMILIES))
    assert [finding.code for finding in findings] == ["RD008", "RD208", "RD208"]
    assert findings[0].message == message
    assert (findings[0].line, findings[0].column) == (2, 1)


def test_letters_beyond_ascii() -> None:
    text = PLACEHOLDERS.replace("<robot", "<!-- robodyn: allow RD208 Prüfgewicht — ohne Tensor --><robot")
    assert found(text) == []
    latin = text.replace("—", "-").replace('<?xml version="1.0"?>', '<?xml version="1.0" encoding="ISO-8859-1"?>')
    assert check_one(latin.encode("latin-1")) == ()
    assert check_one(text.replace("<?xml", "<?xml", 1).encode("utf-16")) == ()
