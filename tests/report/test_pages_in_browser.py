"""Pages in a real browser, without network: what is seen is what was computed, by pointer, keyboard and on paper."""

from __future__ import annotations

import html
import os
import re
import shutil
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.command_line import HEADER, ROBOTS, run, write_arm
from scipy.spatial.transform import Rotation

import robodyn
from robodyn.robot.kinematics import body_poses

LOG = Path(__file__).parents[1] / "data" / "tx40_log"
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
ARGUMENTS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
MOTIONS = {
    "fixed": "torques puma560.urdf puma560_sweep.csv",
    "motors": "torques puma560.urdf puma560_sweep.csv --scene puma560_sizing.toml",
    "heat": "torques puma560.urdf puma560_sweep.csv --scene puma560_sizing.toml --scene puma560_heat.toml",
    "prismatic": "torques scara.urdf scara_pick_and_place.csv",
    "mimic": "torques gripper.urdf gripper_pick.csv --scene gripper.toml",
    "floating": "torques satellite.urdf satellite_slew.csv --scene satellite.toml",
    "loop": "torques four_bar.urdf four_bar_lift.csv --scene four_bar_lift.toml",
    "feet": "torques quadruped.urdf quadruped_trot.csv --scene quadruped_trot.toml",
}
CALLS = MOTIONS | {
    "runs": "torques puma.urdf puma_reach.csv puma_waves.csv",
    "view": "view puma560.urdf",
    "mesh": "inertia meshes/bracket.stl --unit mm --density 2700",
    "links": "inertia meshed_arm.urdf --at elbow=0.5",
    "compare": "inertia meshed_arm.urdf --compare",
    "check": "check puma560.urdf",
    "simulate": "simulate two_link_planar.urdf --scene two_link_planar_swing_down.toml --duration 0.2",
    "linearize": "linearize two_link_planar.urdf --equilibrium",
    "retime": "retime puma560.urdf puma560_waypoints.csv --scene puma560_sizing.toml",
    "envelope": "envelope puma560.urdf",
    "excite": "excite pendulum.urdf",
    "identify": "identify tx40.urdf log.parquet --cutoff 40",
    "accuracy": "accuracy meshes/bracket.stl --target 1e-6",
    "diff": "diff puma560.urdf puma.urdf",
    "size": "size puma560.urdf puma560_sweep.csv --catalog motors.csv --gears gears.csv",
}
"""Pages by name: the command, in which names of files are those of `robots/` and of the log of a TX40."""
CLOCK = '[data-part="clock"]'


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium, for no longer than these tests: its driver runs a loop of asyncio in which others could start none."""
    if CHROMIUM is None:
        assert not os.environ.get("ROBODYN_NEEDS_BROWSER"), "no Chromium is installed"
        pytest.skip("there is no Chromium")
    api = pytest.importorskip("playwright.sync_api")
    with api.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def written(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Pages by name, each made once."""
    folder = tmp_path_factory.mktemp("pages")

    @cache
    def page(name: str) -> Path:
        file = folder / f"{name}.html"
        places = {
            each.name: each
            for room in (ROBOTS, ROBOTS / "meshes", ROBOTS / "catalogue", LOG)
            for each in room.iterdir()
        }
        words = [str(places.get(word.rpartition("/")[2], word)) for word in CALLS[name].split()]
        out = ("--out", str(file.with_suffix(".csv"))) if name in MOTIONS else ()
        outcome = run(*words, "--report", str(file), *out)
        assert outcome.status in (0, 1), outcome.err
        return file

    return page


@pytest.fixture
def opened(browser: Any) -> Iterator[Callable[..., Any]]:
    """Open a file, of which no request may leave, and on whose console no error may stand."""
    contexts, said, asked, files = [], [], [], []

    def page(file: Path, width: int = 1300, **options: Any) -> Any:
        contexts.append(browser.new_context(viewport={"width": width, "height": 1000}, offline=True, **options))
        found = contexts[-1].new_page()
        found.on("pageerror", lambda error: said.append(str(error)))
        found.on("console", lambda message: message.type == "error" and said.append(message.text))
        found.on("request", lambda request: asked.append(request.url))
        files.append(file.as_uri())
        found.goto(files[-1])
        for _ in range(600 * options.get("java_script_enabled", True)):
            if found.evaluate("!document.getElementById('data') || !!window.robodyn"):
                break
            found.wait_for_timeout(50)
        return found

    yield page
    for context in contexts:
        context.close()
    assert said == []
    assert [url for url in asked if not url.startswith("data:")] == files


