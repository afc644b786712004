"""Tables of text: numbers of four digits, decimal points in line, widths."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robodyn.report.table import NEGLIGIBLE, number, printable, table

FINITE = st.floats(allow_nan=False, allow_infinity=False)


@pytest.mark.parametrize(
    ("x", "text"),
    [
        (0.0, "0"),
        (-0.0, "0"),
        (1.0, "1.000"),
        (-0.5, "-0.5000"),
        (12.3456, "12.35"),
        (999.94, "999.9"),
        (999.96, "1000"),
        (3421.4, "3421"),
        (-1234567.8, "-1234568"),
        (9999999.0, "9999999"),
        (1e7, "1.000e+07"),
        (0.001, "0.001000"),
        (0.00123456, "0.001235"),
        (0.00099999, "1.000e-03"),
        (-4.5678e-12, "-4.568e-12"),
        (1e300, "1.000e+300"),
        (5e-324, "4.941e-324"),
    ],
)
def test_number(x: float, text: str) -> None:
    assert number(x) == text


@given(FINITE)
def test_number_has_four_digits_of_its_value(x: float) -> None:
    if x == 0.0:
        assert number(x) == "0"
    elif abs(x) >= 1e-300 and abs(x) < 1e308:
        assert abs(float(number(x)) - x) <= 5.0001e-4 * abs(x)


@given(FINITE, FINITE)
def test_what_vanishes_beside_the_scale_is_zero(x: float, scale: float) -> None:
    assert (number(x, scale) == "0") == (abs(x) <= NEGLIGIBLE * abs(scale))


def test_decimal_points_are_in_line_and_units_behind() -> None:
    rows = [
        ("waist", "-28.64 N m", "+- 0.5"),
        ("z", "117.1 N", ""),
        ("tip", "0.003 N m", "+- 12.25"),
        ("o", "5 N", "-"),
    ]
    assert table(("joint", "peak", "noise"), rows).splitlines() == [
        "joint         peak      noise",
        "waist  -28.64  N m   +- 0.5",
        "z      117.1   N",
        "tip      0.003 N m  +- 12.25",
        "o        5     N            -",
    ]  # without blanks at the ends


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=8))
def test_every_decimal_point_stands_in_one_column(values: list[float]) -> None:
    lines = table(("", "value"), [("", f"{x:.3f} N m") for x in values]).splitlines()[1:]
    assert len({line.index(".") for line in lines}) == 1
    assert [float(line.split()[0]) for line in lines] == [float(f"{x:.3f}") for x in values]


def test_numbers_stand_right_below_a_wide_title_and_words_left() -> None:
    text = table(("name", "a wide title", "why"), [("x", "1.5", "because"), ("long name", "22.25", "3 of 4")])
    assert text.splitlines() == [
        "name       a wide title  why",
        "x                  1.5   because",
        "long name         22.25  3 of 4",
    ]


def test_columns_that_do_not_fit_follow_below() -> None:
    rows = [(f"joint {i}", "1.25 N m", "2.5", "3.75", "99% of 5") for i in range(3)]
    head = ("joint", "peak", "RMS", "mean", "of limit")
    narrow = table(head, rows, width=24)
    assert max(map(len, narrow.splitlines())) <= 24
    pages = narrow.split("\n\n")
    assert len(pages) > 1
    assert all(
        [line.split("  ")[0] for line in page.splitlines()] == ["joint", *(r[0] for r in rows)] for page in pages
    )
    assert sorted(re.findall(r"peak|RMS|mean|of limit", narrow)) == sorted(head[1:])
    assert table(head, rows, width=200) == table(head, rows)


def test_wide_and_combining_characters() -> None:
    lines = table(("name", "x"), [("\u8155", "1.0"), ("e\u0301", "1.0"), ("ab", "1.0")]).splitlines()
    assert [line.index("1.0") for line in lines[1:]] == [5, 7, 6]


@given(st.text())
def test_printable_keeps_the_terminal_safe(text: str) -> None:
    safe = printable(text)
    assert safe.isprintable()
    if text.isprintable():
        assert safe == text


def test_bold_is_the_header_alone() -> None:
    text = table(("joint", "x"), [("a", "1")], bold=True)
    assert text.splitlines() == ["\x1b[1mjoint  x\x1b[0m", "a      1"]
