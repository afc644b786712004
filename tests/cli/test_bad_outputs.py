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
"""Bytes: less than the table of `ROWS` rows takes in every format."""
LIMITED = (
    "import os, resource as r, sys; n = int(sys.argv[1]); r.setrlimit(r.RLIMIT_FSIZE, (n, n)); "
    "os.environ['PYTHONDONTWRITEBYTECODE'] = '1'; os.execvp(sys.argv[2], sys.argv[2:])"
)
"""Runs a command whose files may have so many bytes."""
OLD = {"csv": b"time,older\n", "parquet": b"PAR1 older", "npz": b"PK older"}


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_arm(tmp_path)
    (tmp_path / "arm.csv").write_text(motion(ROWS))
    monkeypatch.chdir(tmp_path)


def refused(outcome: Outcome, line: str, *files: str) -> None:
    command_line.refused(outcome, line)
    assert sorted(path.name for path in Path().iterdir()) == sorted(["arm.csv", "arm.urdf", *files])


def on_small_disk(*args: str) -> Outcome:
    limited = [sys.executable, "-c", LIMITED, str(SMALL_DISK), *command(*args)]
    done = subprocess.run(limited, capture_output=True, check=False, text=True)
    return Outcome(done.returncode, done.stdout, done.stderr)


@pytest.mark.parametrize("form", FORMATS)
def test_full_disk(form: str) -> None:
    out = f"tau.{form}"
    Path(out).write_bytes(OLD[form])
    refused(
        on_small_disk("torques", "arm.urdf", "arm.csv", "--out", out), f"{out}: cannot be written: file too large", out
    )
    assert Path(out).read_bytes() == OLD[form]


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


@pytest.mark.parametrize(
    ("out", "reason"),
    [
        ("no_folder/tau.csv", "no such file or directory"),
        ("arm.urdf/tau.csv", "not a directory"),
        ("folder.csv", "is a dir"),
        ("x" * 300 + ".csv", "file name too long"),
        ("nul\0.csv", "the name has a null character"),
    ],
)
def test_place_that_is_none(out: str, reason: str) -> None:
    os.mkdir("folder.csv")
    printable = out.replace("\0", "\\x00")
    line = f"{printable}: cannot be written: {reason}"
    refused(run("torques", "arm.urdf", "arm.csv", "--out", out), line, "folder.csv")


def test_no_permission(monkeypatch: pytest.MonkeyPatch) -> None:
    real = open

    def guarded(path: object, *args: object, **more: object) -> object:
        if "tau.csv" in str(path):
            raise PermissionError(13, "Permission denied", str(path))
        return real(path, *args, **more)  # type: ignore[call-overload]

    monkeypatch.setattr("builtins.open", guarded)
    refused(run("torques", "arm.urdf", "arm.csv", "--out", "tau.csv"), "tau.csv: cannot be written: permission denied")


@pytest.mark.parametrize("form", FORMATS)
def test_an_error_in_the_last_row_leaves_nothing(form: str) -> None:
    Path("arm.csv").write_text(motion(ROWS) + "0,0,0,0,0,0,0\n")
    outcome = run("torques", "arm.urdf", "arm.csv", "--out", f"tau.{form}")
    refused(outcome, f"arm.csv:{ROWS + 2}: time 0.0 is before {(ROWS - 1) / 100}")