def analysed(name: str) -> tuple[Any, Any, dict[str, Any]]:
    """The robot of a motion, its result, and the columns of what the page has."""
    _, robot, motion, *scene = CALLS[name].split()
    acting = robodyn.load_scene(ROBOTS / scene[1]) if scene else robodyn.Scene()
    model = robodyn.load(ROBOTS / robot, moving_base=acting.moving_base)
    result = robodyn.torques(model, ROBOTS / motion, acting, history=True)
    assert result.history is not None
    return model, result, dict(zip(result.history.motion.names, result.history.motion.frames()[1].T, strict=True))


def chart(page: Any, caption: str) -> Any:
    """The chart under a caption, in view and drawn."""
    found = page.locator("figure.chart").filter(has=page.locator("figcaption", has_text=caption)).first
    found.scroll_into_view_if_needed()
    found.locator("canvas").wait_for()
    return found


COLOURS = """(canvas) => {
    const { width, height } = canvas, copy = new OffscreenCanvas(width, height).getContext("2d");
    copy.drawImage(canvas, 0, 0);
    return new Set(new Uint32Array(copy.getImageData(0, 0, width, height).data.buffer)).size;
}"""


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name != "check")) for name in CALLS])
def test_every_page_on_screens_and_paper(written, opened, name: str) -> None:
    """Wide and light, narrow and dark: no canvas is blank, nothing is wider than the screen, an audit of accessibility
    finds nothing serious. On paper a summary of at most two pages, then the tables."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    for width, scheme in ((1300, "light"), (360, "dark")):
        page = opened(written(name), width, color_scheme=scheme)
        page.evaluate("window.robodyn && (robodyn.all(), robodyn.stages.forEach((each) => each.pick(0, 0)))")
        page.wait_for_timeout(200)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        for canvas in page.locator("canvas").all():
            assert canvas.evaluate(COLOURS) > 8
        if scheme == "dark" or name in ("fixed", "identify", "check", "diff"):
            found = [each for each in axe.run(page).response["violations"] if each["impact"] in ("serious", "critical")]
            assert [(each["id"], [node["html"] for node in each["nodes"]][:3]) for each in found] == []
    page.evaluate("document.querySelectorAll('h2.tables, h2.tables ~ *').forEach((each) => each.remove())")
    sheets = len(re.findall(rb"/Type /Page\b", page.pdf(format="A4")))
    assert sheets <= 2 or name in ("check", "compare")


@pytest.mark.slow
@pytest.mark.parametrize("name", MOTIONS)
def test_links_are_where_kinematics_say(written, opened, name: str) -> None:
    """At rows of the whole motion, and between the axes of the ground and of the base where that moves."""
    model, _, columns = analysed(name)
    page = opened(written(name))
    for row in np.linspace(0, len(columns["time"]) - 1, 7).astype(int).tolist():
        found = page.evaluate(f"(robodyn.setTime({float(columns['time'][row])!r}), robodyn.stages[0].poses()[0])")
        q = np.array([columns[f"q_{key}"][row] for key in model.coordinates])
        places = {key: np.reshape(value, (4, 4)).T for key, value in found.items()}
        base = np.eye(4)
        if model.floating:
            k = model.bodies[0].joint.coordinate
            base[:3, :3], base[:3, 3] = Rotation.from_quat(q[k + 3 : k + 7]).as_matrix(), q[k : k + 3]
        for body, (R, p) in zip(model.bodies, body_poses(model, q), strict=True):
            expected = np.vstack((np.column_stack((np.array(R, float), np.array(p, float))), (0.0, 0.0, 0.0, 1.0)))
            np.testing.assert_allclose(places[body.name], base @ expected, rtol=0.0, atol=1e-6)


@pytest.mark.slow
def test_a_base_turns_the_shorter_way_where_quaternions_change_sign(opened, tmp_path: Path) -> None:
    """Rows 20 degrees apart about z, every second with the opposite sign: midway the base is turned by the mean."""
    model = robodyn.load(ROBOTS / "rigid_body.urdf", moving_base=True)
    angles = np.radians(20.0 * np.arange(6))
    q = np.zeros((6, 7))
    q[:, 3:] = Rotation.from_rotvec(angles[:, None] * (0.0, 0.0, 1.0)).as_quat() * (-1.0) ** np.arange(6)[:, None]
    still = np.zeros((6, 6))
    page = tmp_path / "turn.html"
    page.write_text(robodyn.view(model, robodyn.motion(model, np.arange(6.0), q, still, still)).html)
    found = opened(page).evaluate("(robodyn.setTime(2.5), Object.values(robodyn.stages[0].poses()[0])[0])")
    expected = Rotation.from_rotvec((0.0, 0.0, np.radians(50.0))).as_matrix()
    np.testing.assert_allclose(np.reshape(found, (4, 4)).T[:3, :3], expected, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["motors", "floating", "loop", "feet"])
def test_arrows_are_as_long_as_the_numbers(written, opened, name: str) -> None:
    """Every joint's peak at its time, and the forces of the base then."""
    model, result, columns = analysed(name)
    page, child = opened(written(name)), {body.joint.name: body.name for body in model.bodies}
    scales = page.evaluate("robodyn.stages[0].scales()")

    def drawn(kind: str, body: str, moment: bool) -> float:
        arrows = page.evaluate("robodyn.stages[0].arrows()")
        wanted = [each for each in arrows if (each["kind"], each["body"], each["moment"]) == (kind, body, moment)]
        return sum(each["length"] for each in wanted) / scales["N m" if moment else "N"]

    for joint in result.joints:
        page.evaluate(f"robodyn.setTime({float(joint.peak_time)!r})")
        found = drawn("torque", child[joint.name], joint.unit == "N m")
        assert found == pytest.approx(abs(joint.peak), rel=1e-6, abs=1e-9)
        row = int(np.argmin(np.abs(columns["time"] - joint.peak_time)))
        for moment, parts in ((False, "f"), (True, "m")):
            size = np.linalg.norm([columns[f"base_{parts}{axis}"][row] for axis in "xyz"])
            assert drawn("base", model.bodies[0].name, moment) == pytest.approx(size, rel=1e-6, abs=1e-6)


