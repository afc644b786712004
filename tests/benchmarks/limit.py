"""The least time that the arithmetic of a program can take here, its instructions over what a core does in a second;
and what its kernel takes alone."""

from __future__ import annotations

import re
from ctypes import CFUNCTYPE, c_int64, c_void_p
from functools import cache, partial

import numpy as np
from benchmarks.timing import repeated, taking_turns

from robodyn.programs.program import Program
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.llvm.kernel import kernel
from robodyn.programs.run.llvm.machine import Function, machine_code

ARITHMETIC = re.compile(r" = (fadd|fsub|fmul|fdiv|call <\d+ x double> @llvm\.(fma|sqrt))")
SAMPLES = 256
CHAINS, ROUNDS = 12, 1_000_000
"""Independent multiply-adds: enough to hide what each waits for, few enough for sixteen registers; repetitions."""


def limit(program: Program, lanes: int) -> float:
    """Return the seconds of a state if every addition, multiplication and multiply-add took what the last takes at
    best: sines and cosines count by their polynomials, without the logic that finds their signs; loads, stores and
    moves for nothing. A core with more ports for additions may be faster than that."""
    widths = dict.fromkeys((source for source, _ in program.inputs), len(program.inputs))
    rows = program.rows(widths)
    return len(ARITHMETIC.findall(kernel(program.distinct, rows, "double", lanes))) * _multiply_add(lanes) / lanes


def alone(code: CompiledBlocks) -> float:
    """Return the seconds of a state by the kernel alone, on numbers in whole lines of the caches near a core."""
    pitch = SAMPLES + 8
    numbers = np.random.default_rng(0).uniform(-2.0, 2.0, code.rows * pitch + 8)
    table = numbers.ctypes.data + -numbers.ctypes.data % 64 + 8 * pitch * np.arange(code.rows)
    flags = np.zeros(SAMPLES, np.uint8)
    run = CFUNCTYPE(c_int64, c_void_p, c_void_p, c_int64)(code.kernel.address)
    half, whole = SAMPLES // 2, SAMPLES
    acts = {n: partial(run, table.ctypes.data, flags.ctypes.data, n // code.lanes) for n in (half, whole)}
    times = taking_turns(acts)
    return (times[whole] - times[half]) / (whole - half)


@cache
def _multiply_add(lanes: int) -> float:
    """Return the seconds between two multiply-adds of vectors that do not wait for each other."""
    vector, fma = f"<{lanes} x double>", f"@llvm.fma.v{lanes}f64"
    chains = range(CHAINS)
    lines = [
        f"declare {vector} {fma}({vector}, {vector}, {vector})",
        "define i64 @peak(i64 %rounds) {\nentry:\n  br label %loop\nloop:",
        "  %i = phi i64 [ 0, %entry ], [ %next, %loop ]",
        *(f"  %x{k} = phi {vector} [ splat (double {k}.0), %entry ], [ %y{k}, %loop ]" for k in chains),
        *(f"  %y{k} = call {vector} {fma}({vector} %x{k}, {vector} %x{k}, {vector} %x{k})" for k in chains),
        "  %next = add i64 %i, 1\n  %more = icmp ult i64 %next, %rounds",
        "  br i1 %more, label %loop, label %done\ndone:",
        *(f"  %s{k} = fadd {vector} {f'%s{k - 1}' if k else 'zeroinitializer'}, %y{k}" for k in chains),
        f"  %sum = extractelement {vector} %s{CHAINS - 1}, i64 0",
        "  %bits = bitcast double %sum to i64\n  ret i64 %bits\n}",
    ]
    peak = Function(machine_code("\n".join(lines)), "peak", c_int64)
    return repeated(lambda: peak(ROUNDS)) / (CHAINS * ROUNDS)
