"""Sections of a report as text and as blocks of a page; results as JSON, numbers to the last bit."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import PurePosixPath
from types import MappingProxyType

import numpy as np
import pytest

from robodyn.report.document import (
    Facts,
    Findings,
    Paragraph,
    Table,
    encode,
    finite,
    on_page,
    paragraphs,
    remarks,
    select,
    text,
    written,
)

ROWS = (("name", "value"), [("a  b", "1"), ("warning: c", "2")])
SECTIONS = [
    [Paragraph("robot: 3 links")],
    [Table("Links by mass", *ROWS), Paragraph("after the table")],
    [Facts((("mass", "3 kg"), ("centre", "(0, 0) m")))],
    [],
    [Table("", *ROWS)],
    paragraphs(["escape \x1b[1m"]),
    [*remarks("warning", ["odd"]), *remarks("note", ["even"]), *remarks("repaired", [])],
]
TABLE = "name        value\na  b            1\nwarning: c      2\n"


def test_sections_stand_apart_and_tables_below_their_captions():
    assert text(SECTIONS) == (
        f"robot: 3 links\n\nLinks by mass\n{TABLE}after the table\n\nmass    3 kg\ncentre  (0, 0) m\n\n"
        f"{TABLE}\nescape \\x1b[1m\n\nwarning: odd\nnote: even\n"
    )


def test_every_table_of_a_page_has_a_caption():
    blocks = on_page(SECTIONS, "Values")
    assert blocks[:3] == [Paragraph("robot: 3 links"), Table("Links by mass", *ROWS), Paragraph("after the table")]
    assert blocks[4] == Table("Values: name", *ROWS)
    assert blocks[-2:] == [
        Findings((("doubtful", "warning: odd", ()),)),
        Findings((("neutral", "note: even", ()),)),
    ]


class Kind(Enum):
    FIRST = "first kind"


@dataclass(frozen=True)
class Inner:
    b: float
    a: tuple[int, ...] = (1, 2)


@dataclass(frozen=True, eq=False)
class Outer:
    name: str
    inner: Inner
    R: np.ndarray = field(default_factory=lambda: np.array([[0.1, 1 / 3], [np.pi, -0.0]]))
    kind: Kind = Kind.FIRST
    path: PurePosixPath = field(default_factory=lambda: PurePosixPath("a/b"))
    table: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({"z": np.float64(0.1), "a": None}))


def test_fields_are_keys_in_their_order() -> None:
    found = json.loads(written(encode(Outer("x", Inner(2.0)))))
    assert list(found) == ["name", "inner", "R", "kind", "path", "table"]
    assert found["inner"] == {"b": 2.0, "a": [1, 2]}
    assert list(found["inner"]) == ["b", "a"]
    assert (found["kind"], found["path"], found["table"]) == ("first kind", "a/b", {"z": 0.1, "a": None})
    assert found["R"] == [[0.1, 1 / 3], [np.pi, -0.0]]


def test_keys_that_are_named() -> None:
    found = select(Outer("x", Inner(2.0)), "second:inner.b more name", more=(np.arange(2), True))
    assert list(found.items()) == [("second", 2.0), ("more", [[0, 1], True]), ("name", "x")]
    with pytest.raises(AssertionError, match="without a place: other"):
        select(Inner(1.0), "a b", other=1)


def test_numbers_that_are_none() -> None:
    assert [finite(x) for x in (1.5, np.inf, -np.inf, np.nan, None)] == [1.5, None, None, None, None]
    for value in (np.inf, np.nan):
        with pytest.raises(ValueError, match="JSON"):
            written({"x": np.array([value])})
