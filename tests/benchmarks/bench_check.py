"""Time of `robodyn check` per robot: `cd tests && python -m benchmarks.bench_check`.

All robots of example-robot-data, one process, one after the other: every rule with meshes read anew (no cache), with
meshes known from a cache, and without the rules that need shapes. The first robot of all is checked once before, so
that imports do not count. simcheck's static checks of the same files (`simcheck check --static-only`, one job, no
cache), where there is such a command, are timed as a whole process in the same run, and so is `robodyn check`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from statistics import median

from helpers.example_robots import all_paths
from helpers.machine import machine
from helpers.markdown_tables import main, table

from robodyn.checks.catalogue import RULES
from robodyn.checks.run import STANDARD, Options, check_one

SHAPES = ("RD301", "RD302", "RD303", "RD304", "RD305", "RD6")
PLAIN = Options(ignore=SHAPES)
SIMCHECK = ("simcheck", "check", "--static-only", "--no-cache", "--no-config", "-j", "1", "-q")
OURS = (sys.executable, "-c", "from robodyn.cli.main import main; main()", "check", "--statistics")


def times(paths: Sequence[Path], options: Options = STANDARD) -> list[float]:
    """Seconds for each file."""
    spent = []
    for path in paths:
        start = time.perf_counter()
        check_one(str(path), options)
        spent.append(time.perf_counter() - start)
    return spent


@contextmanager
def cache(folder: str) -> Iterator[None]:
    """The cache in another folder; none if it is 0."""
    before = os.environ.get("ROBODYN_CACHE")
    os.environ["ROBODYN_CACHE"] = folder
    try:
        yield
    finally:
        if before is None:
            del os.environ["ROBODYN_CACHE"]
        else:
            os.environ["ROBODYN_CACHE"] = before


def whole(command: Sequence[str], paths: Sequence[Path]) -> float:
    """Wall time [s] of a process that checks all files."""
    start = time.perf_counter()
    run = subprocess.run([*command, *map(str, paths)], capture_output=True, text=True, check=False)
    if run.returncode not in (0, 1):
        raise RuntimeError(f"{command[0]} failed: {run.stderr[-300:]}")
    return time.perf_counter() - start


def in_process(paths: Sequence[Path], turns: int) -> str:
    with tempfile.TemporaryDirectory() as folder:
        with cache(folder):
            times(paths)
        ways = (
            ("all rules, meshes read anew", "0", STANDARD),
            ("all rules, meshes known", folder, STANDARD),
            ("without the rules that need shapes", "0", PLAIN),
        )
        found: dict[str, list[list[float]]] = {name: [] for name, *_ in ways}
        for _ in range(turns):
            for name, place, options in ways:
                with cache(place):
                    found[name].append(times(paths, options))
    rows = []
    for name, rounds in found.items():
        each = [median(robot) for robot in zip(*rounds, strict=True)]
        worst = max(range(len(each)), key=lambda k: each[k])
        rows.append(
            (name, f"{1e3 * median(each):.0f} ms", f"{1e3 * max(each):.0f} ms", paths[worst].stem, f"{sum(each):.1f} s")
        )
    return table(("per robot, one process", "median", "worst", "which", "all"), rows, left=(0, 3))


def as_processes(paths: Sequence[Path], turns: int) -> str:
    tool = shutil.which(SIMCHECK[0])
    if tool is None:
        return "simcheck is not installed.\n"
    ours, theirs = [], []
    with cache("0"):
        for _ in range(turns):
            ours.append(whole(OURS, paths))
            theirs.append(whole((tool, *SIMCHECK[1:]), paths))
    rows = [
        (
            name,
            f"{median(spent):.1f} s",
            f"{1e3 * median(spent) / len(paths):.0f} ms",
            f"{median(spent) / median(ours):.2f}",
        )
        for name, spent in (("robodyn check, no cache", ours), ("simcheck, static checks", theirs))
    ]
    return table((f"{len(paths)} robots in one command", "time", "per robot", "ratio"), rows)


def report(turns: int) -> str:
    paths = all_paths()
    head = f"{len(RULES)} rules on the {len(paths)} robots of example-robot-data.\n\n"
    return head + in_process(paths, turns) + "\n" + as_processes(paths, turns) + "\n" + machine()


if __name__ == "__main__":
    main(report, __doc__, turns=3)
