"""Outputs that cannot be written: one line, exit status 2, nothing begun, an older file intact."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers import command_line
from helpers.command_line import Outcome, command, motion, run, write_arm

pytest.importorskip("resource")

FORMATS = ("csv", "parquet", "npz")
ROWS = 2000
SMALL_DISK = 20_000
"""Bytes: less than the table of `ROWS` rows takes."""
LIMITED = (
    "import os, resource as r, sys; n = int(sys.argv[1]); r.setrlimit(r.RLIMIT_FSIZE, (n, n)); "
    "os.environ['PYTHONDONTWRITEBYTECODE'] = '1'; os.execvp(sys.argv[2], sys.argv[2:])"
)
"""Runs a command whose files may have so many bytes."""
OLD = b"time,older\n"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    (tmp_path / "arm.csv").write_text(motion(ROWS))
    monkeypatch.chdir(tmp_path)


def refused(outcome: Outcome, line: str, *files: str) -> None:
    command_line.refused(outcome, line)
    assert sorted(path.name for path in Path().iterdir()) == sorted(["arm.csv", "arm.urdf", *files])


def test_full_disk() -> None:
    Path("tau.csv").write_bytes(OLD)
    limited = [sys.executable, "-c", LIMITED, str(SMALL_DISK), *command("torques", "arm.urdf", "arm.csv"), "--out"]
    done = subprocess.run([*limited, "tau.csv"], capture_output=True, check=False, text=True)
    line = "tau.csv: cannot be written: file too large"
    refused(Outcome(done.returncode, done.stdout, done.stderr), line, "tau.csv")
    assert Path("tau.csv").read_bytes() == OLD


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no device that is always full")
@pytest.mark.parametrize("form", FORMATS)
def test_full_device(form: str) -> None:
    out = f"full.{form}"
    os.symlink("/dev/full", out)
    refused(run("torques", "arm.urdf", "arm.csv", "--out", out), f"{out}: cannot be written: no space left", out)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no device that is always full")
def test_full_standard_output() -> None:
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            command("torques", "arm.urdf", "arm.csv"), stdout=full, stderr=subprocess.PIPE, check=False, text=True
        )
    assert (done.returncode, done.stderr) == (2, "error: standard output: no space left on device\n")


@pytest.mark.parametrize("form", FORMATS)
def test_an_error_in_the_last_row_leaves_nothing(form: str) -> None:
    Path("arm.csv").write_text(motion(ROWS) + "0,0,0,0,0,0,0\n")
    outcome = run("torques", "arm.urdf", "arm.csv", "--out", f"tau.{form}")
    refused(outcome, f"arm.csv:{ROWS + 2}: time 0.0 is before {(ROWS - 1) / 100}")
