"""What a report takes beside the job itself: `robodyn torques` on a million rows, with `--report` and without.

    cd tests && python -m benchmarks.bench_report [--rows N] [--turns N] [--write FILE]

Each is a process of its own, and the two take turns: medians of the wall time, the quickest turn, which is nearest to
what a quiet machine does, and medians of the processor time of all threads and processes.
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
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.oracles import ROBOTS

HEAD = ("table", "alone", "with a report", "ratio", "quickest", "with a report", "ratio", "processor", "with a report")


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
    (mine, more), (busy, busier) = ([median(each[k][which] for each in spent) for k in range(2)] for which in range(2))
    quick, slow = (min(each[k][0] for each in spent) for k in range(2))
    return (
        title,
        f"{mine:.2f} s",
        f"{more:.2f} s",
        f"{more / mine:.2f}",
        f"{quick:.2f} s",
        f"{slow:.2f} s",
        f"{slow / quick:.2f}",
        f"{busy:.2f} s",
        f"{busier:.2f} s",
    )


def report(rows: int, turns: int) -> str:
    shown = [measured(title, with_rates, rows, turns) for title, with_rates in TABLES.items()]
    return f"{rows} rows of six joints:\n\n" + table(HEAD, shown) + "\n" + machine("polars", "matplotlib")


if __name__ == "__main__":
    main(report, __doc__, rows=1_000_000, turns=5)
