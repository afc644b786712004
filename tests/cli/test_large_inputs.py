"""The work on a description grows with its links, not with their square; the memory for a motion not with its rows."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import CodeType

import polars as pl
import pytest
from benchmarks.timing import of_process
from helpers.command_line import ARM, HEADER
from helpers.counted_calls import calls

from robodyn.checks.check import check_one
from robodyn.checks.overview import overview
from robodyn.report.check import overview_sections
from robodyn.report.document import text

LINK = (
    '<link name="link_{i}"><inertial><mass value="{m}"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0"'
    ' izz="0.1"/></inertial><visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>'
)
JOINT = (
    '<joint name="joint_{i}" type="{kind}"><origin xyz="0.1 0 0"/><parent link="link_{parent}"/>'
    '<child link="link_{i}"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="10" velocity="1"/></joint>'
)
CARRIERS: dict[str, Callable[[int], int]] = {
    "chain": lambda i: i - 1,
    "star": lambda i: 0,
    "tree": lambda i: (i - 1) // 2,
}


def robot(links: int, shape: str, kind: str) -> bytes:
    bodies = (LINK.format(i=i, m=1 + i % 7) for i in range(links))
    joints = (JOINT.format(i=i, kind=kind, parent=CARRIERS[shape](i)) for i in range(1, links))
    return f'<robot name="large">{"".join((*bodies, *joints))}</robot>'.encode()


def grows_with_links(work: Callable[[bytes], object], shape: str, kind: str) -> None:
    # up to 10 names that differ in a number are compared two by two; more are a list
    few, more, many = (robot(links, shape, kind) for links in (20, 50, 80))
    work(few)  # imports and what is kept for the next time
    base, once, twice = (calls(lambda each=each: work(each)) for each in (few, more, many))
    assert len(twice) > 100
    functions = [each for each in twice if isinstance(each, CodeType)]
    steep = [each for each in functions if twice[each] - once[each] > 1.2 * (once[each] - base[each]) + 100]
    assert not steep


@pytest.mark.parametrize(
    ("shape", "kind"), [("star", "fixed"), pytest.param("tree", "revolute", marks=pytest.mark.slow)]
)
def test_check_is_linear_in_the_links(shape: str, kind: str) -> None:
    grows_with_links(check_one, shape, kind)


@pytest.mark.slow
def test_info_is_linear_in_the_links() -> None:
    grows_with_links(lambda data: text(overview_sections(overview(data))), "chain", "revolute")


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
