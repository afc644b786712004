"""A report as one HTML file without network, light and dark, for screens, phones and paper; and as Markdown."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from pathlib import Path
from textwrap import indent
from typing import Any

from robodyn.report import document as doc
from robodyn.report.table import numeric_columns, printable
from robodyn.support.extras import need

_ASSETS = Path(__file__).parent / "assets"
_SPECIAL = re.compile(r"([\\`*_{}\[\]<>#|~&@])")
_SIGNS = {"good": "✅", "doubtful": "⚠️", "bad": "❌", "neutral": "ℹ️"}  # noqa: RUF001


def html(document: doc.Document) -> str:
    """Return the page: every word is escaped, no script runs but its own, and no address is loaded."""
    need("HTML reports", "jinja2")
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup, escape

    def name(text: str) -> Markup:
        """Return words in which a long name may go on in the next line after an underscore or a slash."""
        return Markup(re.sub(r"([_/])(?=\w{3})", r"\1<wbr>", str(escape(printable(text)))))

    def unit(title: str) -> str:
        """Return a title whose unit in brackets stays on one line."""
        return re.sub(r"\[[^\]]*\]", lambda unit: unit[0].replace(" ", "\u00a0"), printable(title))

    def data(file: doc.Download) -> str:
        return f"data:{file.kind};charset=utf-8;base64,{base64.b64encode(file.text.encode()).decode()}"

    strict: dict[str, Any] = {"autoescape": True, "undefined": StrictUndefined}
    room = Environment(loader=FileSystemLoader(_ASSETS), trim_blocks=True, lstrip_blocks=True, **strict)
    room.filters |= {"words": printable, "name": name, "unit": unit, "code": doc.code_lines, "data": data}
    room.tests["block"] = lambda block, name: type(block).__name__ == name
    assets = ("page.css", "page.js", "meanings.json")  # the last of titles of columns
    style, script, words = ((_ASSETS / name).read_text(encoding="utf-8").strip() for name in assets)
    meanings = json.loads(words)
    page = room.get_template("page.html.j2").render(
        document=document,
        style=Markup(style),
        script=Markup(script),
        digest=base64.b64encode(hashlib.sha256(f"\n{script}\n".encode()).digest()).decode(),
        sections=[block.text for block in document.blocks if isinstance(block, doc.Heading)],
        numeric=lambda table: numeric_columns(table.head, table.rows),
        explained=lambda head: {title: meanings[title] for title in head if title in meanings},
        svg=lambda figure: Markup(figure.svg),
    )
    return str(page)


def markdown(document: doc.Document) -> str:
    """Return the report as Markdown. Whatever could be Markdown or HTML in its words is escaped."""
    kept = [block for block in document.blocks if not isinstance(block, (doc.Figure, doc.Gallery, doc.Downloads))]
    parts = [f"# {escaped(document.title)}", escaped(document.subtitle)]
    for block, after in zip(kept, [*kept[1:], doc.Heading("")], strict=True):
        if not (isinstance(block, doc.Heading) and isinstance(after, doc.Heading)):  # a heading without its pictures
            parts.append(_block(block))
    if document.command:
        text = document.command
        ticks = "`" * (1 + max([2, *map(len, re.findall("`+", text))]))
        parts += ["---", f"{ticks}console\n$ {printable(text)}\n{ticks}", escaped(", ".join(document.versions))]
    return "\n\n".join(part for part in parts if part) + "\n"


def escaped(text: str) -> str:
    """Return words that Markdown shows as they are, on one line; a name after @ notifies nobody."""
    return _SPECIAL.sub(r"\\\1", printable(" ".join(text.split()))).replace(r"\@", "@\u200b")


def _block(block: doc.Block) -> str:
    if isinstance(block, (doc.Heading, doc.Paragraph)):
        return ("## " if isinstance(block, doc.Heading) else "") + escaped(block.text)
    if isinstance(block, doc.Verdict):
        reasons = "".join(f"\n- {escaped(reason)}" for reason in block.reasons)
        return f"**{_SIGNS[block.level]} {escaped(block.headline)}**" + (f"\n{reasons}" if reasons else "")
    if isinstance(block, doc.Facts):
        return "\n".join(f"- {escaped(what)}: **{escaped(figure)}**" for what, figure in block.items)
    if isinstance(block, doc.Findings):
        found = []
        for level, title, lines in block.items:
            shown = [
                indent(doc.code_lines(text), " " * 6, bool) if code else f"  {escaped(text)}" for text, code in lines
            ]
            found.append(f"- {_SIGNS[level]} **{escaped(title)}**\n" + "".join(f"\n{each}\n" for each in shown))
        return "\n".join(found)
    if not isinstance(block, doc.Table):
        return ""
    rule = ["---:" if right else "---" for right in numeric_columns(block.head, block.rows)]
    rows = [[escaped(cell) for cell in row] for row in block.rows]
    shown_rows = [f"| {' | '.join(row)} |" for row in ([escaped(title) or " " for title in block.head], rule, *rows)]
    note = f"\n\n{escaped(block.note)}" if block.note else ""
    return f"**{escaped(block.caption)}**\n\n" + "\n".join(shown_rows) + note
