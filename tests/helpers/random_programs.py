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
EXTREMES = [-0.0, 5e-324, -1e-310, 2.0**-1022, 1e-200, -1e200, 1e300, 1.7e308]
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


def random_program(rng, operations, tame):
    """A program of up to so many operations with 1 to 8 outputs.

    Args:
        tame: every value has a magnitude of order 1 and no operation is near a pole or a branch point, so that rounding
            errors stay small for inputs within +-2; otherwise operations and constants are whatever comes.
    """
    widths = {source: rng.randint(1, 4) for source in SOURCES[: rng.randint(1, len(SOURCES))]}
    outputs = rng.randint(1, 8)
    early = rng.sample(range(outputs), rng.randint(0, outputs))

    def function(tape):
        inputs = [Bounded(tape.input(source, i), 2.0) for source, width in widths.items() for i in range(width)]
        pool = Pool(rng, inputs, CONSTANTS if tame else CONSTANTS + EXTREMES)
        for _ in range(operations):
            (_tame_step if tame else _wild_step)(rng.choice(OPERATIONS), pool)
        return [pool.known[-1].x, *(pool.pick().x for _ in range(outputs - 1))]

    return Drawn(trace(function, early), widths)


def programs(tame):
    """Hypothesis's random programs."""
    return st.builds(random_program, st.randoms(), st.integers(0, 40), st.just(tame))


def random_inputs(seed, widths, samples, tame):
    """Arrays (samples, width) of ordinary numbers within +-2, zeros and ones among them; others only if not tame."""
    rng = np.random.default_rng(seed)
    special = [0.0, 1.0, -1.0] if tame else [0.0, 1.0, -1.0, *EXTREMES, math.inf, -math.inf, math.nan]
    sources = {}
    for source, width in widths.items():
        shape = (samples, width)
        values = rng.uniform(-2.0, 2.0, shape)
        if not tame:
            values *= 10.0 ** rng.choice([0, 0, 0, 0, 0, 3, 5, -3, 12, -12], shape)
        sources[source] = np.where(rng.random(shape) < 0.1, rng.choice(special, shape), values)
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

    def __init__(self, rng, inputs, constants):
        self.rng, self.known, self.loose = rng, list(inputs), list(inputs)
        self.constants = [Bounded(x, abs(x)) for x in constants]
        self.odds = rng.choice(([8, 2, 1, 0, 1], [1, 8, 2, 0, 1], [2, 4, 2, 4, 1]))

    def add(self, x, most):
        self.known.append(Bounded(x, most))
        self.loose.append(self.known[-1])

    def pick(self):
        kinds = self.known[-1:], self.loose or self.known, self.known, self.known[:4], self.constants
        drawn = self.rng.choice(self.rng.choices(kinds, self.odds)[0])
        self.loose = [value for value in self.loose if value is not drawn]
        return drawn


def _wild_step(op, pool):
    """Any operation on any operands; what Python's floats refuse is left out, for constants fold before they run."""
    try:
        value = UNARY[op](pool.pick().x) if op in UNARY else BINARY[op](pool.pick().x, pool.pick().x)
    except (ArithmeticError, ValueError):
        return
    if isinstance(value, Traced) or math.isfinite(value):
        pool.add(value, math.inf)


def _tame_step(op, pool):
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


def seeded(seed, operations, tame):
    """The random program of a seed."""
    return random_program(random.Random(seed), operations, tame)
