"""Random programs, written by running random arithmetic on traced scalars, and inputs for them.

One generator draws from any `random.Random`: a seeded one for many programs, Hypothesis's for programs that shrink.
"""

from __future__ import annotations

import math
import random
from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st

from robodyn.programs.program import Program, trace
from robodyn.programs.scalar import Traced
from robodyn.programs.vectors import cos, exp, sign, sin

OPERATIONS = [*3 * ["add", "sub", "mul"], "div", "div", "neg", "sqrt", "sin", "cos", "sign", "exp"]
"""Each as often as it is drawn."""
SOURCES = ["q", "qd", "columns"]
CONSTANTS = [0.0, 1.0, -1.0, 2.0, -0.5, 3.7, -0.1, 1e-3, 1e-30, -1e8]
LIMIT = 16.0
"""Values of a well-conditioned program are kept below this."""


class Drawn(NamedTuple):
    """A program, and how many columns each source has; some may be read by nothing."""

    program: Program
    widths: dict[str, int]


class Bounded(NamedTuple):
    """A scalar, and a number that its magnitude does not exceed while inputs lie within +-2."""

    x: object
    most: float


def random_program(rng, operations):
    """A program of up to so many operations with 1 to 8 outputs.

    Every value has a magnitude of order 1 and no operation is near a pole or a branch point, so that rounding errors
    stay small for inputs within +-2.
    """
    widths = {source: rng.randint(1, 4) for source in SOURCES[: rng.randint(1, len(SOURCES))]}
    outputs = rng.randint(1, 8)
    early = rng.sample(range(outputs), rng.randint(0, outputs))

    def function(tape):
        inputs = [Bounded(tape.input(source, i), 2.0) for source, width in widths.items() for i in range(width)]
        pool = Pool(rng, inputs)
        for _ in range(operations):
            _step(rng.choice(OPERATIONS), pool)
        return [pool.known[-1].x, *(pool.pick().x for _ in range(outputs - 1))]

    return Drawn(trace(function, early), widths)


def programs():
    """Hypothesis's random programs."""
    return st.builds(random_program, st.randoms(), st.integers(0, 40))


def random_inputs(seed, widths, samples):
    """Arrays (samples, width) of ordinary numbers within +-2, zeros and ones among them."""
    rng = np.random.default_rng(seed)
    sources = {}
    for source, width in widths.items():
        shape = (samples, width)
        values = rng.uniform(-2.0, 2.0, shape)
        sources[source] = np.where(rng.random(shape) < 0.1, rng.choice([0.0, 1.0, -1.0], shape), values)
    return sources


def sqrt(x):
    return x.sqrt() if isinstance(x, Traced) else math.sqrt(x)


UNARY = {"neg": lambda x: -x, "sqrt": sqrt, "sin": sin, "cos": cos, "sign": sign, "exp": exp}
BINARY = {
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
}


class Pool:
    """The values of a program so far, from which operands are drawn.

    The last value (deep chains), one that nothing uses yet (bushes without dead code), any, one of the first (used many
    times) and constants come with odds that are drawn once, so that programs differ in their shape.
    """

    def __init__(self, rng, inputs):
        self.rng, self.known, self.loose = rng, list(inputs), list(inputs)
        self.constants = [Bounded(x, abs(x)) for x in CONSTANTS]
        self.odds = rng.choice(([8, 2, 1, 0, 1], [1, 8, 2, 0, 1], [2, 4, 2, 4, 1]))

    def add(self, x, most):
        self.known.append(Bounded(x, most))
        self.loose.append(self.known[-1])

    def pick(self):
        kinds = self.known[-1:], self.loose or self.known, self.known, self.known[:4], self.constants
        drawn = self.rng.choice(self.rng.choices(kinds, self.odds)[0])
        self.loose = [value for value in self.loose if value is not drawn]
        return drawn


def _step(op, pool):
    """An operation whose result is halved until it is small."""
    value, most = _smooth(op, *pool.pick(), *pool.pick()) if op in BINARY else _smooth(op, *pool.pick())
    if most > LIMIT:
        scale = 2.0 ** -math.ceil(math.log2(most / LIMIT))
        value, most = value * scale, most * scale
    pool.add(value, most)


def _smooth(op, x, most_x, y=None, most_y=0.0):
    """One operation with its operands moved to where it is smooth, and the bound of its result."""
    if op == "div":
        y = y + (most_y + 1.0)
    elif op == "sqrt":
        x = x + (most_x + 0.5)
    elif op == "exp" and most_x > 3.0:
        x, most_x = x / most_x, 1.0
    most = {
        "add": most_x + most_y,
        "sub": most_x + most_y,
        "mul": most_x * most_y,
        "div": most_x,
        "neg": most_x,
        "sqrt": math.sqrt(2.0 * most_x + 0.5),
        "exp": math.exp(min(most_x, 3.0)),
    }
    return BINARY[op](x, y) if op in BINARY else UNARY[op](x), most.get(op, 1.0)


def seeded(seed, operations):
    """The random program of a seed."""
    return random_program(random.Random(seed), operations)
