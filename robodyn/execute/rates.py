"""How fast the executors are on this machine: measured once, kept in the cache folder."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, fields
from time import perf_counter
from typing import Any

import numpy as np

from robodyn.execute.choice import TYPICAL, Rates
from robodyn.execute.llvm.build import generator, kept_objects
from robodyn.execute.llvm.machine import Function, compiler, machine_code
from robodyn.execute.numpy_blocks import NumpyBlocks
from robodyn.execute.object_cache import Key
from robodyn.spatial import ZERO, cross, rotation_about
from robodyn.trace.program import Program, trace


def stored_rates() -> Rates | None:
    """The rates measured on this machine before, if they are kept."""
    with suppress(ValueError, TypeError, LookupError, OverflowError):
        values = json.loads(kept_objects().get(_key()) or b"")
        rates = Rates(**{field.name: float(values[field.name]) for field in fields(Rates)})
        return rates if rates.sane else None
    return None


def measured_rates() -> Rates:
    """Rates measured now, in some tenths of a second, and kept; the typical ones if the machine is too busy to tell.

    Raises:
        ImportError, OSError, RuntimeError: there is no compiler here.
    """
    from robodyn.execute.compiled_blocks import CompiledBlocks, kernel_of

    program, widths = _sample_program(bodies=6), {"x": 12}
    code = machine_code(kernel_of(program, widths))
    build = _shortest(lambda: machine_code(kernel_of(program, widths)), 2)
    load = _shortest(lambda: Function(code, "kernel"), 3)
    numpy, compiled = NumpyBlocks(program, widths), CompiledBlocks(program, widths)
    few, many = (np.asfortranarray(np.full((samples, 12), 0.5)) for samples in (8, 4096))
    each = program.size * (len(many) - len(few))
    block = _shortest(lambda: numpy({"x": few}, len(few)))
    run = _shortest(lambda: compiled({"x": few}, len(few)))
    rates = Rates(
        call=block / program.size,
        numpy=(_shortest(lambda: numpy({"x": many}, len(many))) - block) / each,
        run=run,
        compiled=(_shortest(lambda: compiled({"x": many}, len(many))) - run) / each,
        build=build / program.size,
        load=load,
        start=compiler().start or TYPICAL.start,
    )
    if not rates.sane:
        return TYPICAL
    kept_objects().put(_key(), json.dumps(asdict(rates)).encode())
    return rates


def _shortest(run: Callable[[], object], turns: int = 5) -> float:
    times = []
    for _ in range(turns):
        start = perf_counter()
        run()
        times.append(perf_counter() - start)
    return min(times)


def _sample_program(bodies: int) -> Program:
    """A recursion like those of dynamics: the centripetal forces on a chain of points, and their sums."""
    axis, offset = np.array([0.6, 0.0, 0.8]), np.array([0.1, 0.2, 0.3])

    def outputs(tape: Any) -> list[Any]:
        q, qd = ([tape.input("x", first + k) for k in range(bodies)] for first in (0, bodies))
        turns = [rotation_about(axis, angle) for angle in q]
        w, a, forces, torques = ZERO, ZERO, [], []
        for R, speed in zip(turns, qd, strict=True):
            w = R.T @ w + axis * speed
            a = R.T @ (a + cross(w, cross(w, offset)))
            forces.append(a * 2.5)
        f = n = ZERO
        for R, force in zip(reversed(turns), reversed(forces), strict=True):
            f, n = R @ (f + force), R @ (n + cross(offset, f))
            torques.append(axis @ n)
        return torques

    return trace(outputs)


def _key() -> Key:
    machine = platform.node(), platform.machine(), os.cpu_count(), np.__version__
    return Key("rates", repr((generator(), machine)))
