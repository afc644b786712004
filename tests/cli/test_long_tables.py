"""A motion of many rows is read in memory that does not grow with its length."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import polars as pl
import pytest
from benchmarks.timing import of_process
from helpers.command_line import ARM, HEADER

SHORT, LONG = 20_000, 320_000
BLOCK_ROWS = 8192


def write_motion(path: Path, rows: int) -> None:
    """The arm's motion with full digits, through polars."""
    t = pl.int_range(rows, eager=True) / 1000.0
    columns = dict.fromkeys(HEADER.strip().split(","), (t * 0.1).sin())
    pl.DataFrame({**columns, "time": t}).write_csv(path)


def peak_resident(folder: Path, rows: int) -> float:
    """Resident memory at the most [MB] of `robodyn torques arm.urdf arm.csv --out tau.csv`, in small blocks."""
    write_motion(folder / "arm.csv", rows)
    code = (
        "from robodyn.trajectory.read import open_trajectory; "
        f"open_trajectory.__kwdefaults__['block_rows'] = {BLOCK_ROWS}; from robodyn.cli.main import main; main()"
    )
    files = [str(folder / name) for name in ("arm.urdf", "arm.csv", "tau.csv")]
    _, memory = of_process([sys.executable, "-c", code, "torques", *files[:2], "--out", files[2]])
    assert sum(1 for _ in (folder / "tau.csv").open()) == rows + 1
    return memory


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "wait4"), reason="the system does not tell the memory of a process")
def test_many_times_the_rows_in_the_same_memory(tmp_path: Path) -> None:
    """300 000 rows of 7 columns more are 17 MB as numbers and 40 MB as text."""
    (tmp_path / "arm.urdf").write_text(ARM)
    short, long = (peak_resident(tmp_path, rows) for rows in (SHORT, LONG))
    assert long - short <= 20.0
