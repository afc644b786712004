"""What a report takes beside the job itself: `robodyn torques` on a million rows, with `--report` and without.

    cd tests && python -m benchmarks.bench_report [--rows N] [--turns N] [--write FILE]

Each is a process of its own, the two take turns, and the medians count: wall time, and the processor time of all
threads and processes, which depends less on what else the machine does.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median

from benchmarks.bench_streaming import ROBOT, TABLES, write_motion
from machine import machine
from markdown_tables import main, table
from oracles import ROBOTS

HEAD = ("table", "alone", "with a report", "ratio", "processor time", "with a report", "report")


def run(command: Sequence[str]) -> tuple[float, float]:
    """Wall and processor time [s] of a process and those that it starts."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    spent, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measured(title: str, with_rates: bool, rows: int, turns: int) -> tuple[str, ...]:
    """A row of the report."""
    robodyn = shutil.which("robodyn", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    with tempfile.TemporaryDirectory() as folder:
        source, page = Path(folder) / "motion.csv", Path(folder) / "report.html"
        write_motion(source, rows, with_rates)
        alone = [str(robodyn), "torques", str(ROBOTS / f"{ROBOT}.urdf"), str(source)]
        run(alone)
        spent = [(run(alone), run([*alone, "--report", str(page)])) for _ in range(turns)]
        size = page.stat().st_size / 1e6
    wall, cpu = ([[median(each[k][which] for each in spent) for k in range(2)]] for which in range(2))
    (mine, more), (busy, busier) = wall[0], cpu[0]
    return (
        title,
        f"{mine:.2f} s",
        f"{more:.2f} s",
        f"{more / mine:.2f}",
        f"{busy:.2f} s",
        f"{busier:.2f} s",
        f"{size:.1f} MB",
    )


def report(rows: int, turns: int) -> str:
    shown = [measured(title, with_rates, rows, turns) for title, with_rates in TABLES.items()]
    return f"{rows} rows of six joints:\n\n" + table(HEAD, shown) + "\n" + machine("polars", "matplotlib")


if __name__ == "__main__":
    main(report, __doc__, rows=1_000_000, turns=5)
