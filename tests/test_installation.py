"""A checkout is installed as its users and its developers install it; the libraries are those of this process."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from shutil import copytree, ignore_patterns

import pytest

ROOT = Path(__file__).parents[1]
LIBRARIES = "numpy", "click", "yourdfpy", "platformdirs"
CALLS = ["bin/python", "-m", "robodyn"], ["bin/robodyn"]


def called(*call: str | Path) -> subprocess.CompletedProcess[str]:
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(call, capture_output=True, text=True, check=False, env=kept, cwd="/")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="an environment has its programs elsewhere")
@pytest.mark.parametrize("options", [(), ("-e",)], ids=["plain", "editable"])
def test_pip_installs_a_checkout(options: tuple[str, ...], tmp_path: Path) -> None:
    checkout, place = tmp_path / "checkout", tmp_path / "place"
    copytree(ROOT, checkout, ignore=ignore_patterns(".git", "tests", "docs", "robots", "__pycache__"))
    assert called(sys.executable, "-m", "venv", place).returncode == 0
    done = called(place / "bin/python", "-m", "pip", "install", "-q", "--no-deps", *options, checkout)
    assert done.returncode == 0, done.stderr
    packages = next(place.glob("lib/python*/site-packages"))
    for folder in {Path(str(import_module(name).__file__)).parents[1] for name in LIBRARIES}:
        for library in folder.iterdir():  # this process may have a robodyn of its own among them
            if "robodyn" not in library.name and not (packages / library.name).exists():
                (packages / library.name).symlink_to(library)
    where = called(place / "bin/python", "-c", "import robodyn.cli as cli; print(cli.__file__)")
    assert (checkout in Path(where.stdout).parents) == bool(options), where
    for program, *more in CALLS:
        info = called(place / program, *more, "info", str(ROOT / "robots" / "scara.urdf"))
        assert (info.returncode, info.stderr) == (0, "")
        assert "robot 'scara'" in info.stdout
