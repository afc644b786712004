"""Documents as HTML and as Markdown: whole, escaped, readable in light and dark."""

from __future__ import annotations

import base64
import re
from itertools import product
from pathlib import Path

import pytest
from helpers.html_pages import Page, checked

from robodyn.report.document import (
    HEAT,
    LARGEST,
    Document,
    Download,
    Downloads,
    Facts,
    Figure,
    Findings,
    Gallery,
    Heading,
    Paragraph,
    Table,
    Verdict,
    csv_text,
    data_blocks,
)
from robodyn.report.pictures.figures import SERIES, of_page, plot
from robodyn.report.pictures.free_body import COLOURS
from robodyn.report.renderers import html as html_page
from robodyn.report.renderers.html import html
from robodyn.report.renderers.markdown import escaped, markdown

HOSTILE = '<script>alert(1)</script>"\' onload="x" & | `a` $\\frac{ *b* [c](http://d) --> ]]> @all \x1b[31m'


def figure(words: str, name: str = "one") -> Figure:
    def draw(canvas):
        axes = canvas.subplots()
        axes.plot([0, 1], [0, 1], label=words, color=SERIES[0])
        axes.set_title(words)
        axes.legend()

    return Figure(words, words, plot(380, 200, draw, name))


def document(words: str) -> Document:
    blocks = (
        Verdict("bad", words, (words,)),
        Facts(((words, words, words),)),
        Heading(words),
        Paragraph(words),
        Table(words, (words, "n"), ((words, "1.5"), ("b", "-2")), words),
        Heading(words),
        Gallery((figure(words), figure(words, "two"))),
        Findings((("doubtful", words, ((words, False), (words, True))),)),
        Downloads((Download("a.csv", "text/csv", words),)),
    )
    return Document(words, words, blocks, words, (words,))


def test_words_of_files_stay_words() -> None:
    page = checked(html(document(HOSTILE)))
    assert page.all("h1")[0].text == HOSTILE.replace("\x1b", "\\x1b")
    assert len(page.all("script")) == 1
    assert sum("alert(1)" in each.text for each in page.all("text")) == 4  # title and legend, twice


def test_a_page_has_every_part() -> None:
    page = checked(html(document("words")))
    assert [each.text for each in page.all("figcaption")] == ["words", "words"]
    assert [(each.attributes["scope"], each.attributes.get("class")) for each in page.all("th")] == [
        ("col", None),
        ("col", "n"),
        ("row", None),
        ("row", None),
    ]
    (link,) = (each for each in page.all("a") if "download" in each.attributes)
    assert base64.b64decode(str(link.attributes["href"]).partition("base64,")[2]) == b"words"


def test_what_is_too_large_is_not_carried_and_said() -> None:
    heading, found = data_blocks([("big.json", "x" * (LARGEST + 1)), ("a.csv", "words")], "ask for it")
    note = "big.json has 0.4 MB, too much for this page: ask for it."
    assert (heading, found) == (Heading("Data"), Downloads((Download("a.csv", "text/csv", "words"),), (note,)))


def test_markdown_is_escaped() -> None:
    text = markdown(document(HOSTILE))
    prose = re.sub(r"\n```+console\n.*?\n```+\n", "", text, flags=re.DOTALL)
    prose = "\n".join(line for line in prose.splitlines() if not line.startswith("      "))
    assert "<script" not in prose.replace("\\<", "")
    assert not re.search(r"(?<!\\)[\[\]`<>]", prose)
    assert "@all" not in prose
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {3}


def test_markdown_leaves_out_pictures_and_lonely_headings() -> None:
    blocks = (Heading("Plots"), Gallery((figure("x"),)), Heading("Table"), Table("T", ("a", "b"), [("x", "1")]))
    text = markdown(Document("t", "s", blocks))
    assert text == "# t\n\ns\n\n## Table\n\n**T**\n\n| a | b |\n| --- | ---: |\n| x | 1 |\n"
    assert escaped("a\nb") == "a b"


def test_csv() -> None:
    assert csv_text(("a", "b"), [('x,"y"', 1.5)]) == 'a,b\n"x,""y""",1.5\n'


def _schemes() -> list[dict[str, str]]:
    style = (Path(html_page.__file__).parent / "assets" / "page.css").read_text()
    found = [
        dict(re.findall(r"--(\w+): (#\w{6})", block)) for block in re.findall(r":root \{(.*?)\}", style, re.DOTALL)
    ]
    assert len(found) == 2
    return found


def _luminance(colour: str) -> float:
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


@pytest.mark.parametrize("scheme", _schemes(), ids=["light", "dark"])
def test_contrast(scheme: dict[str, str]) -> None:
    heat = [name for name in scheme if re.fullmatch(r"h\d", name)]
    assert len(heat) == len(HEAT)
    words = [name for name in scheme if name not in ("paper", "raised", "grid", "rule", *heat)]
    for front, back in product(words, ("paper", "raised")):
        darker, lighter = sorted((_luminance(scheme[front]), _luminance(scheme[back])))
        assert (lighter + 0.05) / (darker + 0.05) >= 4.5, (front, back)
    for back in heat:
        darker, lighter = sorted((_luminance(scheme["ink"]), _luminance(scheme[back])))
        assert (lighter + 0.05) / (darker + 0.05) >= 4.5, back
    for front in ("rule",):
        darker, lighter = sorted((_luminance(scheme[front]), _luminance(scheme["paper"])))
        assert (lighter + 0.05) / (darker + 0.05) >= 3.0, front


def test_the_checker_sees_faults() -> None:
    good = html(document("words"))
    for before, after in (
        ('<html lang="en">', "<html>"),
        ("</main>", ""),
        ("<h1>", '<h1 onclick="x">'),
        ("</header>", '<img src="http://example.org/a.png"></header>'),
        ('"use strict";', '"use strict"; alert(1);'),
        ('<th scope="row">', "<th>"),
        ("var(--c1)", "#123456"),
    ):
        assert before in good
        with pytest.raises(AssertionError):
            checked(good.replace(before, after, 1))
    assert isinstance(Page(good), Page)


def test_every_colour_of_a_free_body_is_the_pages() -> None:
    for colour in COLOURS.values():
        assert re.fullmatch(r"var\(--c\d\)", of_page(colour)), colour
