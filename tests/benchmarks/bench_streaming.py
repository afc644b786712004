"""A CSV of millions of rows through `robodyn torques`, against polars alone.

    cd tests && python -m benchmarks.bench_streaming [--rows N] [--turns N] [--write FILE]

The table has time and q, qd, qdd of six joints, 19 columns, or time and q alone, 7 columns. polars reads it and writes
time and six columns, which is what any program pays that uses it; robodyn writes time and six torques, and its report.
Each is a process of its own, the two take turns, and the medians count.
"""

from __future__ import annotations

import sys
import tempfile
from functools import partial
from pathlib import Path

import polars as pl
from benchmarks.bench_tables import motion
from benchmarks.timing import in_turns, installed, medians_of, of_process
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.oracles import ROBOTS, robot

ROBOT = "puma560"
CHUNK = 20_000
ALONE = """
import sys, polars
frame = polars.read_csv(sys.argv[1])
frame.select(frame.columns[:7]).write_csv(sys.argv[2])
"""
HEAD = ("table", "size", "robodyn", "polars", "ratio", "memory of robodyn", "of polars")
TABLES = {"time, q, qd, qdd": True, "time, q": False}


def write_motion(path: Path, rows: int, with_rates: bool) -> None:
    """Sines of 1 ms steps for every joint, within its limits; with velocities and accelerations, or positions alone."""
    names = robot(ROBOT).joint_names
    with path.open("wb") as file:
        for start in range(0, rows, CHUNK):
            frame = pl.DataFrame(motion(range(start, min(start + CHUNK, rows)), names))
            frame = frame if with_rates else frame.select(frame.columns[: 1 + len(names)])
            file.write(frame.write_csv(include_header=start == 0).encode())


def measured(title: str, with_rates: bool, rows: int, turns: int) -> tuple[str, ...]:
    """A row of the report."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "motion.csv", Path(folder) / "out.csv"
        write_motion(source, rows, with_rates)
        size = source.stat().st_size / 1e6
        ours = [installed(), "torques", str(ROBOTS / f"{ROBOT}.urdf"), str(source), "--out", str(target)]
        alone = [sys.executable, "-c", ALONE, str(source), str(target)]
        found = in_turns({"ours": partial(of_process, ours), "alone": partial(of_process, alone)}, turns)
    (mine, my_memory), (raw, raw_memory) = map(medians_of, found.values())
    times = (f"{mine:.2f} s", f"{raw:.2f} s", f"{mine / raw:.2f}")
    return (title, f"{size:.0f} MB", *times, f"{my_memory:.0f} MB", f"{raw_memory:.0f} MB")


def report(rows: int, turns: int) -> str:
    shown = [measured(title, with_rates, rows, turns) for title, with_rates in TABLES.items()]
    return f"{rows} rows of six joints in, torques out:\n\n" + table(HEAD, shown) + "\n" + machine("polars")


if __name__ == "__main__":
    main(report, __doc__, rows=2_000_000, turns=5)
