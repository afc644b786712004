"""Pages can be read on paper and on a phone, say what their columns mean, and show nothing where there is nothing."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from helpers.html_pages import Page, checked
from helpers.oracles import ROBOTS, robot

import robodyn
import robodyn.report
from robodyn.report.document import Document, Table
from robodyn.report.renderers import html as html_page
from robodyn.report.renderers.html import MEANINGS, html
from robodyn.report.simulation import simulation_page
from robodyn.report.torques_page import torques_page
from robodyn.scene.read import load_scene
from robodyn.simulation.run import simulate

ASSETS = Path(html_page.__file__).parent / "assets"
STYLE = (ASSETS / "page.css").read_text(encoding="utf-8")
PRINT = STYLE.partition("@media print {")[2]


def arm() -> Page:
    model, scene = robot("puma560"), load_scene(ROBOTS / "puma560_sizing.toml")
    found = robodyn.torques(model, ROBOTS / "puma560_sweep.csv", scene)
    return checked(html(torques_page(found, model, scene, pictures=False)))


def test_titles_of_columns_explain_themselves() -> None:
    page = arm()
    titles = {each.text.replace("\u00a0", " "): str(each.attributes["title"]) for each in page.all("abbr")}
    for title in (
        "RMS",
        "cubic mean",
        "hold share",
        "mu [N m]",
        "tilting m",
        "inertia ratio",
        "duty",
        "of effort limit",
    ):
        assert titles[title] == MEANINGS[title]
    heads = {each.text.replace("\u00a0", " ") for each in page.all("th") if each.attributes["scope"] == "col"}
    assert heads & MEANINGS.keys() == titles.keys()
    legends = [each for each in page.all("details") if each.attributes.get("class") == "legend"]
    assert any(MEANINGS["hold share"] in each.text for each in legends), "where there is no pointer to hover"


def test_the_slack_of_links_is_explained() -> None:
    table = Table("Links by mass", ("link", "mass [kg]", "slack"), (("a", "1", "0.5"),))
    (abbreviation,) = checked(html(Document("t", "s", (table,)))).all("abbr")
    assert "negative where no body can be so" in str(abbreviation.attributes["title"])


def test_every_meaning_is_of_a_column() -> None:
    source = "".join(path.read_text(encoding="utf-8") for path in Path(robodyn.report.__file__).parent.glob("*.py"))
    made = {"quartiles [ms]": "quartiles [{unit}]", "quartiles [ns]": "quartiles [{unit}]"}
    assert [title for title in MEANINGS if f'"{made.get(title, title)}"' not in source] == []


def test_heads_of_tables_repeat_on_paper() -> None:
    assert re.search(r"thead \{[^}]*display: table-header-group;[^}]*break-inside: avoid;", PRINT)
    assert "th button { display: contents; }" in PRINT, "Chromium repeats no head with a button in it"


def test_the_first_column_stays() -> None:
    rule = re.search(r'th\[scope="row"\], thead > tr > :first-child \{([^}]*)\}', STYLE)
    assert rule
    assert "position: sticky; left: 0; background: var(--paper)" in rule[1]
    assert re.search(r'th\[scope="row"\], thead > tr > :first-child, caption span \{ position: static; \}', PRINT)


def test_pictures_take_the_width_that_there_is() -> None:
    """Nothing has a width of its own, which a phone would cut."""
    model, scene = robot("two_link_planar"), robodyn.Scene()
    found = robodyn.torques(model, ROBOTS / "two_link_planar_swing.csv", scene, history=True)
    page = checked(html(torques_page(found, model, scene)))
    for svg in page.all("svg"):
        assert "viewBox" in svg.attributes or "viewbox" in svg.attributes
        assert not {"width", "height"} & svg.attributes.keys()
    figures = re.findall(r"figure[^{]*\{([^}]*)\}", STYLE)
    assert not any("min-width: 6" in rule for rule in figures)
    (drawn,) = (each for each in page.all("svg") if each.attributes.get("viewbox") == "0 0 520 448")
    assert "body" in drawn.text
    assert any(each.text.startswith("reaction, ") for each in page.all("td"))


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


def test_a_motion_that_drives_nothing_has_no_plots_of_zeros() -> None:
    found = simulate(robot("double_pendulum"), load_scene(ROBOTS / "double_pendulum_chaos.toml"), duration=0.05)
    text = checked(html(simulation_page(found))).source
    assert "speed [rad/s]" in text
    assert "drive's torque [N m]" not in text.replace("&#39;", "'")
    assert ">work done<" not in text


def test_joints_that_neither_move_nor_carry_have_no_plot() -> None:
    model, scene = robot("puma560"), robodyn.Scene(gravity=(0.0, 0.0, 0.0))
    q, qd, qdd = (np.zeros((30, 6)) for _ in range(3))
    time = np.linspace(0.0, 1.0, 30)
    q[:, 5], qd[:, 5], qdd[:, 5] = time**2, 2 * time, 2.0
    found = robodyn.torques(model, robodyn.motion(model, time, q, qd, qdd), scene, history=True)
    captions = [each.text for each in checked(html(torques_page(found, model, scene))).all("figcaption")]
    assert "flange_roll" in captions
    still = [joint.name for joint in found.joints if not abs(joint.peak) > 1e-12]
    assert still
    assert not set(still) & set(captions)
