"""Executors and Pinocchio's C++ in one run, robot by robot: `cd tests && python -m benchmarks.bench_executors`.

With `--forward 1` of forward dynamics against `abaInParallel`, else of inverse dynamics against `rneaInParallel`.

All have the same random samples in arrays that are ready, and an array to write to; they take turns, and the shortest
runs count. Machine code is made for AVX2 and for AVX-512, where the processor has both, and else for what there is.
Pinocchio has one thread and states as columns, as it wants them. Friction and rotors are off, because Pinocchio leaves
them out. It moves joints that mimic others as joints of their own, so its degrees of freedom stand beside ours, and
accelerations agree only where no joint mimics another.
"""

from __future__ import annotations

import os
from functools import partial

import numpy as np
from benchmarks.limit import alone, limit
from benchmarks.pinocchio_runs import ROBOTS, described, in_parallel, joints, nanoseconds, random_sources
from benchmarks.timing import repeated, taking_turns
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.oracles import worst

from robodyn.dynamics.forward import acceleration_program, acceleration_runner
from robodyn.dynamics.plan import Plan, torque_runner
from robodyn.measure.accuracy.torques import compile_anew
from robodyn.programs.run.compiled_blocks import CompiledBlocks, content_of
from robodyn.programs.run.llvm import machine as machine_code
from robodyn.programs.run.llvm.build import code_key, kept_objects
from robodyn.programs.run.llvm.machine import LEVELS, NATIVE
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.run.runner import Runner

HEAD = ("robot", "joints (Pinocchio)", "operations", "at rest")
BUILDS = ("trace", "build", "from cache")
CODE = {"AVX2": "x86-64-v3", "AVX-512": "x86-64-v4"}


def kinds() -> dict[str, str]:
    """Machine code that runs here, of which the first is looked at more closely, and what `ROBODYN_CPU` calls it."""
    features = machine_code.host().features.split(",")
    found = {title: level for title, level in CODE.items() if {f"+{x}" for x in LEVELS[level]} <= {*features}}
    return found or {"machine code": NATIVE}


def compiled(title: str, runner: Runner) -> CompiledBlocks:
    """A program as machine code of this kind, in a process whose own kind is another."""
    os.environ["ROBODYN_CPU"] = kinds()[title]
    machine_code.host.cache_clear()
    try:
        return CompiledBlocks(runner.program, runner.widths)
    finally:
        del os.environ["ROBODYN_CPU"]
        machine_code.host.cache_clear()


def operations(name: str, forward: bool = False) -> tuple[int, int]:
    """Operations per sample of a motion, and of a robot at rest."""
    model, scene = described(name)
    still = frozenset((source, i) for source in (("qd",) if forward else ("qd", "qdd")) for i in range(model.n))
    plans = Plan(model, scene), Plan(model, scene, still)
    moving, resting = ((acceleration_program(each) if forward else each.torques()).size for each in plans)
    return moving, resting


def builds(name: str) -> tuple[float, float, float | None]:
    """Tracing, making machine code, and loading it from the cache; None where it keeps nothing."""
    runner = torque_runner(*described(name))
    given = runner.program, runner.widths
    ready = partial(CompiledBlocks, *given)
    anew = repeated(partial(compile_anew, *given))
    ready()
    kept = kept_objects().get(code_key(content_of(*given, np.float64)))
    return repeated(Plan(*described(name)).torques), anew, None if kept is None else repeated(ready)


def runs(name: str, samples: int, forward: bool) -> tuple[dict[str, float], dict[str, tuple[float, float]], float]:
    """Time per sample of every way; of each kind of code the limit, and the time of the kernel alone; and the largest
    difference from Pinocchio's results, of the largest of them."""
    model, scene = described(name)
    sources = random_sources(model, scene, samples)
    runner = (acceleration_runner if forward else torque_runner)(model, scene)
    given = sources | {"tau": sources["qdd"]}
    columns, rows = ({x: np.asarray(given[x], order=order) for x in runner.widths} for order in ("F", "C"))
    out = np.empty((samples, model.n), order="F")
    code = {title: compiled(title, runner) for title in kinds()}
    first = next(iter(code.values()))
    states = [sources[source] for source in ("q", "qd", "qdd")]
    peer, found = in_parallel(model, "abaInParallel" if forward else "rneaInParallel", states)
    ways = {
        "NumPy": partial(NumpyBlocks(runner.program, runner.widths), columns, samples, out),
        **{title: partial(each, columns, samples, out) for title, each in code.items()},
        "row-major": partial(first, rows, samples, np.empty((samples, model.n))),
        "2 threads": partial(first, columns, samples, out, 2),
        "Pinocchio": peer,
    }
    times = {way: time / samples for way, time in taking_turns(ways).items()}
    first(columns, samples, out)
    limits = {title: (limit(runner.program, each.lanes), alone(each)) for title, each in code.items()}
    return times, limits, worst(out, found())


def row(name: str, samples: int, forward: bool) -> tuple[str, ...]:
    times, limits, off = runs(name, samples, forward)
    built = () if forward else builds(name)
    shared = forward and any(body.joint.mimics for body in described(name)[0].bodies)
    return (
        name,
        joints(name),
        *map(str, operations(name, forward)),
        *("-" if time is None else f"{1e3 * time:.1f} ms" for time in built),
        *(nanoseconds(time) for time in times.values()),
        *(f"{times['Pinocchio'] / times[title]:.1f}" for title in limits),
        *(f"{bound / times[title]:.0%}, {bound / kernel:.0%}" for title, (bound, kernel) in limits.items()),
        "-" if shared else f"{off:.0e}",
    )


def report(samples: int, forward: int) -> str:
    titles = [*kinds()]
    ends = (*(f"ratio, {x}" for x in titles), *(f"of the limit, all and kernel, {x}" for x in titles), "agreement")
    head = (*HEAD, *(() if forward else BUILDS), "NumPy", *titles, "row-major", "2 threads", "Pinocchio", *ends)
    names = [name for name in ROBOTS if not forward or name != "Romeo"]
    return table(head, [row(name, samples, bool(forward)) for name in names]) + "\n" + machine("pin", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__, samples=30_000, forward=0)
