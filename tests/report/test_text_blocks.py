"""A text report as blocks."""

from __future__ import annotations

from robodyn.report.document import Facts, Findings, Paragraph, Table
from robodyn.report.text_blocks import blocks_of

ROWS = (("name", "value"), [("a  b", "1"), ("warning: c", "2")])


def write(page):
    return (
        f"robot: 3 links\n\nLinks by mass\n{page.table(ROWS)}after the table\n\nmass    3 kg\ncentre  (0, 0) m\n\n"
        f"{page.table(ROWS)}\nwarning: odd\nnote: even\n"
    )


def test_every_line_becomes_a_block():
    assert blocks_of(write, "Values") == [
        Paragraph("robot: 3 links"),
        Table("Links by mass", *ROWS),
        Paragraph("after the table"),
        Facts((("mass", "3 kg", ""), ("centre", "(0, 0) m", ""))),
        Table("Values: name", *ROWS),
        Findings((("doubtful", "warning: odd", ()), ("neutral", "note: even", ()))),
    ]
