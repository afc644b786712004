"""Time of `robodyn check` per robot: `cd tests && python -m benchmarks.bench_check`.

All robots of example-robot-data, one process, one after the other: every rule with meshes read anew (no cache), with
meshes known from a cache, and without the rules that need shapes. The first robot of all is checked once before, so
that imports do not count. `bench_simcheck` holds these times beside another program's.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from statistics import median

from helpers.example_robots import all_paths
from helpers.machine import machine
from helpers.markdown_tables import main, table

from robodyn.checks.check import STANDARD, Options, check_one

SHAPES = ("RD301", "RD302", "RD303", "RD304", "RD305", "RD6")
PLAIN = Options(ignore=SHAPES)


def times(paths: Sequence[Path], options: Options = STANDARD) -> list[float]:
    """Seconds for each file."""
    spent = []
    for path in paths:
        start = time.perf_counter()
        check_one(str(path), options)
        spent.append(time.perf_counter() - start)
    return spent


@contextmanager
def cached(folder: str) -> Iterator[None]:
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


def in_process(paths: Sequence[Path], turns: int) -> str:
    with tempfile.TemporaryDirectory() as folder:
        with cached(folder):
            times(paths)
        ways = (
            ("all rules, meshes read anew", "0", STANDARD),
            ("all rules, meshes known", folder, STANDARD),
            ("without the rules that need shapes", "0", PLAIN),
        )
        found: dict[str, list[list[float]]] = {name: [] for name, *_ in ways}
        for _ in range(turns):
            for name, place, options in ways:
                with cached(place):
                    found[name].append(times(paths, options))
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
