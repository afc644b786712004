"""The document keeps every element and attribute with its place, in any encoding and layout."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.document import MAX_DEPTH, Document, Element, Span, read, read_document

GAP = st.text(" \t\r\n", min_size=1, max_size=3)
SPACE = st.text(" \t\r\n", max_size=2)
NAMES = st.sampled_from(["name", "xyz", "größe", "a.b-c", "x" * 30])
PIECES = st.sampled_from(
    ["1 0", ">", "/>", "=", "é", "°", "ÿ", "\t", "\r\n", "\r", "\n", "&amp;", "&#10;", "'", "a='b'", ""]
)
FILLING = st.sampled_from(["<!-- <x y='1'> -->", "<![CDATA[<x y='1'>é]]>", "<?pi a='1'?>", "é\r\n", "\r", " ", ""])
WIDE = st.sampled_from(["世界", "𝛕", "ÿ"])


@dataclass(frozen=True)
class Written:
    """One attribute as the generator wrote it: character offsets into the text."""

    name: str
    raw: str
    start: int
    value_start: int
    end: int


@st.composite
def texts(draw: st.DrawFn, wide: bool = True) -> tuple[str, list[list[Written]]]:
    """A URDF text, and for each element in the order of the file its attributes."""
    pieces = PIECES | WIDE if wide else PIECES
    text = draw(st.sampled_from(["", "\n", "\r\n\n"])) + draw(st.sampled_from(["", "<!-- é > -->\r"]))
    elements: list[list[Written]] = []
    for tag in ["robot", *draw(st.lists(st.sampled_from(["link", "jöint", "x"]), max_size=3))]:
        text += f"<{tag}"
        elements.append([])
        for name in draw(st.lists(NAMES, max_size=4, unique=True)):
            quote = draw(st.sampled_from("'\""))
            raw = "".join(draw(st.lists(pieces, max_size=5))).replace(quote, "")
            text += draw(GAP)
            start = len(text)
            text += name + draw(SPACE) + "=" + draw(SPACE) + quote
            value_start = len(text)
            text += raw + quote
            elements[-1].append(Written(name, raw, start, value_start, len(text)))
        text += draw(SPACE) + (">" if tag == "robot" else "/>") + draw(FILLING)
    return text + "</robot>", elements


def walk(element: Element) -> Iterator[Element]:
    yield element
    for child in element.children:
        yield from walk(child)


def read_value(raw: str) -> str:
    """What XML 1.0, 2.11 and 3.3.3, makes of an attribute's text."""
    blanks = re.sub("\r\n|[\t\r\n]", " ", raw)
    return blanks.replace("&#10;", "\n").replace("&amp;", "&")


def place(text: str, offset: int) -> tuple[int, int]:
    lines = re.split("\r\n|\r|\n", text[:offset])
    return len(lines), len(lines[-1]) + 1


def check_spans(document: Document, text: str, elements: list[list[Written]]) -> None:
    """`text` is the document's text after a byte order mark."""
    found = list(walk(document.root))
    assert len(found) == len(elements)
    for element, attributes in zip(found, elements, strict=True):
        assert list(element.attributes) == [written.name for written in attributes]
        tag = document.data[element.span.start : element.span.end].decode(document.encoding)
        assert tag.startswith(f"<{element.tag}")
        assert tag.endswith(">")
        offset = len(document.data[: element.span.start].decode(document.encoding).removeprefix("\ufeff"))
        assert (element.span.line, element.span.column) == place(text, offset)
        assert (element.line, element.start) == (element.span.line, element.span.start)
        for written in attributes:
            attribute = element.attributes[written.name]
            assert attribute.value == element.get(written.name) == read_value(written.raw)
            check_span(document, attribute.value_span, text, written.value_start, written.end - 1)
            check_span(document, attribute.span, text, written.start, written.end)


def check_span(document: Document, span: Span, text: str, start: int, end: int) -> None:
    assert document.data[span.start : span.end].decode(document.encoding) == text[start:end]
    assert (span.line, span.column) == place(text, start)


UNICODE = st.tuples(texts(), st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"]))
DECLARED = st.tuples(texts(wide=False), st.sampled_from(["iso-8859-1", "windows-1252", "cp1252", "ISO-8859-15"]))


@given(UNICODE | DECLARED)
def test_every_attribute_lies_where_its_span_says(example: tuple[tuple[str, list[list[Written]]], str]) -> None:
    (text, elements), encoding = example
    head = "" if encoding.startswith("utf") else f"<?xml version='1.0' encoding='{encoding}'?>"
    whole = head + (text.lstrip() if encoding.endswith("e") else text)
    shift = len(whole) - len(text)
    moved = [
        [Written(w.name, w.raw, w.start + shift, w.value_start + shift, w.end + shift) for w in e] for e in elements
    ]
    document = read_document(whole.encode(encoding))
    assert not head or document.data == whole.encode(encoding)
    check_spans(document, whole, moved)


def test_text_children_and_unknown_parts_are_kept() -> None:
    root = read_document(
        b"<robot name='r'><weird a='1'>x<y/><![CDATA[<z>]]> &lt;<!-- no --></weird><y n='2'/><y/></robot>"
    ).root
    weird = root.find("weird")
    assert weird is not None
    assert weird.text == "x<z> <"
    assert [child.tag for child in weird.children] == ["y"]
    assert [child.get("n") for child in root.findall("y")] == ["2", None]
    assert root.find("nothing") is None


def test_nesting_up_to_the_limit() -> None:
    def nested(depth: int) -> bytes:
        return b"<robot>" + b"\n<a>" * (depth - 1) + b"</a>" * (depth - 1) + b"</robot>"

    assert len(list(walk(read_document(nested(MAX_DEPTH)).root))) == MAX_DEPTH
    for depth in (MAX_DEPTH + 1, 10_000):
        with pytest.raises(DescriptionError, match=f"more than {MAX_DEPTH} deep") as caught:
            read_document(nested(depth))
        assert caught.value.line == MAX_DEPTH + 1


@pytest.mark.parametrize(
    ("text", "codes"),
    [
        ("<!DOCTYPE robot><robot><p:x/><link name='${a}'/></robot>", ["RD002", "RD003", "RD004"]),
        ("<robot>\n<link name='${a}'>\n</robot>", ["RD004", "RD001"]),
        ("<robot xacro:a='1'>\n&b;</robot>", ["RD004", "RD002"]),
        ("<sdf/>", ["RD001"]),
        ("", ["RD001"]),
    ],
)
def test_one_parse_finds_every_fault_and_strict_reading_raises_the_first(text: str, codes: list[str]) -> None:
    faults = read(text.encode()).faults
    assert [fault.code for fault in faults] == codes
    with pytest.raises(DescriptionError) as caught:
        read_document(text.encode())
    assert str(caught.value) == str(faults[0].error("<stdin>"))
