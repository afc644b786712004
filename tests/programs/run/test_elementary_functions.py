"""Sine, cosine, exponential, sign, root and quotient of the compiled executor, in units in the last place (ulp)."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from helpers.compiled_programs import bits, compiled, needs_compiler

from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.vectors import cos, exp, sign, sin

pytestmark = needs_compiler

ULPS = 0.9
"""More than any error among 10^8 arguments, and in single precision among all."""
LIMIT = 2.0**20 * np.pi / 2
"""The largest angle that the executor reduces itself."""
MULTIPLES = np.arange(1, 2**20, 7)
TINY = np.concatenate((5e-324 * 2.0 ** np.arange(52), 2.0 ** np.arange(-1022.0, 0.0, 7.0), [3e-308, 1e-310, 7e-320]))
REFERENCES = {sin: np.sin, cos: np.cos, exp: np.exp}

extended = pytest.mark.skipif(np.finfo(np.longdouble).nmant < 63, reason="long double has no more digits than double")


@cache
def ready(*functions, dtype=np.float64):
    return compiled(lambda x: [function(x) for function in functions], dtype=dtype)


def values(functions, x, dtype=np.float64):
    """A column for each function of the numbers x."""
    x = np.asarray(x, dtype)
    return ready(*functions, dtype=dtype)({"x": x[:, None]}, len(x))


def ulps(found, exact):
    """|found - exact| in ulp of the rounded exact value."""
    return np.abs(found - exact) / np.spacing(np.abs(exact.astype(found.dtype)))


def worst(functions, x, dtype=np.float64):
    """The largest error of each function, by a type with more digits than `dtype`."""
    x = np.asarray(x, dtype)
    wide = x.astype(np.longdouble if dtype is np.float64 else np.float64)
    columns = values(functions, x, dtype).T
    return [ulps(found, REFERENCES[f](wide)).max() for f, found in zip(functions, columns, strict=True)]


@cache
def beside_multiples(dtype=np.float64):
    """Numbers next to multiples of pi/2 up to the limit, hard to reduce."""
    nearest = (MULTIPLES * (np.longdouble(np.pi / 2) + np.longdouble(6.123233995736766e-17))).astype(dtype)
    return np.concatenate((nearest, -nearest, np.nextafter(nearest, dtype(0)), np.nextafter(nearest, dtype(np.inf))))


def angles(rng, count):
    """Angles of every size up to the limit, and close to multiples of pi/2."""
    part = count // 4
    close = rng.integers(-(2**19), 2**19, part) * (np.pi / 2)
    return np.concatenate(
        (
            rng.uniform(-np.pi, np.pi, part),
            rng.uniform(-1e6, 1e6, part),
            rng.choice([-1.0, 1.0], part) * 10.0 ** rng.uniform(-12.0, 6.0, part),
            close * (1.0 + rng.normal(size=part) * 10.0 ** rng.uniform(-17.0, -4.0, part)),
        )
    )


ANGLES = {
    "of every size": lambda: angles(np.random.default_rng(1), 40_000),
    "next to multiples of a quarter turn": beside_multiples,
    "powers of two": lambda: np.concatenate((2.0 ** np.arange(-1074.0, 21.0), -(2.0 ** np.arange(-1074.0, 21.0)))),
    "tiny and zero": lambda: np.concatenate((TINY, -TINY, [0.0, -0.0])),
    "the ends of eighths": lambda: np.nextafter(MULTIPLES * (np.pi / 4), np.inf),
}


@extended
@pytest.mark.parametrize("kind", ANGLES)
def test_sine_and_cosine(kind, monkeypatch):
    monkeypatch.setattr(CompiledBlocks, "_fallback", None)
    assert max(worst((sin, cos), ANGLES[kind]())) <= ULPS


@extended
def test_exponential():
    rng = np.random.default_rng(2)
    around = np.arange(-1074, 1024) * np.log(2.0)
    for x in (
        rng.uniform(-745.0, 709.7, 100_000),
        rng.uniform(-1.0, 1.0, 50_000),
        rng.uniform(-745.1, -708.0, 20_000),
        np.concatenate((around, around + 0.5 * np.log(2.0), np.nextafter(around, np.inf))),
        np.concatenate((TINY, -TINY, [0.0, -0.0, 709.782712893384, -745.1332191019411])),
    ):
        assert worst((exp,), x)[0] <= ULPS


def test_exponential_out_of_range():
    x = [709.7827128933841, 710.0, 711.0, 1e300, np.inf, -745.1332191019412, -746.0, -747.5, -1e300, -np.inf, np.nan]
    np.testing.assert_array_equal(values((exp,), x)[:, 0], [np.inf] * 5 + [0.0] * 5 + [np.nan])
    assert values((exp,), [-745.1332191019411])[0, 0] == 5e-324
    x = [88.72284, 89.0, 1e30, np.inf, -103.98, -200.0, -np.inf, np.nan]
    np.testing.assert_array_equal(values((exp,), x, np.float32)[:, 0], [np.inf] * 4 + [0.0] * 3 + [np.nan])


def test_single_precision():
    rng = np.random.default_rng(4)
    for x in (angles(rng, 100_000), beside_multiples(np.float32), rng.uniform(-2e-38, 2e-38, 10_000), [0.0, -0.0]):
        assert max(worst((sin, cos), x, np.float32)) <= ULPS
    for x in (rng.uniform(-103.9, 88.72, 100_000), rng.uniform(-103.9, -87.0, 10_000), [0.0, -0.0, 1e-45]):
        assert worst((exp,), x, np.float32)[0] <= 0.5 + 1e-6


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_large_angles_are_numpys_and_neighbours_as_ever(dtype):
    """Sample by sample: in every place of a vector, in the last incomplete one, and next to each other."""
    rng = np.random.default_rng(5)
    beyond = dtype(LIMIT * (1 + 1e-6))
    large = np.array([beyond, -beyond, 2e6, -1e9, 1e15, 1e30, -1e38, np.inf, -np.inf, np.nan], dtype)
    x = rng.uniform(-100.0, 100.0, (1003, 2)).astype(dtype)
    there = rng.random(1003) < 0.1
    there[[0, 8, 9, 10, 11, 17, 26, 35, 44, 53, 62, 71, 1000, 1002]] = True
    mixed = x.copy()
    mixed[there, rng.integers(0, 2, there.sum())] = rng.choice(large, there.sum())

    def function(x, y):
        return [sin(x), cos(x), sin(x) * y + cos(y), y]

    run = compiled(function, 2, dtype)
    found = run({"x": mixed}, len(x))
    np.testing.assert_array_equal(
        found[there], NumpyBlocks(run.program, {"x": 2}, dtype)({"x": mixed[there]}, there.sum())
    )
    np.testing.assert_array_equal(bits(found[~there]), bits(run({"x": x}, len(x))[~there]))


@extended
def test_many_angles_at_the_limit_together(monkeypatch):
    """The root of the sum of their squares counts."""
    run = compiled(lambda x, y: [sin(x), sin(y)], 2)
    directions = np.random.default_rng(8).normal(size=(500, 2))
    edge = directions / np.hypot(*directions.T)[:, None] * LIMIT
    beyond, within = edge * (1 + 1e-5), edge * (1 - 1e-5)
    np.testing.assert_array_equal(run({"x": beyond}, 500), NumpyBlocks(run.program, {"x": 2})({"x": beyond}, 500))
    monkeypatch.setattr(CompiledBlocks, "_fallback", None)
    assert ulps(run({"x": within}, 500), np.sin(within.astype(np.longdouble))).max() <= ULPS


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_sign(dtype):
    info = np.finfo(dtype)
    x = np.array([info.smallest_subnormal, info.max, np.inf, 0.0, np.nan, 1.0, info.tiny], dtype)
    for sided in (x, -x):
        np.testing.assert_array_equal(values((sign,), sided, dtype)[:, 0], np.sign(sided))


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_root_and_quotient_are_rounded_once(dtype):
    rng = np.random.default_rng(7)
    pairs = rng.integers(0, 2 ** (8 * np.dtype(dtype).itemsize), (20_000, 2), dtype=f"u{np.dtype(dtype).itemsize}")
    x = pairs.view(dtype)
    found = compiled(lambda x, y: [x.sqrt(), x / y], 2, dtype)({"x": x}, len(x))
    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(found, np.column_stack((np.sqrt(x[:, 0]), x[:, 0] / x[:, 1])))
