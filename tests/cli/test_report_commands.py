"""`--report` of `inertia`, `check`, `simulate` and `accuracy`: pages that keep to the rules and say the figures."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run, write_arm
from helpers.html_pages import checked

from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung, Spread
from robodyn.report.accuracy import accuracy_page
from robodyn.report.renderers.html import html

MESHES = ROBOTS / "meshes"
ARM = str(ROBOTS / "meshed_arm.urdf")
TX40 = tuple(str(Path(__file__).parents[1] / "data" / "tx40_log" / name) for name in ("tx40.urdf", "log.parquet"))
SWING = (str(ROBOTS / "two_link_planar.urdf"), "--scene", str(ROBOTS / "two_link_planar_swing_down.toml"))
CALLS: dict[str, tuple[tuple[str, ...], str, int]] = {
    "mesh": (("inertia", str(MESHES / "bracket.stl"), "--unit", "mm", "--density", "2700"), "0.03848 kg", 1),
    "meshes": (("inertia", str(MESHES / "bracket.stl"), str(MESHES / "cross.stl")), "repaired, 2 overlapping", 2),
    "combined": (
        ("inertia", str(MESHES / "bracket.stl"), str(MESHES / "cross.stl"), "--unit", "mm", "--combine"),
        "Parts by mass",
        1,
    ),
    "robot": (("inertia", ARM, "--at", "elbow=0.5"), "3.734 kg", 1),
    "link": (("inertia", ARM, "--link", "hand"), "as declared", 1),
    "shapes": (("inertia", ARM, "--link", "hand", "--geometry", "visual"), "<visual> shapes", 1),
    "compare": (("inertia", ARM, "--compare"), "1 of 8 links differ from their shapes by more than 10 %", 0),
    "check": (("check", str(ROBOTS / "puma560.urdf")), "No errors, 2 warnings", 0),
    "simulate": (("simulate", *SWING, "--duration", "0.2"), "The motion ran for its 0.2 s", 6),
    "linearize": (("linearize", SWING[0], "--equilibrium"), "2 modes are not damped within rounding", 2),
    "excite": (("excite", str(ROBOTS / "pendulum.urdf")), "shows 6 base parameters", 1),
    "identify": (("identify", *TX40, "--cutoff", "40"), "held-out torques within", 0),
    "accuracy": (("accuracy", str(MESHES / "bracket.stl"), "--target", "1e-6"), "The target of 1e-06 is met", 1),
}


NAMES = [pytest.param(name, marks=[pytest.mark.slow] * (name in ("accuracy", "identify"))) for name in CALLS]


@pytest.mark.parametrize("name", NAMES)
def test_page(tmp_path: Path, name: str) -> None:
    call, words, figures = CALLS[name]
    file = tmp_path / "r.html"
    outcome = run(*call, "--report", str(file))
    assert outcome.status == 0, outcome.err
    assert f"written: {file}" in outcome.out + outcome.err
    page = checked(file.read_text(encoding="utf-8"))
    assert words in " ".join(page.all("main")[0].text.split())
    assert len(page.all("figure")) == figures


@pytest.mark.parametrize("name", [each for each in NAMES if each.values[0] not in ("accuracy", "simulate", "meshes")])
def test_markdown_and_data(tmp_path: Path, name: str) -> None:
    """Neither needs pictures; the page's data are those of `--format json`."""
    call, words, _ = CALLS[name]
    markdown, html = tmp_path / "r.md", tmp_path / "r.html"
    report = json.loads(run(*call, "--format", "json", "--report", str(markdown)).out)
    assert words in markdown.read_text(encoding="utf-8").replace("\\", "")
    run(*call, "--report", str(html))
    links = [each for each in checked(html.read_text(encoding="utf-8")).all("a") if "download" in each.attributes]
    data = str(links[0].attributes["href"]).partition("base64,")[2]
    assert json.loads(base64.b64decode(data)) == report


def test_accuracy_names_the_cheapest() -> None:
    times = [Spread(t, 0.9 * t, 1.1 * t, 5) for t in (1e-3, 2e-3, 5e-3)]
    rungs = tuple(
        Rung(n, (e,), t) for n, e, t in zip(("hull, a", "hull, b", "exact"), (0.1, 1e-3, 0.0), times, strict=True)
    )
    accuracy = Accuracy("part.stl", (Ladder("volume", ("volume",), "rationals", "mesh", rungs),), ())
    page = checked(html(accuracy_page(accuracy, 1e-2)))
    text = " ".join(page.all("main")[0].text.split())
    assert text.startswith("The target of 0.01 is met volume: hull, b has an error of 1.0e-03.")
    assert "volume: from hull, a, with an error of 1.0e-01, to exact, with 0 in 5 times the time." in str(page.source)
    text = " ".join(checked(html(accuracy_page(accuracy, 1e-9, pictures=False))).all("main")[0].text.split())
    assert text.startswith("The target of 1e-09 is met volume: exact")


def test_errors_lead_and_the_status_stays(tmp_path: Path) -> None:
    write_arm(tmp_path)
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(urdf.read_text().replace('<mass value="2"/>', '<mass value="-2"/>'))
    outcome = run("check", str(urdf), "--format", "sarif", "--report", str(tmp_path / "r.html"))
    assert outcome.status == 1
    assert json.loads(outcome.out)["version"] == "2.1.0"
    text = " ".join(checked((tmp_path / "r.html").read_text(encoding="utf-8")).all("main")[0].text.split())
    assert text.startswith("1 error: not fit for use as it is")
    assert '<mass value="-2"/>' in text


def test_a_mesh_from_standard_input_has_no_picture(tmp_path: Path) -> None:
    file = tmp_path / "r.html"
    data = (MESHES / "bracket.stl").read_bytes()
    assert run("inertia", "-", "--type", "stl", "--report", str(file), stdin=data).status == 0
    assert not checked(file.read_text(encoding="utf-8")).all("figure")
