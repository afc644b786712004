"""Sections of a report as text, and as blocks of a page."""

from __future__ import annotations

from robodyn.report.document import Facts, Findings, Paragraph, Table, on_page, paragraphs, remarks, text

ROWS = (("name", "value"), [("a  b", "1"), ("warning: c", "2")])
SECTIONS = [
    [Paragraph("robot: 3 links")],
    [Table("Links by mass", *ROWS), Paragraph("after the table")],
    [Facts((("mass", "3 kg", ""), ("centre", "(0, 0) m", "")))],
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
