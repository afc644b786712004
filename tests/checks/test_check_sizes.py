"""Large files: nothing recurses, nothing is quadratic, and a message stays short."""

from __future__ import annotations

import pytest

from robodyn.checks.bodies.contacts import Sides
from robodyn.checks.check import Options, check_one
from robodyn.checks.context import Context
from robodyn.checks.rule import Finding
from robodyn.checks.waivers import waivers
from robodyn.robot.urdf.document import read
from robodyn.robot.urdf.numbers import _parsed_before, parse_numbers
from robodyn.robot.urdf.sources import LONGEST, long_token

MANY = 10_000
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
LARGE = {
    "one long cycle": (links(MANY) + joints([(k, (k + 1) % MANY) for k in range(MANY)]), {"RD103": 1}),
    "a long tail into a cycle": (links(MANY) + joints([(max(k - 1, 0), k) for k in range(MANY)]), {"RD103": 1}),
    "a long chain that is fixed": (links(MANY) + joints(ROW), {}),
    "a long chain that moves": (links(MANY) + joints(ROW, "floating"), {"RD202": MANY - 1}),
    "many links apart": (links(MANY), {"RD104": 1}),
    "many dangling joints": ('<link name="a"/>' + joints([*ROW, (MANY - 1, MANY)]), {"RD101": 2 * MANY}),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", LARGE)
def test_large(kind: str) -> None:
    body, expected = LARGE[kind]
    findings = found(body)
    assert codes(findings) == expected
    assert all(len(finding.message) < 1000 for finding in findings)


def test_many_short_cycles_and_many_of_one_name() -> None:
    pairs = [(k ^ 1, k) for k in range(MANY)]
    assert codes(found(links(MANY) + joints(pairs))) == {"RD103": MANY // 2}
    assert codes(found('<link name="a"/>' * MANY)) == {"RD105": MANY - 1}


def test_a_chain_below_one_shape() -> None:
    """The next shape above each joint is the root's."""
    count = MANY // 10
    ball = '<link name="0"><visual><geometry><sphere radius="1"/></geometry></visual></link>'
    body = links(count).replace('<link name="0"/>', ball) + joints([(k, k + 1) for k in range(count - 1)], "floating")
    context = Context(read(f'<robot name="r">{body}</robot>'.encode()))
    sides = Sides(context)
    asked = Counted(sides.shaped)
    sides.shaped = asked
    assert all(sides._sides(joint)[1] == ["0"] for joint in context.view.joints)
    assert asked.times < 10 * count


class Counted(dict):
    """How often it is asked whether a key is there."""

    times = 0

    def __contains__(self, key: object) -> bool:
        self.times += 1
        return super().__contains__(key)


def test_many_comments_in_a_line() -> None:
    """Each byte of the line is looked at once: 20 000 comments take a third of a second, not ten."""
    waiver = "<!-- robodyn: allow RD208 known -->"
    reading = read(f'<robot name="r"><link name="a"/>{waiver * (2 * MANY)}<link name="b"/></robot>'.encode())
    given = waivers(Context(reading))
    assert len(given) == 2 * MANY
    assert {reading.data[waiver.start :][:16] for waiver in given} == {b'<link name="a"/>'}


@pytest.mark.parametrize("text", ["1 " * 1_000_000, "9" * 1_000_000, "x" * 1_000_000])
def test_a_long_attribute(text: str) -> None:
    (finding,) = [
        f for f in found(f'<link name="a"><inertial><mass value="{text}"/></inertial></link>') if f.code == "RD007"
    ]
    assert len(finding.message) < 300
    assert len(finding.excerpt.text) < 300


def test_long_numbers_are_not_kept() -> None:
    kept = _parsed_before.cache_info().currsize
    assert parse_numbers("1 " * 41, 41) == (1.0,) * 41
    assert _parsed_before.cache_info().currsize == kept


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


@pytest.mark.parametrize("size", [LONGEST + 1000, pytest.param(100_000_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", LONG)
def test_a_token_that_is_too_long_is_not_read(kind: str, size: int) -> None:
    before, piece, after = LONG[kind]
    data = LINK + before.replace(b"@", b"") + piece * (size // len(piece)) + after + b"</link></robot>"
    (finding,) = check_one(data)
    column = len("  <link name='a'>") + before.index(b"@") + 1
    assert (finding.code, finding.line, finding.column) == ("RD001", 2, column)
    assert finding.message.startswith(f"{kind.partition(' ')[0]} of {size}"[:-4])
    assert len(finding.excerpt.text) < 300
    assert len(read(data).data) < 1000


@pytest.mark.parametrize("kind", LONG)
def test_shorter_tokens_are_read(kind: str) -> None:
    before, piece, after = LONG[kind]
    data = LINK + before.replace(b"@", b"") + piece * (10_000 // len(piece)) + after + b"</link></robot>"
    assert long_token(data * (LONGEST // 5_000)) is None or not after
    assert long_token(data) is None


HALF = LONGEST // 2
BEFORE = '<robot name="a"><!-- c -->'
BEHIND = {
    "a comment": (BEFORE, LONGEST + 5, len(BEFORE)),
    "a comment, with an apostrophe": (f"{BEFORE}it's ", LONGEST + 5, len(BEFORE)),
    "nothing": ("", LONGEST + 5, 0),
    "a tag, with an apostrophe": ('<robot name="a">it\'s ', LONGEST + 5, len('<robot name="a">')),
    "a long comment": (f"<robot><!--{'c' * HALF}-->", HALF + 50, len("<robot><!---->") + HALF),
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


def test_deep_nesting_ends_the_reading() -> None:
    assert codes(found("<a>" * 100_000 + "</a>" * 100_000)) == {"RD001": 1}


def test_many_attributes_of_one_element() -> None:
    attributes = " ".join(f"b{k}=''" for k in range(MANY // 4))
    assert codes(found(f"<link name='a'><visual {attributes}/></link>")) == {"RD005": MANY // 4}


def test_an_expansion_bomb_is_never_expanded() -> None:
    entities = "".join(f'<!ENTITY e{k + 1} "{f"&e{k};" * 10}">' for k in range(30))
    data = f'<!DOCTYPE r [<!ENTITY e0 "ha">{entities}]><robot name="&e30;"/>'.encode()
    assert [finding.code for finding in check_one(data)] == ["RD002"]