@pytest.mark.slow
def test_one_cursor_for_charts_robot_and_tables(written, opened) -> None:
    page = opened(written("fixed"))
    data = np.genfromtxt(written("fixed").with_suffix(".csv"), delimiter=",", names=True)
    clock, shoulder = page.locator(CLOCK), chart(page, "shoulder: torque")

    def says(row: int) -> None:
        at, value = data["time"][row - 1], data["tau_shoulder"][row - 1]
        told = shoulder.locator(".readout", has_text=f"{at:.6g} s, row {row}")
        told.wait_for()
        assert float(re.search(r"torque (\S+) N m", told.inner_text())[1]) == pytest.approx(value, rel=1e-5)
        assert clock.inner_text() == f"{at:.6g} s, row {row}"

    page.evaluate(f"robodyn.setTime({float(data['time'][73])!r})")
    says(74)
    shoulder.locator(".plot").press("ArrowRight")
    says(75)
    shoulder.locator(".u-over").hover(position={"x": 150, "y": 50})
    page.wait_for_timeout(100)
    row = int(re.search(r"row (\d+)", clock.inner_text())[1])
    assert row != 75
    says(row)
    button = page.locator("table:has(caption:has-text('Loads')) tr:has-text('shoulder') button.go").first
    button.click()
    assert clock.inner_text().startswith(f"{float(button.inner_text()):.6g} s, row ")
    chart(page, "shoulder: torque")
    says(1 + int(np.argmax(np.abs(data["tau_shoulder"]))))


def page_of_arm(folder: Path) -> Path:
    words = ("torques", str(folder / "arm.urdf"), str(folder / "arm.csv"), "--report", str(folder / "arm.html"))
    assert run(*words).status in (0, 1)
    return folder / "arm.html"


