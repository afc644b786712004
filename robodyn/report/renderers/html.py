"""A report as one HTML file that needs no network: light and dark, for screens, phones and paper."""

from __future__ import annotations

import base64
import hashlib
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robodyn.report.document import Document, Download, Heading, code_lines, heat_level
from robodyn.report.renderers.glossary import explained
from robodyn.report.table import is_numeric, printable
from robodyn.support.extras import need

if TYPE_CHECKING:
    from markupsafe import Markup

_ASSETS = Path(__file__).parent / "assets"


def html(document: Document) -> str:
    """Return the page.

    Every word is escaped, and the page's policy lets no script run but its own and no address be loaded.
    """
    need("HTML reports", "jinja2")
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    strict: dict[str, Any] = {"autoescape": True, "undefined": StrictUndefined}
    room = Environment(loader=FileSystemLoader(_ASSETS), trim_blocks=True, lstrip_blocks=True, **strict)
    room.filters |= {"words": printable, "name": _name, "unit": _unit, "code": code_lines, "data": _data}
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
        explained=explained,
        heat=heat_level,
        svg=lambda figure: Markup(figure.svg),
    )
    return str(page)


def _name(text: str) -> Markup:
    """Return words in which a long name may go on in the next line after an underscore or a slash."""
    from markupsafe import Markup, escape

    return Markup(re.sub(r"([_/])(?=\w{3})", r"\1<wbr>", str(escape(printable(text)))))


def _unit(title: str) -> str:
    """Return a title whose unit in brackets stays on one line."""
    return re.sub(r"\[[^\]]*\]", lambda unit: unit[0].replace(" ", "\u00a0"), printable(title))


def _asset(name: str) -> str:
    return (_ASSETS / name).read_text(encoding="utf-8").strip()


def _numeric(table: Any) -> list[bool]:
    """Return for each column whether it is one of numbers."""
    return [is_numeric([row[k] for row in table.rows]) for k in range(len(table.head))]


def _data(file: Download) -> str:
    """Return the address that holds a file."""
    return f"data:{file.kind};charset=utf-8;base64,{base64.b64encode(file.text.encode()).decode()}"
