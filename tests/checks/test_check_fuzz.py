"""Whatever the bytes, checking ends, raises nothing and finds places that exist; what urdfdom refuses is an error."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.planted_defects import DEFECTS, HEALTHY
from helpers.sampled import sampled
from helpers.urdfdom import check_urdf, refused
from hypothesis import given
from hypothesis import strategies as st
from pinned_findings import name_of, published

from robodyn.checks.check import Options, check_one
from robodyn.checks.context import Context
from robodyn.checks.rule import Finding, Severity
from robodyn.checks.waivers import waivers
from robodyn.robot.urdf.document import read
from robodyn.robot.urdf.sources import LONGEST, long_token

DATA = HEALTHY.encode()
CHUNKS = st.sampled_from(
    [b"", b"<", b">", b'"', b"'", b"&", b"&a;", b"<!--", b"]]>", b"<![CDATA[", b"<?x?>", b"${", b"nan", b"-", b"1e999",
     b"\0", b"\xff", b"\xc3\xa9", b'value=""', b"<link/>", b"<joint/>", b"<inertial/>", b"<mimic/>", b"<axis/>",
     b"<!DOCTYPE r>", b"xacro:a", b" a:b='c'", b"\xef\xbb\xbf", b"0 0 0", b" 1"]
)  # fmt: skip


def sound(data: bytes) -> None:
    for finding in check_one(data):
        assert finding.line >= 1
        assert finding.column >= 1
        assert 0 <= finding.start <= finding.end
        assert finding.end <= len(data) or data[:2] in (b"\xff\xfe", b"\xfe\xff")
        excerpt = finding.excerpt
        assert 0 <= excerpt.start <= len(excerpt.text)
        assert "\n" not in excerpt.text


@given(st.integers(0, len(DATA)), st.integers(0, 40), CHUNKS, st.integers(0, len(DATA)), st.integers(0, 40), CHUNKS)
def test_a_robot_with_pieces_replaced(a: int, m: int, first: bytes, b: int, n: int, second: bytes) -> None:
    a, b = sorted((a, b))
    sound(DATA[:a] + first + DATA[min(a + m, b) : b] + second + DATA[b + n :])


@given(st.binary(max_size=60))
def test_any_bytes(data: bytes) -> None:
    sound(data)
    sound(b"<robot name='r'>" + data + b"</robot>")


@pytest.mark.parametrize("encoding", ["foo", "hex", "rot13", "utf-16", "utf-7", "idna", "big5", ""])
def test_an_encoding_that_is_none_is_found(encoding: str) -> None:
    data = f'<?xml version="1.0" encoding="{encoding}"?>\n<robot name="é"/>'.encode()
    sound(data)
    assert {finding.code for finding in check_one(data)} == {"RD001"}


@given(st.lists(st.sampled_from(DEFECTS), min_size=2, max_size=5))
def test_several_defects_at_once(defects: list) -> None:  # type: ignore[type-arg]
    text = HEALTHY
    for defect in defects:
        text = text.replace(defect.old, defect.new.replace("@", ""))
    sound(text.encode())


def test_a_file_cut_off_anywhere() -> None:
    for cut in range(0, len(DATA), 97):
        assert {finding.code for finding in check_one(DATA[:cut])} == {"RD001"}


MANY = 1_100
"""More than Python recurses."""
STRUCTURE = Options(select=("RD0", "RD1", "RD2"))


def found(body: str) -> tuple[Finding, ...]:
    return check_one(f'<robot name="r">{body}</robot>'.encode(), STRUCTURE)


def joints(pairs: list[tuple[int, int]], kind: str = "fixed") -> str:
    return "".join(
        f'<joint name="j{k}" type="{kind}"><parent link="{a}"/><child link="{b}"/></joint>'
        for k, (a, b) in enumerate(pairs)
    )


def links(count: int) -> str:
    return "".join(f'<link name="{k}"/>' for k in range(count))


def codes(findings: tuple[Finding, ...]) -> dict[str, int]:
    names = [finding.code for finding in findings]
    return {code: names.count(code) for code in set(names) if code != "RD110"}


ROW = [(k, k + 1) for k in range(MANY - 1)]
ATTRIBUTES = " ".join(f"b{k}=''" for k in range(MANY))
LARGE = {
    "one long cycle": (links(MANY) + joints([(k, (k + 1) % MANY) for k in range(MANY)]), {"RD103": 1}),
    "a long tail into a cycle": (links(MANY) + joints([(max(k - 1, 0), k) for k in range(MANY)]), {"RD103": 1}),
    "a long chain that is fixed": (links(MANY) + joints(ROW), {}),
    "a long chain that moves": (links(MANY) + joints(ROW, "floating"), {"RD202": MANY - 1}),
    "many links apart": (links(MANY), {"RD104": 1}),
    "many short cycles": (links(MANY) + joints([(k ^ 1, k) for k in range(MANY)]), {"RD103": MANY // 2}),
    "many of one name": ('<link name="a"/>' * MANY, {"RD105": MANY - 1}),
    "deep nesting": ("<a>" * 100_000 + "</a>" * 100_000, {"RD001": 1}),
    "many attributes": (f"<link name='a'><visual {ATTRIBUTES}/></link>", {"RD005": MANY}),
    "many dangling joints": ('<link name="a"/>' + joints([*ROW, (MANY - 1, MANY)]), {"RD101": 2 * MANY}),
}


@pytest.mark.parametrize("kind", LARGE)
def test_large(kind: str) -> None:
    body, expected = LARGE[kind]
    findings = found(body)
    assert codes(findings) == expected
    assert all(len(finding.message) < 1000 for finding in findings)


def test_many_comments_in_a_line() -> None:
    """Each byte of the line is looked at once: 5000 comments take a tenth of a second, not one."""
    waiver = "<!-- robodyn: allow RD208 known -->"
    reading = read(f'<robot name="r"><link name="a"/>{waiver * 5_000}<link name="b"/></robot>'.encode())
    given = waivers(Context(reading))
    assert len(given) == 5_000
    assert {reading.data[waiver.start :][:16] for waiver in given} == {b'<link name="a"/>'}


@pytest.mark.parametrize("text", ["1 " * 100_000, "9" * 1_000_000, "x" * 1_000_000])
def test_a_long_attribute(text: str) -> None:
    (finding,) = [
        f for f in found(f'<link name="a"><inertial><mass value="{text}"/></inertial></link>') if f.code == "RD007"
    ]
    assert len(finding.message) < 300
    assert len(finding.excerpt.text) < 300


LINK = b"""<robot name="r">
  <link name="a">"""
LONG = {
    "attribute": (b'<inertial><mass unit="kg" value="@', b"9", b'"/>'),
    "attribute of blanks": (b"<inertial><mass unit='' value='@", b"1 ", b"'/>"),
    "attribute without an end": (b'<visual name="@', b"x", b""),
    "attribute full of >": (b'<visual name="@', b">", b'"/>'),
    "tag": (b"@<visual ", b"a='1' ", b"/>"),
    "text": (b'<visual name=">"/>@', b"\n", b""),
    "text of letters": (b"<visual/>@", b"x", b"<visual/>"),
    "comment": (b"<visual/>@<!--", b"x", b"-->"),
    "comment full of tags": (b"<visual/>@<!--", b"<a/>", b"-->"),
    "comment without an end": (b"<visual/><!-- --> @<!--", b"<", b""),
}


@pytest.mark.parametrize("kind", LONG)
def test_a_token_that_is_too_long_is_not_read(kind: str) -> None:
    before, piece, after = LONG[kind]
    size = LONGEST + 1000
    data, shorter = (
        LINK + before.replace(b"@", b"") + piece * (length // len(piece)) + after + b"</link></robot>"
        for length in (size, 10_000)
    )
    assert long_token(shorter) is None
    assert long_token(shorter * (LONGEST // 5_000)) is None or not after
    (finding,) = check_one(data)
    column = len("  <link name='a'>") + before.index(b"@") + 1
    assert (finding.code, finding.line, finding.column) == ("RD001", 2, column)
    assert finding.message.startswith(f"{kind.partition(' ')[0]} of {size}"[:-4])
    assert len(finding.excerpt.text) < 300
    assert len(read(data).data) < 1000


HALF = LONGEST // 2
BEFORE = '<robot name="a"><!-- c -->'
BEHIND = {
    "a comment": (BEFORE, LONGEST + 5, len(BEFORE)),
    "a comment, with an apostrophe": (f"{BEFORE}it's ", LONGEST + 5, len(BEFORE)),
    "nothing": ("", LONGEST + 5, 0),
    "a long comment with an apostrophe": (f"<robot><!--'{'c' * HALF}-->", HALF + 50, len("<robot><!--'-->") + HALF),
}


@pytest.mark.parametrize("kind", BEHIND)
def test_long_text_begins_behind(kind: str) -> None:
    before, letters, start = BEHIND[kind]
    data = f"{before}{'x' * letters}<link/></robot>".encode()
    end = len(before) + letters
    assert long_token(data) == (start, end, "text")
    (finding,) = check_one(data)
    assert (finding.line, finding.column) == (1, start + 1)
    assert finding.message.startswith(f"text of {end - start} bytes")


def test_an_expansion_bomb_is_never_expanded() -> None:
    entities = "".join(f'<!ENTITY e{k + 1} "{f"&e{k};" * 10}">' for k in range(30))
    data = f'<!DOCTYPE r [<!ENTITY e0 "ha">{entities}]><robot name="&e30;"/>'.encode()
    assert [finding.code for finding in check_one(data)] == ["RD002"]


SLIPS = (
    ('<robot name="picker">', '<robot name="picker" version="2.0">'),
    ('<robot name="picker">', '<robot name="picker">' + 2 * '<material name="red"><color rgba="1 0 0 1"/></material>'),
    ('effort="120" ', ""),
    (' velocity="3"', ""),
    ('<joint name="mount" type="fixed">', '<joint name="mount" type="fixed"><limit effort="1"/>'),
    (' k_velocity="10"', ""),
    ('<dynamics damping="0.4" friction="0.6"/>', "<dynamics/>"),
    ('<mimic joint="grip" ', "<mimic "),
    ('xyz="0.05 0 0.02"', 'xyz="0.05\u00a00 0.02"'),
    ("<child link=", "<offspring link="),
    ('name="lens"/>', 'name=" lens"/>'),
    ('<limit lower="-2.9" upper="2.8" effort="120" velocity="2.5"/>', ""),
)


needs_urdfdom = pytest.mark.skipif(check_urdf() is None, reason="urdfdom is not installed")


def has_errors(file: Path) -> bool:
    return any(one.severity is Severity.ERROR for one in check_one(str(file), Options(ignore=("RD901",))))


@needs_urdfdom
@pytest.mark.parametrize(("old", "new"), SLIPS)
def test_slips(tmp_path: Path, old: str, new: str) -> None:
    file = tmp_path / "picker.urdf"
    file.write_text(HEALTHY.replace(old, new, 1), encoding="utf-8")
    assert refused(file)
    assert has_errors(file)


@needs_urdfdom
@pytest.mark.parametrize("path", sampled(published()), ids=name_of)
def test_published_robots(path: Path) -> None:
    assert not refused(path) or has_errors(path)
