"""Pages: whole, escaped, readable in light and dark, on paper and on a phone; none dropped of many joints."""

from __future__ import annotations

import base64
import json
import re
from itertools import product

import numpy as np
import pytest
from helpers.html_pages import Page, checked, contrast
from helpers.oracles import ROBOTS, robot

import robodyn
import robodyn.report
from robodyn.report.charts import time_chart
from robodyn.report.document import (
    LARGEST,
    Bars,
    Chart,
    Document,
    Download,
    Downloads,
    Facts,
    Findings,
    Folded,
    Gallery,
    Heading,
    Levels,
    Paragraph,
    Stage,
    Table,
    Verdict,
    data_blocks,
)
from robodyn.report.renderers.pages import _ASSETS as ASSETS
from robodyn.report.renderers.pages import escaped, html, markdown
from robodyn.report.torques_page import torques_page
from robodyn.scene.read import load_scene

MEANINGS = json.loads((ASSETS / "meanings.json").read_text(encoding="utf-8"))
STYLE = (ASSETS / "page.css").read_text(encoding="utf-8")
PRINT = STYLE.partition("@media print {")[2]
HOSTILE = '<script>alert(1)</script>"\' onload="x" & | `a` $\\frac{ *b* [c](http://d) --> ]]> @all \x1b[31m'


def figure(words: str) -> Chart:
    both = np.array((0.0, 1.0))
    return time_chart(words, words, both, {words: both}, "N", levels=[(1.0, words)])


def document(words: str) -> Document:
    blocks = (
        Verdict("bad", words, (words,)),
        Facts(((words, words),)),
        Heading(words),
        Paragraph(words),
        Table(words, (words, "n"), ((words, "1.5"), ("b", "-2")), words),
        Heading(words),
        Gallery((figure(words), figure(words))),
        Stage(words, words, words, {"robots": [{"name": words}]}),
        Bars(words, ((words, ((words, 0.0, 50.0, "c1"),), words),), words),
        Findings((("doubtful", words, ((words, False), (words, True))),)),
        Levels((("bad", words), ("neutral", words))),
        Findings((("bad", words, ()),), words, ("RD1",)),
        Folded((("RD1", words, words),)),
        Downloads((Download("a.csv", "text/csv", words),)),
    )
    return Document(words, words, blocks, words, (words,))


def test_words_of_files_stay_words() -> None:
    page = checked(html(document(HOSTILE)))
    assert page.all("h1")[0].text == HOSTILE.replace("\x1b", "\\x1b")
    data, *scripts = page.all("script")
    assert (len(scripts), data.attributes["type"]) == (4, "application/json")
    assert "<" not in data.text
    looks = json.loads(data.text)["looks"]
    said = HOSTILE.replace("\x1b", "\\x1b")
    assert [look["series"][0]["label"] for look in looks[:2]] == [said] * 2
    assert looks[2] == {"robots": [{"name": said}]}


def test_a_page_has_every_part() -> None:
    page = checked(html(document("words")))
    assert [each.text for each in page.all("figcaption")] == ["words"] * 3
    assert [(each.attributes["scope"], each.attributes.get("class")) for each in page.all("th")] == [
        ("col", None),
        ("col", "n"),
        ("row", None),
        ("row", None),
        ("row", None),
    ]
    (link,) = (each for each in page.all("a") if "download" in each.attributes)
    assert base64.b64decode(str(link.attributes["href"]).partition("base64,")[2]) == b"words"


def test_markdown_is_escaped() -> None:
    text = markdown(document(HOSTILE))
    prose = re.sub(r"\n```+console\n.*?\n```+\n", "", text, flags=re.DOTALL)
    prose = "\n".join(line for line in prose.splitlines() if not line.startswith("      "))
    assert "<script" not in prose.replace("\\<", "")
    assert not re.search(r"(?<!\\)[\[\]`<>]", prose)
    assert "@all" not in prose
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {3}


def test_what_is_too_large_is_not_carried_and_said() -> None:
    heading, found = data_blocks([("big.json", "x" * (LARGEST + 1)), ("a.csv", "words")], "ask for it")
    note = "big.json has 0.4 MB, too much for this page: ask for it."
    assert (heading, found) == (Heading("Data"), Downloads((Download("a.csv", "text/csv", "words"),), (note,)))


