"""Whatever the bytes, checking ends, raises nothing, and finds places that exist."""

from __future__ import annotations

import pytest
from helpers.planted_defects import DEFECTS, HEALTHY
from hypothesis import given
from hypothesis import strategies as st

from robodyn.checks.check import check_one

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
