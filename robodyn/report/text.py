"""Reports as text for a terminal."""

from __future__ import annotations

from collections.abc import Iterable

from robodyn.report.document import Block, Facts, Findings, Heading, Paragraph, Section, Table
from robodyn.report.table import PLAIN, Page, printable


def text(sections: Iterable[Section], page: Page = PLAIN) -> str:
    """Return sections with an empty line between; those without a word are left out."""
    parts = ("".join(_block(block, page) for block in section) for section in sections)
    return "\n".join(part for part in parts if part)


def _block(block: Block, page: Page) -> str:
    if isinstance(block, (Heading, Paragraph)):
        return _line(block.text)
    if isinstance(block, Table):
        return "".join([_line(block.caption), page.table((block.head, block.rows)), _line(block.note)])
    if isinstance(block, Facts):
        names = [printable(what) for what, _, _ in block.items]
        wide = max(map(len, names), default=0)
        return "".join(_line(f"{name:{wide}}  {item[1]}") for name, item in zip(names, block.items, strict=True))
    assert isinstance(block, Findings), "the others are for pages"
    return "".join(_line(title) for _, title, _ in block.items)


def _line(words: str) -> str:
    return f"{printable(words)}\n" if words else ""
