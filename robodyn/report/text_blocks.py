"""A report as text, taken apart into the blocks of a page: what both say is written once."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from robodyn.report.document import Block, Facts, Findings, Level, Paragraph, Table
from robodyn.report.table import Content, Page

_MARK = "\0"
_PAIR = re.compile(r"(\S.*?) {2,}(\S.*)")
_REMARKS: dict[str, Level] = {
    "warning: ": "doubtful",
    "note: ": "neutral",
    "remark: ": "neutral",
    "repaired: ": "neutral",
}


class _Catching(Page):
    """A page that keeps tables, and puts a mark where each of them stands."""

    caught: list[Content]

    def table(self, content: Content) -> str:
        self.caught.append(content)
        return f"{_MARK}{len(self.caught) - 1}\n"


def blocks_of(write: Callable[[Page], str], caption: str = "") -> list[Block]:
    """The blocks of what a function writes on a page of text.

    A table takes the line above it as its caption, or this one and the title of its first column; words with several
    spaces between are a fact; warnings and the like are findings; other lines are paragraphs.
    """
    page = _Catching()
    page.caught = []
    blocks: list[Block] = []
    above: list[str] = []
    for line in [*write(page).splitlines(), ""]:
        if line.startswith(_MARK):
            head, rows = page.caught[int(line[1:])]
            title = above.pop() if above else f"{caption}: {head[0]}"
            blocks += _lines(above)
            blocks.append(Table(title, head, rows))
            above = []
        elif line:
            above.append(line)
        else:
            blocks += _lines(above)
            above = []
    return blocks


def _lines(lines: list[str]) -> Iterator[Block]:
    facts = [match.groups() for match in map(_PAIR.fullmatch, lines) if match]
    if facts:
        yield Facts(tuple((what, figure, "") for what, figure in facts))
    remarks = [(level, line) for line in lines for start, level in _REMARKS.items() if line.startswith(start)]
    for line in lines:
        if not _PAIR.fullmatch(line) and not line.startswith(tuple(_REMARKS)):
            yield Paragraph(line)
    if remarks:
        yield Findings(tuple((level, line, ()) for level, line in remarks))
