"""Measuring time of several things in turn, on a machine that others use too; time and memory of processes."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Hashable, Mapping, Sequence
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import TypeVar

Key = TypeVar("Key", bound=Hashable)
Found = TypeVar("Found")

BUDGET = 0.8
"""Seconds for which rounds are repeated."""
SHORT = 0.15
"""The same where only one thing is measured."""
ROUNDS = 3
"""So many at least."""
TURN = 0.005
"""Seconds for which each runs again and again before the next has its turn, twice at least: the first run of a turn
has to bring its data back to the caches, more or less of it by what ran before."""


def in_turns(acts: Mapping[Key, Callable[[], Found]], turns: int) -> dict[Key, list[Found]]:
    """Return what each returns in so many turns, after a first one, which brings code and data to the caches."""
    rounds = [{name: act() for name, act in acts.items()} for _ in range(turns + 1)][1:]
    return {name: [found[name] for found in rounds] for name in acts}


def taking_turns(acts: Mapping[Key, Callable[[], object]]) -> dict[Key, float]:
    """Return the shortest time of each [s], which the rest of the machine disturbed least. They take turns, so that all
    meet the same load; a first round, which brings code and data to the caches, does not count."""
    for act in acts.values():
        act()
    return _rounds(acts, ROUNDS, BUDGET)


def repeated(act: Callable[[], object]) -> float:
    """Return how long it takes to make something [s], once if that is long."""
    return _rounds({"": act}, 1, SHORT)[""]


def _rounds(acts: Mapping[Key, Callable[[], object]], least: int, budget: float) -> dict[Key, float]:
    spent: dict[Key, list[float]] = {name: [] for name in acts}
    start, rounds = perf_counter(), 0
    while rounds < least or perf_counter() - start < budget:
        for name, act in acts.items():
            now = begin = perf_counter()
            runs = 0
            while runs < 2 or now - begin < TURN:
                act()
                before, now = now, perf_counter()
                spent[name].append(now - before)
                runs += 1
        rounds += 1
    return {name: min(times) for name, times in spent.items()}


def of_process(command: Sequence[str], **variables: str) -> tuple[float, float]:
    """Wall time [s] and peak memory [MB] of a new process, which writes bytecode as that of an installed package is."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"} | variables
    start = perf_counter()
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    spent = perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{command} failed")
    return spent, usage.ru_maxrss / (1 << 20 if sys.platform == "darwin" else 1 << 10)


def medians_of(runs: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """The median of each of the two numbers."""
    first, second = zip(*runs, strict=True)
    return median(first), median(second)


def installed() -> str:
    """The command `robodyn` beside this Python, or that of the path."""
    found = shutil.which("robodyn", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    assert found is not None
    return found
