"""Fused multiply-add: which products it takes in, how often it stands in the code, and that it is rounded once."""

from __future__ import annotations

import operator
import random
import re
from fractions import Fraction

import numpy as np
import pytest
from helpers.compiled_programs import bits, needs_compiler, program_of

from robodyn.programs.run.compiled_blocks import CompiledBlocks, kernel_of
from robodyn.programs.run.llvm.kernel import fused_products
from robodyn.programs.scalar import ADD, CONSTANT, INPUT, MUL, SUB

INPUTS = 4

FUSED = {
    "a sum": (lambda x, y, z, w: [x * y + z], 1, 0),
    "a difference": (lambda x, y, z, w: [x * y - z], 1, 0),
    "a difference from": (lambda x, y, z, w: [z - x * y], 1, 0),
    "a sum of two products takes in one": (lambda x, y, z, w: [x * y + z * w], 1, 1),
    "a square": (lambda x, y, z, w: [x * x - y], 1, 0),
    "a scalar product": (lambda x, y, z, w: [x * y + y * z + z * w + 1.0], 2, 1),
    "a product used by two sums": (lambda x, y, z, w: [x * y + z, w - x * y], 2, 0),
    "a product used once goes first": (lambda x, y, z, w: [x * y + z * w, x * y + z], 1, 1),
    "a product that is wanted itself": (lambda x, y, z, w: [x * y, x * y + z], 0, 1),
    "a product that is multiplied too": (lambda x, y, z, w: [x * y + z, x * y * w], 0, 2),
    "a product that is added to itself": (lambda x, y, z, w: [x * y + x * y], 0, 1),
    "a product under a root": (lambda x, y, z, w: [(x * y).sqrt() + z], 0, 1),
    "a product with a negative": (lambda x, y, z, w: [-(x * y) + z], 1, 0),
    "no product": (lambda x, y, z, w: [(x + y) - z / w], 0, 0),
}
"""Functions, how many sums take a product in, and how many products are formed."""

STEPS = [operator.add, operator.sub, operator.mul, operator.mul, lambda x, y: -x]


def sums_of_products(seed, steps):
    """A random program of sums, differences and products."""
    rng = random.Random(seed)

    def outputs(*x):
        pool = [*x, 0.7]
        for _ in range(steps):
            pool.append(rng.choice(STEPS)(rng.choice(pool), rng.choice(pool)))
        return pool[-rng.randint(1, 3) :]

    return program_of(outputs, INPUTS)


def counted(program):
    """Fused sums and products in the code."""
    code = kernel_of(program, {"x": INPUTS})
    return len(re.findall(r" = call <\d+ x double> @llvm\.fma\.", code)), code.count(" = fmul ")


@pytest.mark.parametrize("name", FUSED)
def test_which_products_are_fused(name):
    function, fused, formed = FUSED[name]
    program = program_of(function, INPUTS)
    assert len(fused_products(program)) == fused
    assert counted(program) == (fused, formed)


def rounded(exact, dtype):
    """The number of this type that is nearest to a fraction; of two equally near, the even one."""
    near = dtype(float(exact))
    candidates = [near, np.nextafter(near, dtype(np.inf)), np.nextafter(near, dtype(-np.inf))]
    return min(candidates, key=lambda x: (abs(Fraction(float(x)) - exact), bits(x).item() & 1))


def once_rounded(program, row, dtype):
    """The outputs for one sample in exact arithmetic, rounded as the compiled executor says it rounds."""
    taken = fused_products(program)
    formed = set(range(len(program.operations))) - set(taken.values())
    values = []
    for k, (op, a, b) in enumerate(program.operations):
        if op in (INPUT, CONSTANT):
            exact = Fraction(float(row[b] if op is INPUT else dtype(a)))
        elif b is None:
            exact = -values[a]
        else:
            exact = {ADD: Fraction.__add__, SUB: Fraction.__sub__, MUL: Fraction.__mul__}[op](values[a], values[b])
        values.append(Fraction(float(rounded(exact, dtype))) if k in formed else exact)
    return [float(values[k]) for k in program.outputs]


def numbers(count, dtype, seed):
    """Random numbers; in two of three samples z is the rounded product of x and y, or its negative."""
    rng = np.random.default_rng(seed)
    x = (rng.choice([-1.0, 1.0], (count, INPUTS)) * rng.uniform(1.0, 2.0, (count, INPUTS))).astype(dtype)
    product = x[:, 0] * x[:, 1]
    x[::3, 2], x[1::3, 2] = product[::3], -product[1::3]
    return x


@needs_compiler
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_sums_of_products_to_the_bit(dtype):
    given = [
        program_of(FUSED[name][0], INPUTS) for name in FUSED if name not in ("no product", "a product under a root")
    ]
    for seed, program in enumerate([*given, *(sums_of_products(seed, seed % 12 + 1) for seed in range(8))]):
        x = numbers(13, dtype, seed)
        found = CompiledBlocks(program, {"x": INPUTS}, dtype)({"x": x}, len(x))
        np.testing.assert_array_equal(found, [once_rounded(program, row, dtype) for row in x])
