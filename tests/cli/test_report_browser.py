"""Reports in headless Chromium, where there is one: scripts run, nothing is complained of, nothing is cut."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import ROBOTS, run

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
CALLS = {
    "torques": ("torques", "puma560.urdf", "puma560_sweep.csv"),
    "inertia": ("inertia", "meshed_arm.urdf"),
    "check": ("check", "puma560.urdf"),
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


PROBE = """<script>
const wide = document.documentElement.clientWidth, out = [];
for (const e of document.querySelectorAll("body *")) {
  if (e.parentElement.closest(".scroll, pre, svg, .skip") || e.matches(".skip")) continue;
  const box = e.getBoundingClientRect();
  if (box.width && box.right > wide + 1) out.push(`${e.tagName} ${e.textContent.slice(0, 30)}`);
}
for (const svg of document.querySelectorAll("svg")) {
  const paper = svg.getBoundingClientRect();
  for (const text of svg.querySelectorAll("text")) {
    const box = text.getBoundingClientRect();
    const cut = [paper.left - box.left, box.right - paper.right, paper.top - box.top, box.bottom - paper.bottom];
    if (box.width && Math.max(...cut) > 2) out.push(`text ${text.textContent.trim()}`);
  }
}
const head = document.querySelector("table th.n button");
if (head) head.click();
const place = head ? [...head.closest("tr").cells].indexOf(head.parentElement) : 0;
const cells = head ? [...head.closest("table").tBodies[0].rows].map((row) => row.cells[place].textContent) : [];
parent.postMessage(JSON.stringify({ out, cells, wide }), "*");
</script></body>"""


FRAME = """<!DOCTYPE html><title>nothing</title><script>onmessage = (said) => { document.title = said.data; };</script>
<iframe src="page.html" width="WIDTH" height="2000" style="border: 0"></iframe>"""
"""A window of Chromium is not as narrow as a phone; a frame is."""


def probed(source: str, folder: Path, width: int) -> dict[str, Any]:
    """What sticks out of a page or is cut, and the first column of numbers after a click on its head."""
    policy = re.compile(r'<meta http-equiv="Content-Security-Policy"[^>]*>')
    (folder / "page.html").write_text(policy.sub("", source).replace("</body>", PROBE), encoding="utf-8")
    frame = folder / "frame.html"
    frame.write_text(FRAME.replace("WIDTH", str(width)), encoding="utf-8")
    how = f"--user-data-dir={folder / 'profile'}", "--hide-scrollbars", "--virtual-time-budget=5000"
    done = browsed(*how, "--window-size=1400,2100", "--dump-dom", frame.as_uri())
    title = re.search(r"<title>(.*?)</title>", done.stdout, re.DOTALL)
    assert title
    found: dict[str, Any] = json.loads(unescape(title[1]))
    assert found["wide"] == width
    return found


@pytest.mark.parametrize("width", [360, 1280])
def test_nothing_is_cut_and_tables_sort_by_size(report: Path, tmp_path: Path, width: int) -> None:
    source = report.read_text(encoding="utf-8")
    found = probed(source, tmp_path, width)
    assert found["out"] == []
    numbers = (re.match(r"[-+]?\d[\d.]*(e[-+]\d+)?", cell) for cell in found["cells"])
    sizes = [abs(float(number[0])) for number in numbers if number]
    assert sizes == sorted(sizes, reverse=True)
    wide = source.replace("</main>", '<div style="width: 2000px">too wide</div></main>')
    assert probed(wide, tmp_path, width)["out"] != [], "the probe sees what is too wide"
