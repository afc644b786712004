"""A report as one HTML file that needs no network: light and dark, for screens, phones and paper."""

from __future__ import annotations

import base64
import hashlib
from pathlib import Path
from typing import Any

from robodyn.report.document import Document, Download, Heading, code_lines
from robodyn.report.table import is_numeric, printable

_ASSETS = Path(__file__).parent / "assets"


def html(document: Document) -> str:
    """The document.

    Every word is escaped, and the page's policy lets no script run but its own and no address be loaded.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    strict: dict[str, Any] = {"autoescape": True, "undefined": StrictUndefined}
    room = Environment(loader=FileSystemLoader(_ASSETS), trim_blocks=True, lstrip_blocks=True, **strict)
    room.filters |= {"words": printable, "code": code_lines, "data": _data}
    room.tests["block"] = lambda block, name: type(block).__name__ == name
    script = _asset("page.js")
    digest = base64.b64encode(hashlib.sha256(f"\n{script}\n".encode()).digest()).decode()
    page = room.get_template("page.html.j2").render(
        document=document,
        style=Markup(_asset("page.css")),
        script=Markup(script),
        digest=digest,
        sections=[block.text for block in document.blocks if isinstance(block, Heading)],
        numeric=_numeric,
        svg=lambda figure: Markup(figure.svg),
    )
    return str(page)


def _asset(name: str) -> str:
    return (_ASSETS / name).read_text(encoding="utf-8").strip()


def _numeric(table: Any) -> list[bool]:
    """For each column whether it is one of numbers."""
    return [is_numeric([row[k] for row in table.rows]) for k in range(len(table.head))]


def _data(file: Download) -> str:
    """The address that holds a file."""
    return f"data:{file.kind};charset=utf-8;base64,{base64.b64encode(file.text.encode()).decode()}"
