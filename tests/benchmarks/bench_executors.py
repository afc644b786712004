"""Every executor and Pinocchio's C++ in one run, robot by robot: `cd tests && python -m benchmarks.bench_executors`.

With `--forward 1` of forward dynamics against `abaInParallel`, else of inverse dynamics against `rneaInParallel`.

All have the same random samples in arrays that are ready, and an array to write to; they take turns, and the shortest
runs count. robodyn is called as users call it; Pinocchio has one thread and states as columns, as it wants them.
Friction and rotors are off, because Pinocchio leaves them out. It moves joints that mimic others as joints of their
own, so its degrees of freedom stand beside ours, and accelerations agree only where no joint mimics another.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from benchmarks.pinocchio_runs import ROBOTS, described, in_parallel, joints, nanoseconds, random_sources
from benchmarks.timing import repeated, taking_turns
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.oracles import worst

import robodyn
from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.plan import Plan, torque_runner
from robodyn.measure.accuracy.torques import compile_anew, laid_out
from robodyn.programs.run.compiled_blocks import CompiledBlocks, content_of
from robodyn.programs.run.llvm.build import code_key, kept_objects

HEAD = ("robot", "joints (Pinocchio)", "operations", "at rest")
BUILDS = ("trace", "build", "from cache")
ENDS = ("Pinocchio", "ratio", "agreement")


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


def runs(name: str, samples: int, forward: bool) -> tuple[dict[str, float], float]:
    """Time per sample of every way, and the largest difference from Pinocchio's results, of the largest of them."""
    model, scene = described(name)
    sources = random_sources(model, scene, samples)
    columns, rows = (laid_out(sources, order, np.float64) for order in ("F", "C"))
    out = np.empty((samples, model.n), order="F")
    function = robodyn.forward_dynamics if forward else robodyn.inverse_dynamics

    def ours(arrays, executor, threads=None, out=out):
        states = (arrays[source] for source in ("q", "qd", "qdd"))
        return partial(function, model, *states, scene=scene, out=out, executor=executor, threads=threads)

    states = [sources[source] for source in ("q", "qd", "qdd")]
    peer, found = in_parallel(model, "abaInParallel" if forward else "rneaInParallel", states)
    ways = {
        "NumPy": ours(columns, "numpy"),
        "compiled": ours(columns, "compiled", 1),
        "row-major": ours(rows, "compiled", 1, np.empty_like(out, order="C")),
        "2 threads": ours(columns, "compiled", 2),
        "Pinocchio": peer,
    }
    if forward:
        del ways["row-major"]
    return {way: time / samples for way, time in taking_turns(ways).items()}, worst(out, found())


def row(name: str, samples: int, forward: bool) -> tuple[str, ...]:
    times, off = runs(name, samples, forward)
    built = () if forward else builds(name)
    shared = forward and any(body.joint.mimics for body in described(name)[0].bodies)
    return (
        name,
        joints(name),
        *map(str, operations(name, forward)),
        *("-" if time is None else f"{1e3 * time:.1f} ms" for time in built),
        *(nanoseconds(time) for time in times.values()),
        f"{times['Pinocchio'] / times['compiled']:.1f}",
        "-" if shared else f"{off:.0e}",
    )


def report(samples: int, forward: int) -> str:
    middle = ("NumPy", "compiled", "2 threads") if forward else (*BUILDS, "NumPy", "compiled", "row-major", "2 threads")
    names = [name for name in ROBOTS if not forward or name != "Romeo"]
    rows = [row(name, samples, bool(forward)) for name in names]
    return table((*HEAD, *middle, *ENDS), rows) + "\n" + machine("pin", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__, samples=100_000, forward=0)
