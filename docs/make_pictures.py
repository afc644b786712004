"""Draw the pictures of the documentation, screenshots of reports: `python docs/make_pictures.py`.

It needs chromium on the path and Pillow; the tests do not run it.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COLOURS = 96
ROBODYN = "from robodyn.cli.main import main; main()"
SIZING = "torques robots/puma560.urdf robots/puma560_sweep.csv --scene robots/puma560_sizing.toml"
PICTURES = {
    "report_torques": (SIZING, 1100, 1460),
    "report_check": ("check robots/puma560.urdf", 1100, 850),
}
"""By name: the command whose report is shown, and width and height of the window in pixels."""


def draw(name: str, command: str, width: int, height: int) -> Path:
    """Take a screenshot of the report of a command, in few colours, and return its file."""
    from PIL import Image

    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if browser is None:
        raise SystemExit("chromium is not installed")
    picture = ROOT / "docs" / "pictures" / f"{name}.png"
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "report.html"
        arguments = [sys.executable, "-c", ROBODYN, *command.split(), "--report", str(page)]
        subprocess.run(arguments, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        options = [
            "--headless",
            "--no-sandbox",
            "--enable-unsafe-swiftshader",
            "--virtual-time-budget=4000",
            "--hide-scrollbars",
            f"--window-size={width},{height}",
        ]
        shot = [browser, *options, f"--screenshot={picture}", page.as_uri()]
        subprocess.run(shot, check=True, stderr=subprocess.DEVNULL)
    Image.open(picture).convert("RGB").quantize(COLOURS).save(picture, optimize=True)
    return picture


if __name__ == "__main__":
    for name, (command, width, height) in PICTURES.items():
        file = draw(name, command, width, height)
        print(f"{file.relative_to(ROOT)}: {file.stat().st_size / 1000:.0f} kB")