@pytest.mark.slow
def test_a_peak_of_one_row_in_a_hundred_thousand_stays(opened, tmp_path: Path) -> None:
    write_arm(tmp_path)
    rows = [f"{i / 100},0.1,0.2,0,0,0,{900 * (i == 73_210)}\n" for i in range(100_000)]
    (tmp_path / "arm.csv").write_text(HEADER + "".join(rows))
    result = robodyn.torques(robodyn.load(tmp_path / "arm.urdf"), tmp_path / "arm.csv")
    page = opened(page_of_arm(tmp_path))
    elbow = chart(page, "elbow: torque")
    most = """(figure) => {
        const { u } = robodyn.charts.get(figure), { min, max } = u.scales.x;
        const seen = u.data[1].filter((_, k) => u.data[0][k] >= min && u.data[0][k] <= max);
        return [Math.max(...seen), u.scales.y.max, max - min];
    }"""
    whole = elbow.evaluate(most)
    assert whole[0] == pytest.approx(result.joints[1].peak, rel=1e-6)
    left, top, wide, _ = elbow.locator(".u-over").bounding_box().values()
    page.mouse.move(left + 0.682 * wide, top + 40)
    page.mouse.down()
    page.mouse.move(left + 0.782 * wide, top + 45, steps=4)
    page.mouse.up()
    page.wait_for_timeout(100)
    zoomed = elbow.evaluate(most)
    assert zoomed[0] == whole[0] <= zoomed[1]
    assert zoomed[2] == pytest.approx(0.1 * whole[2], rel=0.1)
    assert chart(page, "shoulder: torque").evaluate(most)[2] == pytest.approx(zoomed[2]), "charts zoom together"
    page.evaluate("robodyn.setTime(732.1)")
    first, last = re.search(r"row (\d+) to (\d+)", elbow.locator(".readout").inner_text()).groups()
    assert int(first) <= 73_211 <= int(last)
    assert page.locator(CLOCK).inner_text() == "732.1 s, row 73211"
    page.evaluate("robodyn.setTime(1e9)")
    assert page.locator(CLOCK).inner_text() == "999.99 s, row 100000"


@pytest.mark.slow
def test_names_with_markup_stay_text(opened, tmp_path: Path) -> None:
    name = "<script>alert(1)</script><img src=x onerror=alert(2)>"
    write_arm(tmp_path)
    urdf, motion = tmp_path / "arm.urdf", tmp_path / "arm.csv"
    urdf.write_text(re.sub('"(arm|upper|shoulder)"', f'"{html.escape(name)}"', urdf.read_text()))
    motion.write_text(motion.read_text().replace("shoulder", name))
    page = opened(page_of_arm(tmp_path))
    page.evaluate("(robodyn.all(), robodyn.stages[0].pick(0, 1))")
    assert page.locator("main script, main img").count() == 0
    for place in ("h1", ".panel h3", 'select[data-part="links"] option >> nth=2', "figcaption >> nth=1"):
        assert name in page.locator(place).first.inner_text(), place


@pytest.mark.slow
def test_the_keyboard_reaches_and_moves_everything(written, opened) -> None:
    page = opened(written("motors"))
    page.evaluate("robodyn.all()")
    reached = """(() => { const at = document.activeElement, known = "reached" in at.dataset;
        at.dataset.reached = ""; return !known && at !== document.body; })()"""
    while page.keyboard.press("Tab") or page.evaluate(reached):
        pass
    missed = """() => [...document.querySelectorAll("a[href], button, select, input, summary, [tabindex]")]
        .filter((each) => each.checkVisibility() && each.dataset.reached === undefined).map((each) => each.outerHTML)"""
    assert page.evaluate(missed) == []
    canvas, clock = page.locator("canvas[data-part]"), page.locator(CLOCK)
    for key in ("ArrowLeft", "ArrowUp", "Shift+ArrowLeft", "+"):
        before = canvas.evaluate("(canvas) => canvas.toDataURL()")
        canvas.press(key)
        page.wait_for_timeout(150)
        assert canvas.evaluate("(canvas) => canvas.toDataURL()") != before, key
    part = {name: page.locator(f'[data-part="{name}"]') for name in ("time", "play", "links", "home", "panel")}
    part["time"].press("End")
    assert clock.inner_text().startswith("4 s")
    part["play"].press("Space")
    page.wait_for_timeout(500)
    assert not clock.inner_text().startswith("4 s"), "it plays again from the start"
    part["links"].select_option(label="upper_arm")
    assert "by joint shoulder" in part["panel"].inner_text()
    part["links"].select_option(label="none")
    part["home"].click()
    box, heights = canvas.bounding_box(), iter((0.3, 0.4, 0.5, 0.6, 0.7))
    while not part["panel"].is_visible():
        canvas.click(position={"x": box["width"] / 2, "y": next(heights) * box["height"]})
    assert part["panel"].locator("h3").inner_text() in [body.name for body in analysed("fixed")[0].bodies]


@pytest.mark.slow
def test_without_scripts_words_and_tables_say_everything(written, opened) -> None:
    page = opened(written("fixed"), java_script_enabled=False)
    shown = page.locator("main").inner_text()
    for words in ("No limit is exceeded", "torque of shoulder over time: peak 53.24 N m at 1.94 s", "Loads: joint"):
        assert words in shown
    assert not any(each.is_visible() for each in page.locator("canvas, .plot, button, select, input").all())
