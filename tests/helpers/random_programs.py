"""Random programs, written by running random arithmetic on traced scalars, and inputs for them."""

from __future__ import annotations

import math
import random
from typing import NamedTuple

import numpy as np

from robodyn.programs.program import Program, trace
from robodyn.programs.vectors import cos, exp, sign, sin, sqrt

OPERATIONS = [*3 * ["add", "sub", "mul"], "div", "div", "neg", "sqrt", "sin", "cos", "sign", "exp"]
"""Each as often as it is drawn."""
CONSTANTS = [0.0, 1.0, -1.0, 2.0, -0.5, 3.7, -0.1, 1e-3, 1e-30, -1e8]
LIMIT = 16.0
"""Values of a well-conditioned program are kept below this."""


class Drawn(NamedTuple):
    """A program, and how many columns each source has; some may be read by nothing."""

    program: Program
    widths: dict[str, int]


def random_program(rng, operations):
    """A program of up to so many operations with 1 to 8 outputs.

    Every value has a magnitude of order 1 and no operation is near a pole or a branch point, so that rounding errors
    stay small for inputs within +-2.
    """
    widths = {source: rng.randint(1, 4) for source in ("q", "qd", "columns")[: rng.randint(1, 3)]}
    outputs = rng.randint(1, 8)
    early = rng.sample(range(outputs), rng.randint(0, outputs))
    recent = rng.choice((1, 4, 1000))  # deep chains, bushes, anything

    def function(tape):
        known = [(tape.input(source, i), 2.0) for source, width in widths.items() for i in range(width)]
        constants = [(x, abs(x)) for x in CONSTANTS]
        for _ in range(operations):
            operands = (rng.choice(rng.choice((known[-recent:], known, known[:4], constants))) for _ in range(2))
            known.append(_step(rng.choice(OPERATIONS), *next(operands), *next(operands)))
        return [known[-1][0], *(rng.choice(known)[0] for _ in range(outputs - 1))]

    return Drawn(trace(function, early), widths)


def _step(op, x, most_x, y, most_y):
    """One operation, its operands moved to where it is smooth, its result halved until it is small, and its bound."""
    value, most = {
        "add": lambda: (x + y, most_x + most_y),
        "sub": lambda: (x - y, most_x + most_y),
        "mul": lambda: (x * y, most_x * most_y),
        "div": lambda: (x / (y + (most_y + 1.0)), most_x),
        "neg": lambda: (-x, most_x),
        "sqrt": lambda: (sqrt(x + (most_x + 0.5)), math.sqrt(2.0 * most_x + 0.5)),
        "sin": lambda: (sin(x), 1.0),
        "cos": lambda: (cos(x), 1.0),
        "sign": lambda: (sign(x), 1.0),
        "exp": lambda: (exp(x / max(most_x / 3.0, 1.0)), math.exp(3.0)),
    }[op]()
    scale = 2.0 ** -max(math.ceil(math.log2(max(most, 1.0) / LIMIT)), 0)
    return value * scale, most * scale


def seeded(seed, operations):
    """The random program of a seed."""
    return random_program(random.Random(seed), operations)


def random_inputs(seed, widths, samples):
    """Arrays (samples, width) of ordinary numbers within +-2, zeros and ones among them."""
    rng = np.random.default_rng(seed)
    sources = {}
    for source, width in widths.items():
        shape = (samples, width)
        values = rng.uniform(-2.0, 2.0, shape)
        sources[source] = np.where(rng.random(shape) < 0.1, rng.choice([0.0, 1.0, -1.0], shape), values)
    return sources
