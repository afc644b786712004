"""A report as GitHub-flavoured Markdown, for pull requests: words and tables, no pictures."""

from __future__ import annotations

import re
from collections.abc import Sequence
from textwrap import indent

from robodyn.report import document as doc
from robodyn.report.table import is_numeric, printable

_SPECIAL = re.compile(r"([\\`*_{}\[\]<>#|~&@])")
_SIGNS = {"good": "✅", "doubtful": "⚠️", "bad": "❌", "neutral": "ℹ️"}  # noqa: RUF001


def markdown(document: doc.Document) -> str:
    """Return the report as Markdown. Whatever could be Markdown or HTML in its words is escaped."""
    parts = [f"# {escaped(document.title)}", escaped(document.subtitle)]
    parts += [part for part in map(_block, _worth(document.blocks)) if part]
    if document.command:
        text = document.command
        ticks = "`" * (1 + max([2, *map(len, re.findall("`+", text))]))
        parts += ["---", f"{ticks}console\n$ {printable(text)}\n{ticks}", escaped(", ".join(document.versions))]
    return "\n\n".join(part for part in parts if part) + "\n"


def escaped(text: str) -> str:
    """Return words that Markdown shows as they are, on one line; a name after @ notifies nobody."""
    return _SPECIAL.sub(r"\\\1", printable(" ".join(text.split()))).replace(r"\@", "@\u200b")


def _worth(blocks: Sequence[doc.Block]) -> list[doc.Block]:
    """Return the blocks without pictures and downloads, and without headings that then stand alone."""
    kept = [block for block in blocks if not isinstance(block, (doc.Figure, doc.Gallery, doc.Downloads))]
    after = [*kept[1:], doc.Heading("")]
    return [one for one, other in zip(kept, after, strict=True) if not (_head(one) and _head(other))]


def _head(block: doc.Block) -> bool:
    return isinstance(block, doc.Heading)


def _block(block: doc.Block) -> str:
    if isinstance(block, (doc.Heading, doc.Paragraph)):
        return ("## " if isinstance(block, doc.Heading) else "") + escaped(block.text)
    if isinstance(block, doc.Verdict):
        reasons = "".join(f"\n- {escaped(reason)}" for reason in block.reasons)
        return f"**{_SIGNS[block.level]} {escaped(block.headline)}**" + (f"\n{reasons}" if reasons else "")
    if isinstance(block, doc.Facts):
        return "\n".join(f"- {escaped(what)}: **{escaped(figure)}**" for what, figure in block.items)
    if isinstance(block, doc.Findings):
        return "\n".join(_finding(*item) for item in block.items)
    return _table(block) if isinstance(block, doc.Table) else ""


def _finding(level: str, title: str, lines: Sequence[tuple[str, bool]]) -> str:
    shown = [indent(doc.code_lines(text), " " * 6, bool) if code else f"  {escaped(text)}" for text, code in lines]
    rows = "".join(f"\n{each}\n" for each in shown)
    return f"- {_SIGNS[level]} **{escaped(title)}**\n{rows}"


def _table(table: doc.Table) -> str:
    numeric = [is_numeric([row[k] for row in table.rows]) for k in range(len(table.head))]
    rule = ["---:" if right else "---" for right in numeric]
    rows = [[escaped(cell) for cell in row] for row in table.rows]
    lines = [f"| {' | '.join(row)} |" for row in ([escaped(title) or " " for title in table.head], rule, *rows)]
    note = f"\n\n{escaped(table.note)}" if table.note else ""
    return f"**{escaped(table.caption)}**\n\n" + "\n".join(lines) + note
