"""`--report` of `inertia`, `check`, `simulate` and `accuracy`: pages that keep to the rules and say the figures."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run, shown, write_arm
from helpers.html_pages import checked

from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung, Spread
from robodyn.report.accuracy import accuracy_page
from robodyn.report.renderers.pages import html

MESHES = ROBOTS / "meshes"
ARM = str(ROBOTS / "meshed_arm.urdf")
TX40 = tuple(str(Path(__file__).parents[1] / "data" / "tx40_log" / name) for name in ("tx40.urdf", "log.parquet"))
SWING = (str(ROBOTS / "two_link_planar.urdf"), "--scene", str(ROBOTS / "two_link_planar_swing_down.toml"))
CALLS: dict[str, tuple[tuple[str, ...], str, int]] = {
    "mesh": (("inertia", str(MESHES / "bracket.stl"), "--unit", "mm", "--density", "2700"), "0.03848 kg", 1),
    "meshes": (("inertia", str(MESHES / "bracket.stl"), str(MESHES / "cross.stl")), "repaired, 2 overlapping", 1),
    "combined": (
        ("inertia", str(MESHES / "bracket.stl"), str(MESHES / "cross.stl"), "--unit", "mm", "--combine"),
        "Parts by mass",
        1,
    ),
    "robot": (("inertia", ARM, "--at", "elbow=0.5"), "3.734 kg", 1),
    "link": (("inertia", ARM, "--link", "hand"), "as declared", 1),
    "shapes": (("inertia", ARM, "--link", "hand", "--geometry", "visual"), "<visual> shapes", 1),
    "compare": (("inertia", ARM, "--compare"), "1 of 8 links differ from their shapes by more than 10 %", 1),
    "check": (("check", str(ROBOTS / "puma560.urdf")), "No errors, 2 warnings", 1),
    "simulate": (("simulate", *SWING, "--duration", "0.2"), "The motion ran for its 0.2 s", 7),
    "linearize": (("linearize", SWING[0], "--equilibrium"), "2 modes are not damped within rounding", 2),
    "excite": (("excite", str(ROBOTS / "pendulum.urdf")), "shows 6 base parameters", 5),
    "identify": (("identify", *TX40, "--cutoff", "40"), "held-out torques within", 19),
    "accuracy": (("accuracy", str(MESHES / "bracket.stl"), "--target", "1e-6"), "The target of 1e-06 is met", 1),
}


QUICK = ("robot", "check")
NAMES = [pytest.param(name, marks=[pytest.mark.slow] * (name not in QUICK)) for name in CALLS]
PUMA = (str(ROBOTS / "puma560.urdf"), str(ROBOTS / "puma560_sweep.csv"))


@pytest.mark.parametrize("name", NAMES)
def test_page(tmp_path: Path, name: str) -> None:
    """Its data are those of `--format json`."""
    call, words, figures = CALLS[name]
    file = tmp_path / "r.html"
    outcome = run(*call, "--format", "json", "--report", str(file))
    assert outcome.status == 0, outcome.err
    page = checked(file.read_text(encoding="utf-8"))
    assert words in " ".join(page.all("main")[0].text.split())
    assert len(page.all("figure")) == figures
    if name not in ("simulate", "meshes"):
        links = [each for each in page.all("a") if "download" in each.attributes]
        data = str(links[0].attributes["href"]).partition("base64,")[2]
        assert json.loads(base64.b64decode(data)) == json.loads(outcome.out)


@pytest.mark.parametrize("name", [pytest.param("robot", marks=pytest.mark.slow), "check"])
def test_markdown(tmp_path: Path, name: str) -> None:
    call, words, _ = CALLS[name]
    file = tmp_path / "r.md"
    outcome = run(*call, "--report", str(file))
    assert f"written: {file}" in outcome.out + outcome.err
    assert words in file.read_text(encoding="utf-8").replace("\\", "")


def test_accuracy_names_the_cheapest() -> None:
    times = [Spread(t, 0.9 * t, 1.1 * t, 5) for t in (1e-3, 2e-3, 5e-3)]
    rungs = tuple(
        Rung(n, (e,), t) for n, e, t in zip(("hull, a", "hull, b", "exact"), (0.1, 1e-3, 0.0), times, strict=True)
    )
    accuracy = Accuracy("part.stl", (Ladder("volume", ("volume",), "rationals", "mesh", rungs),), ())
    page = checked(html(accuracy_page(accuracy, 1e-2)))
    text = " ".join(page.all("main")[0].text.split())
    assert text.startswith("The target of 0.01 is met volume: cheapest within 0.01: hull, b, with an error of 1.0e-03.")
    assert "volume: from hull, a, with an error of 1.0e-01, to exact, with 0 in 5 times the time." in str(page.source)
    text = " ".join(checked(html(accuracy_page(accuracy, 1e-9, pictures=False))).all("main")[0].text.split())
    assert text.startswith("The target of 1e-09 is met volume: cheapest within 1e-09: exact, with an error of 0.")


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


def page_of(file: Path):
    return checked(file.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def puma(tmp_path_factory: pytest.TempPathFactory):
    file = tmp_path_factory.mktemp("report") / "puma.html"
    assert f"written: {file}" in shown("torques", *PUMA, "--report", str(file))
    return page_of(file)


@pytest.mark.slow
def test_figures(puma) -> None:
    assert puma.all("main")[0].text.split()[:4] == ["No", "limit", "is", "exceeded"]
    captions = [each.text for each in puma.all("figcaption")]
    assert captions[0].startswith("The robot along the motion")
    joints = ["waist", "shoulder", "elbow", "wrist_roll", "wrist_pitch", "flange_roll"]
    assert [each.partition(":")[0] for each in captions[1:19]] == [joint for joint in joints for _ in range(3)]
    assert captions[19:] == [
        "Power of joints",
        "Base forces: ground on robot",
        "Base moments: ground on robot",
        "Energy check: work less losses, and energy stored",
    ]
    labels = [str(each.attributes["aria-label"]) for each in puma.elements if each.attributes.get("role") == "img"]
    assert any("peak 53.24 N m at 1.94 s" in label for label in labels)


def test_limits_in_plain_words(tmp_path: Path) -> None:
    write_arm(tmp_path)
    urdf = (
        (tmp_path / "arm.urdf")
        .read_text()
        .replace('effort="50" velocity="5" lower="-3"', 'effort="7" velocity="0.05" lower="0.01"', 1)
    )
    (tmp_path / "arm.urdf").write_text(urdf)
    file = tmp_path / "r.html"
    shown("torques", str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv"), "--report", str(file))
    text = " ".join(page_of(file).all("main")[0].text.split())
    assert text.startswith(
        "1 of 2 joints exceeds its limits shoulder moves at 0.1000 rad/s, 200 % of its limit of 0.05"
    )
    assert "rad/s; it is beyond the limit for 0.09 s. shoulder needs a torque of 8.833 N m at 0.09 s, 126 % of" in text
    assert "shoulder goes to 0 rad, below its lower limit of 0.01 rad." in text
    assert "as a skeleton" in text


def test_hostile_names(tmp_path: Path) -> None:
    write_arm(tmp_path)
    bad = "&lt;script&gt;alert(1)&lt;/script&gt; $\\frac{ | --&gt;"
    urdf = (tmp_path / "arm.urdf").read_text().replace('name="arm"', f'name="{bad}"').replace('"upper"', f'"{bad}"')
    (tmp_path / "arm.urdf").write_text(urdf.replace('"shoulder"', f'"{bad}"'))
    motion = (tmp_path / "arm.csv").read_text()
    (tmp_path / "arm.csv").write_text(motion.replace("shoulder", "<script>alert(1)</script> $\\frac{ | -->"))
    for suffix in ("html", "md"):
        file = tmp_path / f"r.{suffix}"
        outcome = run("torques", str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv"), "--report", str(file))
        assert outcome.status == 0, outcome.err
    page = page_of(tmp_path / "r.html")
    assert page.all("h1")[0].text.startswith("<script>")
    assert "\\<script\\>alert(1)" in (tmp_path / "r.md").read_text()


@pytest.mark.slow
def test_motors(tmp_path: Path) -> None:
    file = tmp_path / "r.html"
    scene = str(ROBOTS / "puma560_sizing.toml")
    shown("torques", *PUMA, "--scene", scene, "--momentum", "--report", str(file))
    page = page_of(file)
    text = " ".join(page.all("main")[0].text.split())
    assert text.startswith(
        "3 of 6 joints ask more than motors, gears or limits bear wrist_pitch: the motor's torque is"
    )
    captions = [each.text for each in page.all("figcaption")]
    assert [name for name in captions if name.startswith("Motor of")] == [
        f"Motor of {each.partition(':')[0]}" for each in captions[1:19:3]
    ]
    assert "Momentum and energy" in text


@pytest.mark.slow
def test_a_robot_on_its_feet(tmp_path: Path) -> None:
    file = tmp_path / "trot.html"
    call = [str(ROBOTS / name) for name in ("quadruped.urdf", "quadruped_trot.csv")]
    shown("torques", *call, "--scene", str(ROBOTS / "quadruped_trot.toml"), "--report", str(file))
    page = page_of(file)
    labels = [str(each.attributes["aria-label"]) for each in page.elements if each.attributes.get("role") == "img"]
    (forces,) = (label for label in labels if label.startswith("Forces of contacts along their normals"))
    assert "lf 61.05 N, on 63 % of the time" in forces
    assert all(f" {foot} " in forces for foot in ("rf", "lh", "rh"))
    assert "contact forces on rf_foot" in page.all("main")[0].text


def test_motions_are_laid_over_each_other(tmp_path: Path) -> None:
    write_arm(tmp_path)
    slow = tmp_path / "slow.csv"
    head, *rows = (tmp_path / "arm.csv").read_text().splitlines()
    slow.write_text("\n".join([head, *rows[: len(rows) // 2]]) + "\n")
    calls = str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv"), str(slow), "--report", str(tmp_path / "both.html")
    runs = json.loads(shown("torques", *calls, "--format", "json"))["runs"]
    assert [Path(each["trajectory"]).name for each in runs] == ["arm.csv", "slow.csv"]
    assert runs[0]["samples"] == len(rows)
    page = page_of(tmp_path / "both.html")
    text = " ".join(page.all("main")[0].text.split())
    assert text.startswith("2 runs of arm")
    for each in runs:
        for joint in each["joints"]:
            assert f"{joint['peak']:#.4g}" in text
