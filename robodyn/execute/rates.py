"""How fast the executors are on this machine: measured once, kept in the cache folder."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from robodyn.execute.numpy_blocks import NumpyBlocks
from robodyn.execute.object_cache import cache_folder, write_whole
from robodyn.trace.program import Program, trace


@dataclass(frozen=True)
class Rates:
    """Seconds.

    Attributes:
        call: per operation of a block by NumPy, however few its samples.
        numpy: per operation and sample by NumPy.
        compiled: per operation and sample by machine code, one thread.
        build: per operation compiled.
        load: to bring machine code to memory from the cache.
        start: to import the compiler.
    """

    call: float
    numpy: float
    compiled: float
    build: float
    load: float
    start: float


TYPICAL = Rates(call=4e-7, numpy=6e-10, compiled=4e-11, build=6e-5, load=3e-3, start=0.08)
"""A server processor of 2023 with AVX-512."""


def stored_rates() -> Rates | None:
    """The rates measured on this machine before, if they are kept."""
    path = _path()
    if path is None:
        return None
    with suppress(OSError, ValueError, TypeError):
        values = json.loads(path.read_text())
        rates = Rates(**{field.name: float(values[field.name]) for field in fields(Rates)})
        if all(0.0 < value < 10.0 for value in asdict(rates).values()):
            return rates
    return None


def measured_rates(compiled: Callable[[Program, dict[str, int]], Any]) -> Rates:
    """Rates measured now, in some tenths of a second, and kept.

    Args:
        compiled: makes the compiled executor of a program; it must compile, not load.
    """
    program, widths = _sample_program(), {"x": 8}
    few, many = (np.asfortranarray(np.full((samples, 8), 0.5)) for samples in (8, 4096))
    by_numpy = NumpyBlocks(program, widths)
    quick, slow = (_shortest(by_numpy, values) for values in (few, many))
    start = perf_counter()
    machine_code = compiled(program, widths)
    build = perf_counter() - start
    fast = _shortest(machine_code, many)
    rates = Rates(
        call=quick / program.size,
        numpy=max(slow - quick, 1e-9) / (program.size * len(many)),
        compiled=fast / (program.size * len(many)),
        build=build / program.size,
        load=TYPICAL.load,
        start=TYPICAL.start,
    )
    path = _path()
    if path is not None:
        write_whole(path, json.dumps(asdict(rates)).encode())
    return rates


def _shortest(run: Any, values: np.ndarray[Any, Any]) -> float:
    times = []
    for _ in range(5):
        start = perf_counter()
        run({"x": values}, len(values))
        times.append(perf_counter() - start)
    return min(times)


def _sample_program() -> Program:
    """Sums of products with a sine here and there, as recursions have them."""

    def outputs(tape: Any) -> list[Any]:
        x = [tape.input("x", k) for k in range(8)]
        for turn in range(40):
            x = [x[k] * x[(k + 3) % 8] + x[(k + turn) % 8] * 0.37 for k in range(8)]
            if turn % 8 == 0:
                x[0] = x[0].sin()
        return x

    return trace(outputs)


def _path() -> Path | None:
    folder = cache_folder()
    if folder is None:
        return None
    machine = "-".join((platform.node(), platform.machine(), str(os.cpu_count()), np.__version__))
    return folder / f"rates-{''.join(c if c.isalnum() or c in '.-' else '_' for c in machine)}.json"
