"""The bound that executors are held to: its terms by hand, how nearly it is reached, and where it gives up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.oracles import EPS
from helpers.random_programs import BINARY
from helpers.rounding_bounds import bounds
from mpmath import ldexp

from robodyn.programs.program import trace
from robodyn.programs.run.numpy_blocks import NumpyBlocks
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
