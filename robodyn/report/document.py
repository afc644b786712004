"""The document of a report, the door of this room: a result is said once, as blocks, and shown in every form.

1. `torques.py`, `check.py` and so on, one for each subject: `*_sections` are its words and tables.
2. `*_page` puts verdict, charts (`charts.py`), robots (`stage.py`), data beside them; `*_json` selects fields.
3. `limits.py` judges: the one verdict on a motion; `table.py` and `sizes.py` write numbers, noise as 0.
4. `text` here, and `renderers/`, show any document: HTML, Markdown; findings as SARIF, JUnit, GitHub's lines; LaTeX.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from enum import Enum
from functools import cache
from pathlib import PurePath
from typing import Any, Literal

from robodyn.report.table import PLAIN, Page, printable

Level = Literal["good", "doubtful", "bad", "neutral"]
_KINDS = {"json": "application/json", "csv": "text/csv"}
LARGEST = 400_000
"""Bytes of a file that a page carries at most."""


@dataclass(frozen=True)
class Heading:
    text: str


@dataclass(frozen=True)
class Paragraph:
    text: str


@dataclass(frozen=True)
class Verdict:
    """The answer: whether all is well, a headline, and what it rests on in plain words."""

    level: Level
    headline: str
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True)
class Facts:
    """Figures that matter most: each what it is, and the figure."""

    items: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Table:
    """Rows below a header; the first cell of a row names it."""

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


@dataclass(frozen=True)
class Formula:
    """Equations as lines of text and as rows of LaTeX's align; a page hides them below `folded`, a title, if given."""

    lines: tuple[str, ...]
    latex: tuple[str, ...]
    folded: str = ""


@dataclass(frozen=True)
class Chart:
    """A plot: its caption, what it shows in words, and what the page's script draws (`charts.py`)."""

    caption: str
    alt: str
    look: Mapping[str, Any]


@dataclass(frozen=True)
class Stage:
    """Robots in 3-D: what is seen, how it is used, and what the page's viewer draws (`stage.py`)."""

    caption: str
    alt: str
    words: str
    look: Mapping[str, Any]


@dataclass(frozen=True)
class Bars:
    """Rows of a name, bars (label, from, to, colour of the page) in percent, and words in place of the labels; a bar
    without a label lies over the one before."""

    caption: str
    rows: Sequence[tuple[str, Sequence[tuple[str, float, float, str]], str]]
    note: str = ""


@dataclass(frozen=True)
class Gallery:
    """Charts beside each other, as many as there is room for."""

    figures: tuple[Chart, ...]


@dataclass(frozen=True)
class Findings:
    """Remarks, each a level, a title, and lines; lines of a source are among them as (text, True).

    Those with a caption are of one level, and hidden by its box in `Levels`; links: what each leads to in `Folded`.
    """

    items: tuple[tuple[Level, str, tuple[tuple[str, bool], ...]], ...]
    caption: str = ""
    links: tuple[str, ...] = ()


@dataclass(frozen=True)
class Levels:
    """Boxes that show or hide findings: levels, and how many there are of each in words."""

    items: tuple[tuple[Level, str], ...]


@dataclass(frozen=True)
class Folded:
    """Explanations that open: what findings link to, a title, and words."""

    items: tuple[tuple[str, str, str], ...]


@dataclass(frozen=True)
class Download:
    name: str
    kind: str
    text: str


@dataclass(frozen=True)
class Downloads:
    """Files that the page carries, and what is said of those it does not."""

    files: tuple[Download, ...]
    notes: tuple[str, ...] = ()


Words = Heading | Paragraph | Facts | Table | Findings | Formula
"""What text has."""
Block = Words | Verdict | Bars | Chart | Gallery | Stage | Levels | Folded | Downloads
Section = Sequence[Block]
"""Blocks that belong together: text has an empty line between sections."""


@dataclass(frozen=True)
class Document:
    """A report: what it is about, what was done, and by which command and versions."""

    title: str
    subtitle: str
    blocks: tuple[Block, ...]
    command: str = ""
    versions: tuple[str, ...] = ()


def gallery(figures: Iterable[Chart]) -> list[Block]:
    """Return charts beside each other; nothing without any."""
    shown = tuple(figures)
    return [Gallery(shown)] if shown else []


def titled(title: str, blocks: Iterable[Block]) -> list[Block]:
    """Return blocks under a heading; nothing without any."""
    shown = list(blocks)
    return [Heading(title), *shown] if shown else []


def page(
    title: str,
    subtitle: str,
    first: Iterable[Block],
    sections: Iterable[Section],
    caption: str,
    files: Iterable[tuple[str, str]],
    instead: str,
) -> Document:
    """Return a report: what leads it, what the text says, then files (name, text), or how to get large ones instead."""
    numbers = [
        replace(block, caption=f"{caption}: {block.head[0]}")
        if isinstance(block, Table) and not block.caption
        else block
        for section in sections
        for block in section
    ]
    return Document(title, subtitle, (*first, *titled("In numbers", numbers), *data_blocks(files, instead)))


