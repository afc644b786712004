"""The bound that executors are held to: its terms by hand, how nearly it is reached, and where it gives up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.oracles import EPS
from helpers.random_programs import BINARY, random_inputs, seeded
from helpers.rounding_bounds import bounds
from mpmath import ldexp

from robodyn.programs.program import trace
from robodyn.programs.run.numpy_blocks import UFUNCS, NumpyBlocks
from robodyn.programs.scalar import CONSTANT, COS, EXP, INPUT, SIN
from robodyn.programs.vectors import cos, exp, sign, sin

U = EPS / 2
INF, NAN = math.inf, math.nan


def program_of(function):
    """The program of a function of x, y and z."""
    return trace(lambda tape: [function(*(tape.input("x", i) for i in range(3)))])


def bounded(function, *inputs, dtype=np.float64):
    """The exact value and the error bound of a function of x, y and z."""
    rows = np.zeros((1, 3))
    rows[0, : len(inputs)] = inputs
    result = bounds(program_of(function), {"x": rows}, 1, dtype)
    return result.exact[0, 0], result.error[0, 0]


TERMS = {
    "x": (lambda x, y, z: x, lambda x, y, z: 0.0),
    "-x": (lambda x, y, z: -x, lambda x, y, z: 0.0),
    "x + y": (lambda x, y, z: x + y, lambda x, y, z: abs(x + y)),
    "x * y": (lambda x, y, z: x * y, lambda x, y, z: abs(x * y)),
    "x / y": (lambda x, y, z: x / y, lambda x, y, z: abs(x / y)),
    "(x + y) - z": (lambda x, y, z: (x + y) - z, lambda x, y, z: abs(x + y) + abs(x + y - z)),
    "(x + y) (y - z)": (lambda x, y, z: (x + y) * (y - z), lambda x, y, z: 3 * abs((x + y) * (y - z))),
    "(x + y) / (y - z)": (lambda x, y, z: (x + y) / (y - z), lambda x, y, z: 3 * abs((x + y) / (y - z))),
    "root": (lambda x, y, z: (x * x + y).sqrt(), lambda x, y, z: (x * x / (x * x + y) / 2 + 1.5) * (x * x + y) ** 0.5),
    "sine": (lambda x, y, z: sin(x * y), lambda x, y, z: abs(x * y) + 2 * abs(math.sin(x * y))),
    "cosine": (lambda x, y, z: cos(x + y), lambda x, y, z: abs(x + y) + 2 * abs(math.cos(x + y))),
    "exponential": (lambda x, y, z: exp(x * y), lambda x, y, z: (abs(x * y) + 2) * math.exp(x * y)),
    "sign": (lambda x, y, z: sign(x + y), lambda x, y, z: 0.0),
}


@pytest.mark.parametrize("name", TERMS)
def test_first_order(name):
    function, units = TERMS[name]
    inputs = (-1.75, 3.2, 0.6)
    error = bounded(function, *inputs)[1]
    assert abs(error / U - units(*inputs)) <= 1e-12 * units(*inputs)


HALF = 2.0**-11
ALL_ORDERS = {
    "product": (lambda x, y, z: (x + y) * (y - z), (1 + HALF) ** 3),
    "quotient": (lambda x, y, z: (x + y) / (y - z), (1 + HALF) ** 2 / (1 - HALF)),
    "root": (lambda x, y, z: (x + y).sqrt(), (1 + HALF) * (2 - math.sqrt(1 - HALF))),
    "exponential": (lambda x, y, z: exp(x + y), (1 + 2 * HALF) * math.exp(1.5 * HALF)),
}


@pytest.mark.parametrize("name", ALL_ORDERS)
def test_worst_case_in_half_precision(name):
    """Where u is 2^-11, terms of second order are seen; the factor is that of the worst roundings."""
    function, factor = ALL_ORDERS[name]
    exact, error = bounded(function, -1.75, 3.25, 0.625, dtype=np.float16)
    assert abs(error / abs(exact) - (factor - 1)) <= 1e-12


UNKNOWN = {
    "a sign that rounding decides": (lambda x, y, z: sign(x + y - z), (0.1, 0.2, 0.3), 2),
    "a root that rounding makes negative": (lambda x, y, z: (x + y - z).sqrt(), (0.1, 0.2, 0.3), INF),
    "a quotient by what rounding makes zero": (lambda x, y, z: x / (x + y - z), (0.1, 0.2, 0.3), INF),
    "a sine of anything": (lambda x, y, z: sin((x + y) * z), (1.0, 1.0, 1e17), 2),
    "an infinity of unknown sign": (lambda x, y, z: x / y, (1.0, 0.0), INF),
    "what may overflow": (lambda x, y, z: x * y, (1.7e308, 1.1), INF),
    "what an infinity of unknown sign makes": (lambda x, y, z: exp(x / y), (1.0, 0.0), INF),
}


@pytest.mark.parametrize("name", UNKNOWN)
def test_what_cannot_be_told(name):
    function, inputs, expected = UNKNOWN[name]
    error = bounded(function, *inputs)[1]
    assert error == INF if expected == INF else expected <= error <= expected * (1 + 1e-15)


CERTAIN = {
    "nan in, nan out": (lambda x, y, z: sign(x * y + z), (NAN, 1.0, 2.0), NAN),
    "nan and what rounding decides": (lambda x, y, z: x * (y + z - 0.3), (NAN, 0.1, 0.2), NAN),
    "0 / 0": (lambda x, y, z: x / y, (0.0, 0.0), NAN),
    "a difference of infinities": (lambda x, y, z: x - y, (INF, INF), NAN),
    "infinity times zero": (lambda x, y, z: x * y, (INF, 0.0), NAN),
    "infinity times a rounded sum": (lambda x, y, z: x * (y + z), (INF, 0.1, -0.3), -INF),
    "a number over infinity": (lambda x, y, z: (y + z) / x, (INF, 0.1, 0.3), 0.0),
    "a root of a negative sum": (lambda x, y, z: (x + y).sqrt(), (-0.1, -0.2), NAN),
    "an exponential of minus infinity": (lambda x, y, z: exp(-x), (INF,), 0.0),
    "a product with an exact zero": (lambda x, y, z: x * (y + z), (0.0, 0.1, 0.2), 0.0),
}


@pytest.mark.parametrize("name", CERTAIN)
def test_what_is_certain(name):
    function, inputs, expected = CERTAIN[name]
    exact, error = bounded(function, *inputs)
    np.testing.assert_equal(float(exact), expected)
    assert error == 0


@pytest.mark.parametrize("op", sorted(BINARY))
def test_one_rounding_is_nearly_the_bound(op):
    rows = np.random.default_rng(2).uniform(1.0, 2.0, (300, 3)) * [1.0, 0.1, 0.0]
    program = program_of(lambda x, y, z: BINARY[op](x, y))
    limits = bounds(program, {"x": rows}, 300)
    found = NumpyBlocks(program, {"x": 3})({"x": rows}, 300)
    assert 0.8 <= (abs(found - limits.exact) / limits.error).max() <= 1
    assert not limits.broken(found)
    assert limits.broken(found * (1 + 2 * EPS))


def test_small_numbers():
    """A result without all its bits is off by half of the smallest number rather than by a part of itself."""
    error = bounded(lambda x, y, z: x * y, 1.23e-200, 1.7e-120)[1]
    assert 0 <= error / ldexp(1, -1075) - 1 <= 1e-9


def test_what_is_reported():
    program = program_of(lambda x, y, z: x / y)
    limits = bounds(program, {"x": np.array([[1.0, 10.0, 0.0], [0.0, 0.0, 0.0], [INF, 1.0, 0.0], [1.0, 0.0, 0.0]])}, 4)
    assert not limits.broken([[0.1], [NAN], [INF], [-INF], [0.1]])
    wrong = limits.broken([[np.nextafter(0.1, 1.0)], [0.0], [-INF], [NAN], [NAN], [NAN], [1e308]])
    assert [(sample, output) for sample, output, *_ in wrong] == [(0, 0), (1, 0), (2, 0), (4, 0), (6, 0)]
    assert limits.known[:, 0].tolist() == [True, True, True, False]


def in_single_precision(program, sources):
    """The outputs in float32; elementary functions are rounded from float64."""
    values = []
    with np.errstate(all="ignore"):
        for op, a, b in program.operations:
            if op in (INPUT, CONSTANT):
                values.append((sources[a][:, b] if op is INPUT else np.full(len(sources["q"]), a)).astype(np.float32))
                continue
            operands = [values[k] for k in (a, b) if k is not None]
            if op in (SIN, COS, EXP):
                operands = [x.astype(float) for x in operands]
            values.append(UFUNCS[op](*operands).astype(np.float32))
    return np.array([values[k] for k in program.outputs]).T


@pytest.mark.parametrize("tame", [True, False], ids=["tame", "wild"])
def test_single_precision(tame):
    finer = 0
    for seed in range(60):
        program, widths = seeded(seed, 30, tame)
        sources = random_inputs(seed, widths, 4, tame)
        found = in_single_precision(program, sources)
        assert not bounds(program, sources, 4, np.float32).broken(found)
        finer += bool(bounds(program, sources, 4).broken(found))
    assert finer >= 30
