"""Pairs of floats against many digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from helpers.robot_files import FOLDER

from robodyn.dynamics.plan import plan
from robodyn.programs.run import double_double as dd
from robodyn.programs.run.double_double import Pair, double_double
from robodyn.programs.run.multiprecision import Multiprecision
from robodyn.robot.load import load
from robodyn.scene.scene import DEFAULT

DIGITS = 60
RNG = np.random.default_rng(4)


def pairs(count=200, size=1.0):
    high = size * RNG.uniform(-1, 1, count)
    return Pair(high, RNG.uniform(-0.5, 0.5, count) * np.spacing(high))


def exact(pair):
    with mpmath.workdps(DIGITS):
        return [mpmath.mpf(h) + mpmath.mpf(l) for h, l in zip(*map(np.atleast_1d, pair), strict=True)]


def worst(found, expected):
    with mpmath.workdps(DIGITS):
        off = [abs(a - b) / abs(b) for a, b in zip(exact(found), expected, strict=True)]
    return float(max(off))


@pytest.mark.parametrize("name", ["add", "sub", "mul", "div"])
def test_arithmetic(name):
    a, b = pairs(), pairs(size=3.0)
    with mpmath.workdps(DIGITS):
        expected = [getattr(mpmath, f"f{name}")(x, y) for x, y in zip(exact(a), exact(b), strict=True)]
    bound = 2.0**-101  # 1e-30: sums of opposite signs lose some bits of the low parts
    assert worst(dd._FUNCTIONS[name](a, b), expected) <= bound


@pytest.mark.parametrize(("name", "size"), [("sin", 1.0), ("sin", 1e6), ("cos", 20.0), ("exp", 30.0), ("sqrt", 1e3)])
def test_functions(name, size):
    a = pairs(size=size)
    a = Pair(*(np.abs(x) for x in a)) if name == "sqrt" else a
    with mpmath.workdps(DIGITS):
        expected = list(map(getattr(mpmath, name), exact(a)))
    # Of large angles the rounding of the angle itself in 106 bits counts.
    assert worst(dd._FUNCTIONS[name](a), expected) <= 1e-30 * max(1.0, size)


def test_where_there_is_no_number():
    assert dd.root(Pair(np.zeros(1), np.zeros(1))).high == 0.0
    with np.errstate(all="ignore"):
        nothing = Pair(np.zeros(1), np.zeros(1))
        assert dd.divided(Pair(np.ones(1), np.zeros(1)), nothing).high == np.inf
        assert np.isnan(dd.divided(nothing, nothing).high)
        assert np.isnan(dd.root(Pair(-np.ones(1), np.zeros(1))).high)


def test_torques():
    model = load(FOLDER / "puma560.urdf")
    program = plan(model, DEFAULT).torques()
    samples = dd.BLOCK + 3
    sources = {name: RNG.uniform(-2, 2, (samples, model.n)) for name in ("q", "qd", "qdd")}
    found = double_double(program, sources, samples)
    rows = [0, 7, dd.BLOCK - 1, dd.BLOCK, samples - 1]
    expected = Multiprecision(program, digits=DIGITS)({name: x[rows] for name, x in sources.items()}, len(rows))
    off = abs((expected - found.high[rows].astype(object)) - found.low[rows].astype(object))
    assert float(off.max()) <= 1e-29 * float(abs(expected).max())
