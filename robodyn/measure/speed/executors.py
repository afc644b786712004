"""How fast each executor computes a program, on random samples."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from robodyn.errors import InputError
from robodyn.loads.figures import REMEDY
from robodyn.measure.speed.result import CopyBench, ExecutorBench, Timing
from robodyn.measure.timing import Copying, largest_difference, repeated, taking_turns
from robodyn.programs.program import Program
from robodyn.programs.run.compiled_blocks import CompiledBlocks, content_of, kernel_of
from robodyn.programs.run.llvm.build import code_key, kept_objects
from robodyn.programs.run.llvm.machine import Function, compiler, machine_code
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.robot.configuration import unit_rows
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats

Order = Literal["F", "C"]
LAYOUTS: dict[str, Order] = {"columnar": "F", "row-major": "C"}
MEMORY = 4 << 30
"""Bytes that samples may take."""
COPIES = 3
"""Of every number: in both layouts, and in both once more in single precision."""


def random_sources(model: Model, scene: Scene, samples: int) -> dict[str, Floats]:
    """Arrays for the programs of this robot, with columns contiguous: q up to 2, rates and further columns up to 3.

    All numbers are those of single precision, so that every executor works on the same; quaternions are of unit length
    within that.

    Raises:
        InputError: they would take too much memory.
    """
    columns = {"q": model.nq, "qd": model.n, "qdd": model.n, "columns": len(scene.columns)}
    size = 8 * COPIES * samples * (sum(columns.values()) + model.n)
    if size > MEMORY:
        raise InputError(
            f"{samples} samples of {model.n} joints take {size / 1e9:.0f} GB",
            remedy=f"--samples {MEMORY // (size // samples)} or fewer; 100000 suffice",
        )
    rng = np.random.default_rng(0)
    sources = {
        name: rng.uniform(-3.0, 3.0, (count, samples)).astype(np.float32).astype(np.float64).T
        for name, count in columns.items()
    }
    sources["q"] *= 2.0 / 3.0
    unit_rows(model, sources["q"])
    sources["q"] = np.asfortranarray(sources["q"].astype(np.float32), np.float64)
    return sources


def laid_out(sources: Mapping[str, Floats], order: Order, dtype: DTypeLike) -> dict[str, NDArray[Any]]:
    """Return the same numbers with contiguous columns ("F") or rows ("C")."""
    return {name: np.asarray(values, dtype, order) for name, values in sources.items()}


COPY = "copy"


class Work(NamedTuple):
    """A program and samples for it.

    Attributes:
        widths: columns of each source.
        sources: arrays with contiguous columns.
    """

    program: Program
    widths: Mapping[str, int]
    sources: Mapping[str, Floats]
    samples: int


class Executor(NamedTuple):
    """A way to run programs.

    Attributes:
        ready: from a program and widths to what runs.
    """

    name: str
    dtype: Any
    ready: Callable[[Program, Mapping[str, int]], Any]

    @property
    def compiles(self) -> bool:
        return self.name != "numpy"


def available() -> tuple[Executor, ...]:
    """Return the executors that run here; the first is NumPy in double precision."""
    plain = Executor("numpy", np.float64, NumpyBlocks)
    if compiler().problem:
        return (plain,)
    single = partial(CompiledBlocks, dtype=np.float32)
    return (plain, Executor("compiled", np.float64, CompiledBlocks), Executor("compiled float32", np.float32, single))


def compile_anew(program: Program, widths: Mapping[str, int], dtype: Any = np.float64) -> None:
    """Make machine code of a program and load it, whatever the cache holds."""
    Function(machine_code(kernel_of(program, widths, dtype)), "kernel")


def build_times(way: Executor, program: Program, widths: Mapping[str, int]) -> tuple[Timing, Timing | None]:
    """What makes the executor ready: where nothing is cached, and from the cache; None where it keeps nothing."""
    ready = partial(way.ready, program, widths)
    if not way.compiles:
        return repeated(ready), None
    anew = repeated(partial(compile_anew, program, widths, way.dtype))
    ready()
    kept = kept_objects().get(code_key(content_of(program, widths, way.dtype)))
    return anew, None if kept is None else repeated(ready)


def executor_benches(work: Work, threads: int) -> tuple[tuple[ExecutorBench, ...], CopyBench]:
    """Time every executor on the same samples, and copying memory, all in turn.

    Raises:
        InputError: a result is not finite.
    """
    ways = available()
    builds = {way: build_times(way, work.program, work.widths) for way in ways}
    results: dict[Executor, Floats] = {}
    acts: dict[tuple[Any, str, int], Callable[[], object]] = {}
    for way in ways:
        run = way.ready(work.program, work.widths)
        for layout, order in LAYOUTS.items():
            sources = laid_out(work.sources, order, way.dtype)
            out = np.empty((work.samples, len(work.program.outputs)), way.dtype, order)
            results[way] = out
            for count in sorted({1, threads if way.compiles else 1}):
                more = (count,) if way.compiles else ()
                acts[way, layout, count] = partial(run, sources, work.samples, out, *more)
    size = 8 * (len(work.program.inputs) + len(work.program.outputs))
    copying = Copying(size * work.samples)
    acts |= {(COPY, "", count): partial(copying, count) for count in sorted({1, threads})}
    spent = taking_turns(acts)
    if not np.isfinite(results[ways[0]]).all():
        raise InputError("the torques of some samples overflow", remedy=REMEDY)
    times = {key: timing.per(work.samples) for key, timing in spent.items()}
    copied = CopyBench(size, times[COPY, "", 1], times[COPY, "", threads] if threads > 1 else None)
    found = tuple(
        _bench(way, work, threads, builds[way], times, largest_difference(results[way], results[ways[0]]), copied)
        for way in ways
    )
    return found, copied


def _bench(
    way: Executor,
    work: Work,
    threads: int,
    builds: tuple[Timing, Timing | None],
    times: Mapping[tuple[Any, str, int], Timing],
    difference: float,
    copied: CopyBench,
) -> ExecutorBench:
    size = np.dtype(way.dtype).itemsize * (len(work.program.inputs) + len(work.program.outputs))
    shared = threads > 1 and way.compiles
    columnar = times[way, "columnar", 1]
    return ExecutorBench(
        name=way.name,
        dtype=np.dtype(way.dtype).name,
        build=builds[0],
        load=builds[1],
        columnar=columnar,
        row_major=times[way, "row-major", 1],
        columnar_threads=times[way, "columnar", threads] if shared else None,
        row_major_threads=times[way, "row-major", threads] if shared else None,
        difference=difference if np.isfinite(difference) else None,
        bytes=size,
        of_copying=(size / columnar.least) / (copied.bytes / copied.one.least),
    )
