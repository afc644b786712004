"""Executors with many digits: as many as asked, exact inputs, no exceptions; pairs of floats against them."""

from __future__ import annotations

import math
import sys
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from helpers.oracles import EPS, golden_model, reference, worst
from helpers.robot_files import FOLDER

from robodyn.dynamics.plan import Plan, plan
from robodyn.errors import InputError
from robodyn.programs.program import trace
from robodyn.programs.run import double_double as dd
from robodyn.programs.run.double_double import Pair, double_double
from robodyn.programs.run.multiprecision import Multiprecision
from robodyn.programs.vectors import cos, exp, sin
from robodyn.robot.load import load
from robodyn.scene.scene import DEFAULT, Scene

MODELS = reference("golden_inverse_dynamics")["models"]
INF, NAN = math.inf, math.nan
WIDE = mpmath.MPContext()
WIDE.dps = 300


def values(function, *inputs, digits=50):
    """What a function of scalars gives for one sample."""
    program = trace(lambda tape: function(*(tape.input("x", i) for i in range(len(inputs)))))
    return Multiprecision(program, digits=digits)({"x": [inputs]}, 1)[0]


def error(found, expected):
    """|found - expected| with 300 digits."""
    if isinstance(expected, Fraction):
        expected = WIDE.mpf(expected.numerator) / expected.denominator
    return abs(WIDE.convert(found) - expected)


def last_digit(digits):
    return WIDE.mpf(10) ** (1 - digits)


@pytest.mark.parametrize("name", [*MODELS][::4])
def test_golden_torques(name):
    """The description is read in doubles, which leaves a rounding or two of the largest torque."""
    for case in MODELS[name]["cases"]:
        program = Plan(golden_model(name), Scene(gravity=tuple(case["gravity"]))).torques()
        state, largest = {key: [case[key]] for key in ("q", "qd", "qdd")}, max(np.abs(case["tau"]).max(), 1e-3)
        few, many = (Multiprecision(program, digits=digits)(state, 1)[0] for digits in (30, 50))
        assert worst(many, case["tau"], largest) <= 4 * EPS
        assert max(map(error, few, many)) <= 10 * last_digit(30) * largest


CORNERS = {
    "a division by zero": (lambda x, y: [x / y], [((1, 0), INF), ((-2, 0), -INF), ((0, 0), NAN), ((NAN, 0), NAN)]),
    "a zero without a sign": (lambda x, y: [x / y], [((1, -0.0), INF), ((INF, 0), INF), ((3, -INF), 0)]),
    "infinite operands": (lambda x, y: [x * y], [((INF, 0), NAN), ((INF, -2), -INF), ((NAN, 0), NAN)]),
    "a difference": (lambda x, y: [x - y], [((INF, INF), NAN), ((1, INF), -INF), ((1, NAN), NAN)]),
    "a square root": (lambda x: [x.sqrt()], [((-1,), NAN), ((-INF,), NAN), ((INF,), INF), ((-0.0,), 0), ((NAN,), NAN)]),
    "a sine": (lambda x: [sin(x)], [((INF,), NAN), ((-INF,), NAN), ((NAN,), NAN)]),
    "a cosine": (lambda x: [cos(x)], [((INF,), NAN), ((NAN,), NAN), ((0,), 1)]),
    "an exponential": (lambda x: [exp(x)], [((INF,), INF), ((-INF,), 0), ((NAN,), NAN), ((0,), 1)]),
    "a sign": (lambda x: [x.sign()], [((5e-324,), 1), ((-INF,), -1), ((-0.0,), 0), ((NAN,), NAN)]),
    "a negative": (lambda x: [-x], [((INF,), -INF), ((NAN,), NAN)]),
}


@pytest.mark.parametrize("corner", CORNERS)
def test_where_a_real_number_has_no_answer(corner):
    function, cases = CORNERS[corner]
    for inputs, expected in cases:
        found = values(function, *map(float, inputs))[0]
        assert type(found).__name__ == "mpf"
        np.testing.assert_equal(float(found), float(expected))


