"""Error against time of simulated motions, in one run: `cd tests && python -m benchmarks.bench_work_precision`.

For each program the least time in which it comes within an error at the end of the motion, by the best of its methods
and settings, which are tried from coarse to fine. Errors are relative to the largest angle or rate of the motion (to 1
for rotation matrices), against power series of the solution in 77 digits. One thread each; robots are read, and machine
code is made, before. SciPy's methods are given plain Python where the equations are short, else Pinocchio's `aba`;
Pinocchio has no integrator: RK4 is called from Python; MuJoCo does all steps in one call.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from time import perf_counter
from typing import NamedTuple

import numpy as np
from benchmarks.work_precision_systems import Run, System, mujocos, ours, pinocchios, scipys, systems
from helpers.machine import machine
from helpers.markdown_tables import main, table

from robodyn.measure.accuracy.ladder import timed

TARGETS = 1e-6, 1e-10
COARSEST, FINEST = 1e-3, 1e-12
LONGEST = 0.5
"""Seconds of a run, beyond which nothing finer is tried."""
WORTH = 30.0
"""A setting this many times slower than the quickest that is as good is not measured again."""
OURS = "rk4", "gauss6", "dop853"
SCIPY = "RK45", "DOP853", "LSODA", "Radau"
MUJOCO = "Euler", "RK4", "implicitfast"


class Point(NamedTuple):
    """A setting of a method of a program, its error and seconds."""

    program: str
    method: str
    setting: str
    error: float
    seconds: float

    @property
    def name(self) -> str:
        return f"{self.method}, {self.setting}"


def families(system: System) -> Iterator[tuple[str, str, Iterable[tuple[str, Run]]]]:
    for method in OURS:
        yield "robodyn", method, ours(system, method)
    for method in SCIPY:
        yield "SciPy", method, scipys(system, method)
    for method in MUJOCO:
        yield "MuJoCo", method, mujocos(system, method)
    yield "Pinocchio", "aba and RK4", pinocchios(system)


def points(system: System) -> tuple[list[Point], str]:
    """Every setting that is worth its time, its error at the end, and the reference."""
    expected, scale, how = system.reference()
    tried, runs = [], {}
    for program, method, settings in families(system):
        best, worse = np.inf, 0
        for setting, run in settings:
            run()
            begin = perf_counter()
            with np.errstate(all="ignore"):
                error = float((np.abs(run() - expected) / scale).max())
            seconds = perf_counter() - begin
            tried.append(Point(program, method, setting, error, seconds))
            runs[tried[-1]] = run
            worse = 0 if error < 0.5 * best else worse + 1
            best = min(best, error)
            if seconds > LONGEST or worse > 3 or best < FINEST:
                break
    good = [point for point in tried if point.error <= COARSEST]
    kept = [point for point in good if point.seconds <= WORTH * _least(good, point)]
    times = timed({str(k): runs[point] for k, point in enumerate(kept)})
    return [point._replace(seconds=times[str(k)][1].median) for k, point in enumerate(kept)], how


def _least(tried: Iterable[Point], point: Point) -> float:
    same = [each for each in tried if each.program == point.program]
    return min(each.seconds for each in same if each.error <= point.error)


def cheapest(found: Iterable[Point], program: str, target: float) -> Point | None:
    good = [point for point in found if point.program == program and point.error <= target]
    return min(good, key=lambda point: point.seconds, default=None)


def row(system: System, found: list[Point], target: float) -> tuple[str, ...]:
    best = {name: cheapest(found, name, target) for name in ("robodyn", "SciPy", "MuJoCo", "Pinocchio")}
    own, others = best.pop("robodyn"), [point for point in best.values() if point]
    ratio = f"{min(point.seconds for point in others) / own.seconds:.0f}" if own and others else "-"
    return system.name, f"{target:g}", *map(_cell, (own, *best.values())), ratio


def _cell(point: Point | None) -> str:
    return "-" if point is None else f"{1e3 * point.seconds:.3g} ms ({point.method})"


def report(every: int) -> str:
    """Args: every: 1 for more targets, and a line for each method that meets them."""
    rows, references, lines = [], [], []
    targets = (COARSEST, *TARGETS, FINEST) if every else TARGETS
    for system in systems():
        found, how = points(system)
        rows += [row(system, found, target) for target in targets]
        if every:
            lines += [(system.name, p.program, p.name, f"{p.error:.1e}", f"{1e3 * p.seconds:.3g}") for p in found]
        references.append(how)
    head = ("motion", "error", "robodyn", "SciPy", "MuJoCo", "Pinocchio", "next best / robodyn")
    text = table(head, rows, left=(0,))
    text += "\n" + table(("motion", "program", "setting", "error", "ms"), lines, left=(0, 1, 2)) if lines else ""
    text += f"\nReferences: {'; '.join(sorted(set(references)))}. "
    return text + machine("pin", "mujoco", "scipy", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__, every=0)