def test_markdown_leaves_out_pictures_and_lonely_headings() -> None:
    blocks = (Heading("Plots"), Gallery((figure("x"),)), Heading("Table"), Table("T", ("a", "b"), [("x", "1")]))
    text = markdown(Document("t", "s", blocks))
    assert text == "# t\n\ns\n\n## Table\n\n**T**\n\n| a | b |\n| --- | ---: |\n| x | 1 |\n"
    assert escaped("a\nb") == "a b"


def _schemes() -> list[dict[str, str]]:
    roots = re.findall(r":root\S* \{(.*?)\}", STYLE, re.DOTALL)
    assert len(roots) == 2
    return [dict(re.findall(r"--(\w+): (#\w{6})", block)) for block in roots]


@pytest.mark.parametrize("scheme", _schemes(), ids=["light", "dark"])
def test_contrast(scheme: dict[str, str]) -> None:
    words = [name for name in scheme if name not in ("paper", "raised", "grid", "rule", "body")]
    for front, back in product(words, ("paper", "raised")):
        assert contrast(scheme[front], scheme[back]) >= 4.5, (front, back)
    assert contrast(scheme["rule"], scheme["paper"]) >= 3.0


def arm() -> Page:
    model, scene = robot("puma560"), load_scene(ROBOTS / "puma560_sizing.toml")
    found = robodyn.torques(model, ROBOTS / "puma560_sweep.csv", scene)
    return checked(html(torques_page(found, model, scene, pictures=False)))


def test_titles_of_columns_explain_themselves() -> None:
    page = arm()
    titles = {each.text.replace("\u00a0", " "): str(each.attributes["title"]) for each in page.all("abbr")}
    assert titles.keys() >= {"RMS", "cubic mean", "hold share", "mu [N m]", "tilting m", "inertia ratio", "duty"}
    assert all(meaning == MEANINGS[title] for title, meaning in titles.items())
    heads = {each.text.replace("\u00a0", " ") for each in page.all("th") if each.attributes["scope"] == "col"}
    assert heads & MEANINGS.keys() == titles.keys()
    legends = [each for each in page.all("details") if each.attributes.get("class") == "legend"]
    assert any(MEANINGS["hold share"] in each.text for each in legends), "where there is no pointer to hover"
    assert any(MEANINGS["hold share"] not in each.text for each in legends), "a table explains its own columns"


def test_paper_repeats_heads() -> None:
    """Chromium repeats no head with a button in it."""
    assert re.search(r"thead \{[^}]*display: table-header-group;[^}]*break-inside: avoid;", PRINT)
    assert "th button { display: contents; }" in PRINT
    assert re.search(r'th\[scope="row"\], thead > tr > :first-child \{[^}]*position: sticky; left: 0;', STYLE)


def test_sorting_is_by_size() -> None:
    """The expression that the script reads numbers with, whose sign does not count."""
    script = (ASSETS / "page.js").read_text(encoding="utf-8")
    pattern = re.search(r"= /(.*)/i\.exec\(text\)", script)
    assert pattern
    read = re.compile(pattern[1], re.IGNORECASE)

    def size(text: str) -> float:
        found = read.match(text)
        assert found, text
        return float(found[2]) * (0.99 if found[1] else 1.0)

    cells = ["-31.44 N m", "7.811 N m", "-2.765 N m", "+- 1.5", "<1% of 160", "1% of 2", "-1.2e-05", "0"]
    order = ["-31.44 N m", "7.811 N m", "-2.765 N m", "+- 1.5", "1% of 2", "<1% of 160", "-1.2e-05", "0"]
    assert sorted(cells, key=size, reverse=True) == order


def test_joints_that_neither_move_nor_carry_have_no_plot() -> None:
    model, scene = robot("puma560"), robodyn.Scene(gravity=(0.0, 0.0, 0.0))
    q, qd, qdd = (np.zeros((30, 6)) for _ in range(3))
    time = np.linspace(0.0, 1.0, 30)
    q[:, 5], qd[:, 5], qdd[:, 5] = time**2, 2 * time, 2.0
    found = robodyn.torques(model, robodyn.motion(model, time, q, qd, qdd), scene, history=True)
    captions = [each.text for each in checked(html(torques_page(found, model, scene))).all("figcaption")]
    assert "flange_roll: torque over speed" in captions
    still = [joint.name for joint in found.joints if not abs(joint.peak) > 1e-12]
    assert still
    assert not [caption for caption in captions if caption.partition(":")[0] in still]