def test_beyond_the_range_of_doubles():
    """Nothing overflows but functions of what a double could not hold."""
    found = values(lambda x: [exp(x * 1000.0) / exp(x * 999.0), (x * 1e-300) * 1e-300], 1.0)
    assert error(found[0], WIDE.exp(1)) <= 9 * last_digit(50)
    assert error(found[1], Fraction(1e-300) ** 2) == 0 < found[1]
    far = values(lambda x: [sin(x * x), cos(-x * x), exp(x * x), exp(-x * x), exp(exp(x)), sin(x)], 1e200)
    np.testing.assert_equal([float(x) for x in far[:5]], [NAN, NAN, INF, 0.0, INF])
    assert 0 < abs(far[5]) < 1


def test_inputs_are_exact():
    """Doubles, single-precision numbers, integers and numbers with more digits than the run works with."""
    third = WIDE.mpf(1) / 3
    program = trace(lambda tape: [tape.input("x", 0), tape.input("x", 0) - 0.25])
    rows = np.array([[0.1], [np.float32(0.1)], [7], [third]], dtype=object)
    found = Multiprecision(program, digits=40)({"x": rows}, 4)
    assert [error(a, b) for a, b in zip(found[:, 0], [0.1, float(np.float32(0.1)), 7, third], strict=True)] == [0] * 4
    assert 0 < error(found[3, 1], Fraction(1, 12)) <= last_digit(40)
    single = Multiprecision(program)({"x": np.array([[0.1]], dtype=np.float32)}, 1)
    assert float(single[0, 0]) == float(np.float32(0.1))


def test_mpmath_keeps_its_own_precision():
    before = mpmath.mp.dps
    with mpmath.workdps(5):
        third = values(lambda x: [x / 3.0], 1.0)[0]
        assert mpmath.mp.dps == 5
    assert mpmath.mp.dps == before
    assert error(third, Fraction(1, 3)) <= last_digit(50)
    assert error(third * 3, 1) <= last_digit(49)


def test_without_mpmath_or_digits(monkeypatch):
    program = trace(lambda tape: [tape.input("x", 0)])
    assert Multiprecision(program)({"x": np.empty((0, 2))}, 0).shape == (0, 1)
    with pytest.raises(InputError, match=r"^0 digits hold no number"):
        Multiprecision(program, digits=0)
    monkeypatch.setitem(sys.modules, "mpmath", None)
    with pytest.raises(InputError, match=r'need mpmath \(pip install "robodyn\[exact\]"\)$'):
        Multiprecision(program)


DIGITS = 60
RNG = np.random.default_rng(4)


def pairs(count=200, size=1.0):
    high = size * RNG.uniform(-1, 1, count)
    return Pair(high, RNG.uniform(-0.5, 0.5, count) * np.spacing(high))


def exact(pair):
    with mpmath.workdps(DIGITS):
        return [mpmath.mpf(h) + mpmath.mpf(l) for h, l in zip(*map(np.atleast_1d, pair), strict=True)]


def relative(found, expected):
    with mpmath.workdps(DIGITS):
        off = [abs(a - b) / abs(b) for a, b in zip(exact(found), expected, strict=True)]
    return float(max(off))


@pytest.mark.parametrize("name", ["add", "sub", "mul", "div"])
def test_arithmetic(name):
    a, b = pairs(), pairs(size=3.0)
    with mpmath.workdps(DIGITS):
        expected = [getattr(mpmath, f"f{name}")(x, y) for x, y in zip(exact(a), exact(b), strict=True)]
    bound = 2.0**-101  # 1e-30: sums of opposite signs lose some bits of the low parts
    assert relative(dd._FUNCTIONS[name](a, b), expected) <= bound


@pytest.mark.parametrize(("name", "size"), [("sin", 1.0), ("sin", 1e6), ("cos", 20.0), ("exp", 30.0), ("sqrt", 1e3)])
def test_functions(name, size):
    a = pairs(size=size)
    a = Pair(*(np.abs(x) for x in a)) if name == "sqrt" else a
    with mpmath.workdps(DIGITS):
        expected = list(map(getattr(mpmath, name), exact(a)))
    # Of large angles the rounding of the angle itself in 106 bits counts.
    assert relative(dd._FUNCTIONS[name](a), expected) <= 1e-30 * max(1.0, size)


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
