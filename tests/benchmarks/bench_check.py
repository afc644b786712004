"""Time of `robodyn check` per robot: `cd tests && python -m benchmarks.bench_check`.

All robots of example-robot-data, one process, one after the other: every rule with meshes read anew (no cache), with
meshes known from a cache, and without the rules that need shapes; a first round, with imports, does not count.
`bench_simcheck` holds these times beside another program's.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from statistics import median

import pytest
from benchmarks.timing import in_turns
from helpers.example_robots import all_paths
from helpers.machine import machine
from helpers.markdown_tables import main, table

from robodyn.checks.check import STANDARD, Options, check_one

SHAPES = ("RD301", "RD302", "RD303", "RD304", "RD305", "RD6")
PLAIN = Options(ignore=SHAPES)


def times(paths: Sequence[Path], cache: str, options: Options = STANDARD) -> list[float]:
    """Seconds for each file, with the cache in this folder; without one if it is 0."""
    spent = []
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("ROBODYN_CACHE", cache)
        for path in paths:
            start = time.perf_counter()
            check_one(str(path), options)
            spent.append(time.perf_counter() - start)
    return spent


def in_process(paths: Sequence[Path], turns: int) -> str:
    with tempfile.TemporaryDirectory() as folder:
        ways = {
            "all rules, meshes read anew": partial(times, paths, "0"),
            "all rules, meshes known": partial(times, paths, folder),
            "without the rules that need shapes": partial(times, paths, "0", PLAIN),
        }
        found = in_turns(ways, turns)
    rows = []
    for name, rounds in found.items():
        each = [median(robot) for robot in zip(*rounds, strict=True)]
        worst = max(range(len(each)), key=lambda k: each[k])
        rows.append(
            (name, f"{1e3 * median(each):.0f} ms", f"{1e3 * max(each):.0f} ms", paths[worst].stem, f"{sum(each):.1f} s")
        )
    return table(("per robot, one process", "median", "worst", "which", "all"), rows, left=(0, 3))


def report(turns: int) -> str:
    paths = all_paths()
    return f"All rules on the {len(paths)} robots of example-robot-data.\n\n{in_process(paths, turns)}\n{machine()}"


if __name__ == "__main__":
    main(report, __doc__, turns=3)
