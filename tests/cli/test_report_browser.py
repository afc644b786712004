"""Reports in headless Chromium, where there is one: scripts run, nothing is complained of, pictures are not blank."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from command_line import ROBOTS, run

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
CALLS = {
    "torques": ("torques", "puma560.urdf", "puma560_sweep.csv"),
    "simulate": ("simulate", "two_link_planar.urdf", "--scene", "two_link_planar_swing_down.toml", "--duration", "0.5"),
    "inertia": ("inertia", "meshed_arm.urdf"),
    "check": ("check", "puma.urdf"),
    "accuracy": ("accuracy", "meshes/bracket.stl"),
}

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")]


@pytest.fixture(scope="module", params=CALLS)
def report(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    words = [str(ROBOTS / word) if "." in word and (ROBOTS / word).exists() else word for word in CALLS[request.param]]
    file = tmp_path_factory.mktemp("report") / f"{request.param}.html"
    assert run(*words, "--report", str(file)).status == 0
    return file


def browsed(*options: str) -> subprocess.CompletedProcess[str]:
    """Chromium with a profile of its own; what pages say on their console is on standard error."""
    call = [str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", *options]
    return subprocess.run(call, capture_output=True, text=True, timeout=120, check=True)


def test_scripts_run_without_a_word_on_the_console(report: Path, tmp_path: Path) -> None:
    done = browsed(f"--user-data-dir={tmp_path}", "--virtual-time-budget=2000", "--dump-dom", report.as_uri())
    assert "CONSOLE" not in done.stderr
    buttons, sortable = done.stdout.count("<button"), re.findall(r"<tr>(?:<th|<td)[^\n]*", done.stdout)
    assert (buttons > 0) == (len(sortable) > 1)
    assert "http://" not in re.sub(r"http://www\.w3\.org/\S+", "", done.stdout)


@pytest.mark.parametrize("width", [400, 1400])
@pytest.mark.parametrize("dark", [False, True])
def test_pictures(report: Path, tmp_path: Path, width: int, dark: bool) -> None:
    """The page has its scheme's paper at the corner, and words and lines on it."""
    import matplotlib.image

    target = tmp_path / "page.png"
    scheme = ["--blink-settings=preferredColorScheme=0"] if dark else ["--blink-settings=preferredColorScheme=1"]
    size = f"--window-size={width},2400"
    browsed(f"--user-data-dir={tmp_path}", *scheme, size, f"--screenshot={target}", report.as_uri())
    pixels = matplotlib.image.imread(target)[:, :, :3]
    corner = tuple(round(255 * float(value)) for value in pixels[2, 2])
    assert corner == ((0x16, 0x18, 0x1D) if dark else (255, 255, 255))
    assert (abs(pixels - pixels[2, 2]).max(axis=2) > 0.3).mean() > 0.01
