"""How fast each executor computes a program, on random samples."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Literal

import numpy as np
from benchmarks.timing import Timing, repeated

from robodyn.errors import InputError
from robodyn.measure.accuracy.torques import Executor, compile_anew
from robodyn.programs.program import Program
from robodyn.programs.run.compiled_blocks import content_of
from robodyn.programs.run.llvm.build import code_key, kept_objects
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


def build_times(way: Executor, program: Program, widths: Mapping[str, int]) -> tuple[Timing, Timing | None]:
    """What makes the executor ready: where nothing is cached, and from the cache; None where it keeps nothing."""
    ready = partial(way.ready, program, widths)
    if not way.compiles:
        return repeated(ready), None
    anew = repeated(partial(compile_anew, program, widths, way.dtype))
    ready()
    kept = kept_objects().get(code_key(content_of(program, widths, way.dtype)))
    return anew, None if kept is None else repeated(ready)
