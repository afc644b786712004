"""A report as one HTML file without network, light and dark, for screens, phones and paper; and as Markdown."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np

from robodyn.report import document as doc
from robodyn.report.renderers.mathml import mathml
from robodyn.report.table import numeric_columns, printable
from robodyn.support.extras import need
from robodyn.support.floats import Floats

_ASSETS = Path(__file__).parent / "assets"
_DRAWN = (doc.Chart, doc.Stage, doc.Gallery)
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

    def formula(block: doc.Formula) -> Markup:
        return Markup(mathml(block.latex))

    strict: dict[str, Any] = {"autoescape": True, "undefined": StrictUndefined}
    room = Environment(loader=FileSystemLoader(_ASSETS), trim_blocks=True, lstrip_blocks=True, **strict)
    room.filters |= {
        "words": printable,
        "name": name,
        "unit": unit,
        "code": doc.code_lines,
        "data": data,
        "mathml": formula,
    }
    room.tests["block"] = lambda block, name: type(block).__name__ == name
    shown = [
        part for block in document.blocks for part in (block.figures if isinstance(block, doc.Gallery) else [block])
    ]
    looks = [part.look for part in shown if isinstance(part, (doc.Chart, doc.Stage))]
    names = ("page.css", "meanings.json", "page.js", "viewer.js", "charts.js")  # the second of titles of columns
    style, words, *scripts = ((_ASSETS / name).read_text(encoding="utf-8").strip() for name in names)
    if looks:
        need("HTML reports", "uplot-python")
        script, looks_style = (_uplot(name) for name in ("uPlot.iife.js", "uPlot.min.css"))
        style, scripts = f"{style}\n{looks_style}", [script, *scripts]
    else:
        scripts = scripts[:1]
    meanings = json.loads(words)
    page = room.get_template("page.html.j2").render(
        document=document,
        style=Markup(style),
        scripts=[Markup(script) for script in scripts],
        digests=[base64.b64encode(hashlib.sha256(f"\n{script}\n".encode()).digest()).decode() for script in scripts],
        data=Markup(packed(looks)) if looks else "",
        drawn=max(
            [k for k, block in enumerate(document.blocks) if isinstance(block, _DRAWN)], default=len(document.blocks)
        ),
        sections=[block.text for block in document.blocks if isinstance(block, doc.Heading)],
        numeric=lambda table: numeric_columns(table.head, table.rows),
        explained=lambda head: {title: meanings[title] for title in head if title in meanings},
    )
    return str(page)


def _uplot(name: str) -> str:
    """Return a file that uplot-python brings, without importing it, which would take IPython in."""
    spec = find_spec("uplot")
    assert spec is not None
    assert spec.origin is not None
    return (Path(spec.origin).parent / "static" / name).read_text(encoding="utf-8").strip()


def packed(looks: Any) -> str:
    """Return JSON of charts and views, {"looks", "arrays"}: an array is its number among these, each once, 32 bits of
    its range for a value: low + step k, within 2^-32 of the range; k = -2^31 is nan."""
    numbers: dict[int, int] = {}
    arrays: list[Any] = []
    kept: list[Any] = []  # an array that is gone may leave its id to another

    def plain(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            if id(value) not in numbers:
                numbers[id(value)] = len(arrays)
                kept.append(value)
                arrays.append(_array(np.asarray(value, dtype=float)))
            return numbers[id(value)]
        if isinstance(value, Mapping):
            return {key: plain(each) for key, each in value.items()}
        if isinstance(value, (list, tuple)):
            return [plain(each) for each in value]
        return printable(value) if isinstance(value, str) else value

    text = json.dumps({"looks": plain(looks), "arrays": arrays}, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")  # so that no word of a file ends the element


def _array(values: Floats) -> dict[str, Any]:
    known = np.isfinite(values)
    if len(values) <= 400:
        return {"values": [x if there else None for x, there in zip(values.tolist(), known.tolist(), strict=True)]}
    low, high = (float(values[known].min()), float(values[known].max())) if known.any() else (0.0, 0.0)
    step = (high - low) / (2.0**32 - 3.0)
    if known.all() and not step > 0.0:
        return {"n": len(values), "low": low}
    levels = np.full(len(values), -(2**31), dtype="<i4")
    levels[known] = (np.rint((values[known] - low) / (step or 1.0)) - (2.0**31 - 1.0)).astype("<i4")
    return {"low": low, "step": step, "levels": base64.b64encode(levels.tobytes()).decode()}


def markdown(document: doc.Document) -> str:
    """Return the report as Markdown. Whatever could be Markdown or HTML in its words is escaped."""
    kept = [block for block in document.blocks if not isinstance(block, (*_DRAWN, doc.Downloads))]
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


def _block(block: doc.Block) -> str:  # noqa: PLR0911
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
    if isinstance(block, doc.Bars):
        said = [(name, words or ", ".join(label for label, *_ in bars if label)) for name, bars, words in block.rows]
        return "\n".join(
            [f"**{escaped(block.caption)}**", "", *(f"- {escaped(name)}: {escaped(words)}" for name, words in said)]
        )
    if isinstance(block, doc.Formula):
        return "```\n" + "\n".join(block.lines) + "\n```"
    if not isinstance(block, doc.Table):
        return ""
    rule = ["---:" if right else "---" for right in numeric_columns(block.head, block.rows)]
    rows = [[escaped(cell) for cell in row] for row in block.rows]
    shown_rows = [f"| {' | '.join(row)} |" for row in ([escaped(title) or " " for title in block.head], rule, *rows)]
    note = f"\n\n{escaped(block.note)}" if block.note else ""
    return f"**{escaped(block.caption)}**\n\n" + "\n".join(shown_rows) + note