def remarks(kind: str, lines: Iterable[str]) -> Section:
    """Return a list of remarks that begin with their kind: warning, note, remark or repaired; nothing without any."""
    level: Level = "doubtful" if kind == "warning" else "neutral"
    items = tuple((level, f"{kind}: {line}", ()) for line in lines)
    return [Findings(items)] if items else []


def paragraphs(lines: Iterable[str]) -> list[Block]:
    return [Paragraph(line) for line in lines]


def code_lines(text: str) -> str:
    """Return lines of a source as they are shown: with control characters escaped."""
    return "\n".join(map(printable, text.split("\n")))


def data_blocks(files: Iterable[tuple[str, str]], instead: str) -> list[Block]:
    """Return the files (name, text) that are small enough for a page, under a heading, and how to get the others."""
    small, notes = [], []
    for name, text in files:
        size = len(text.encode())
        if size <= LARGEST:
            small.append(Download(name, _KINDS[name.rpartition(".")[2]], text))
        else:
            notes.append(f"{name} has {size / 1e6:.1f} MB, too much for this page: {instead}.")
    return [Heading("Data"), Downloads(tuple(small), tuple(notes))] if small or notes else []


def csv_text(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a table as CSV."""
    import csv
    import io

    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return stream.getvalue()


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
        wide = max((len(printable(what)) for what, _ in block.items), default=0)
        return "".join(_line(f"{printable(what):{wide}}  {figure}") for what, figure in block.items)
    if isinstance(block, Formula):
        return "".join(map(_line, block.lines))
    assert isinstance(block, Findings), "the others are for pages"
    return "".join(_line(title) for _, title, _ in block.items)


def _line(words: str) -> str:
    return f"{printable(words)}\n" if words else ""


def written(document: Mapping[str, Any]) -> str:
    """Return a document as text; ValueError where a number is not finite: `finite` says null instead."""
    import json

    return json.dumps(encode(document), indent=2, allow_nan=False) + "\n"


def encode(value: Any) -> Any:
    """Return a value as JSON has it: dataclasses, names first, and mappings as objects, the rest as lists."""
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if hasattr(value, "tolist"):
        return value.tolist()
    if is_dataclass(value):
        ordered = sorted(fields(value), key=lambda each: each.name != "name")
        keys = {each.metadata.get("json", each.name): each.name for each in ordered}
        keys |= {name: name for name in getattr(value, "JSON_ALSO", ())}
        return {key: encode(getattr(value, name)) for key, name in keys.items()}
    if hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {key: encode(each) for key, each in value.items()}
    if isinstance(value, (tuple, list)):
        return [encode(each) for each in value]
    return value.value if isinstance(value, Enum) else str(value) if isinstance(value, PurePath) else value


def select(source: Any, keys: str, **given: Any) -> dict[str, Any]:
    """Return an object with these keys in this order, whose values are the source's attributes of these names.

    Args:
        keys: `key:path` takes another attribute, such as `origin:pose.p`; `key?` is null where a number is not finite;
            `key[...]` has these keys of the value, or of each in a list. What has no value is null.
        given: values in place of attributes.
    """
    found = _selected(source, _parsed(keys), given)
    assert not given, f"without a place: {', '.join(given)}"
    return found


@cache
def _parsed(keys: str) -> list[tuple[str, Any]]:
    open_lists: list[list[tuple[str, Any]]] = [[]]
    for word in re.findall(r"[^\s\[\]]+|[\[\]]", keys):
        if word == "[":
            inner: list[tuple[str, Any]] = []
            open_lists[-1][-1] = (open_lists[-1][-1][0], inner)
            open_lists.append(inner)
        elif word == "]":
            open_lists.pop()
        else:
            open_lists[-1].append((word, None))
    return open_lists[0]


def _selected(source: Any, keys: list[tuple[str, Any]], given: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for word, inner in keys:
        name, _, path = word.rstrip("?").partition(":")
        value = given.pop(name) if name in given else source
        if value is source:
            for part in (path or name).split("."):
                value = None if value is None else getattr(value, part)
        value = value.tolist() if hasattr(value, "tolist") else value
        several = type(value) in (list, tuple)
        if word.endswith("?"):
            value = [finite(each) for each in value] if several else finite(value)
        if inner is None or value is None:
            found[name] = encode(value)
        else:
            found[name] = [_selected(each, inner, {}) for each in value] if several else _selected(value, inner, {})
    return found


def finite(value: float | None) -> float | None:
    """Return the value, or None where JSON has no number for it."""
    return value if value is not None and abs(value) < float("inf") else None
