"""Differentiation: stencils against published figures and SciPy, any spacing, wraps, too few samples."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.signal import savgol_filter

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.derivatives.differentiate import (
    CENTRAL,
    SPLINE,
    Method,
    at_samples,
    differentiate,
    equal_spacing,
    savgol,
)
from robodyn.trajectory.read import from_arrays
from robodyn.trajectory.reading import Reading

Array = NDArray[np.float64]
EPS = np.finfo(np.float64).eps
ONE = Signals((Signal("a", "angle"),))
# Savitzky-Golay gains h^d g of (window, order): first and second derivative, from an independent computation
GAINS = [
    (5, 2, 0.316227766016838, 0.5345224838248488),
    (31, 2, 0.020080483222562468, 0.005027983176637701),
    (7, 3, 0.5124120778886243, 0.21821789023599236),
    (7, 4, 0.512412077888625, 0.9259175083792464),
    (11, 4, 0.24572227285990014, 0.25566616977064077),
    (21, 4, 0.09082129160607218, 0.04755676543304457),
    (31, 4, 0.050385497342498024, 0.017737251517763918),
    (51, 4, 0.023814670987684007, 0.0050755557263954055),
    (101, 4, 0.00853530318040051, 0.0009169737873827382),
    (31, 5, 0.08869097998378894, 0.017737251517763935),
]


@pytest.mark.parametrize(("window", "order", "first", "second"), GAINS)
def test_gains_of_savitzky_golay(window: int, order: int, first: float, second: float) -> None:
    found = Method("savgol", window, order).gains
    np.testing.assert_allclose(found[:, -1], (first, second), rtol=1e-9)


def test_gains_of_the_spline() -> None:
    """Response of SciPy's spline to one wrong sample in the middle of many."""
    impulse = np.zeros(301)
    impulse[150] = 1.0
    curve = make_interp_spline(np.arange(301.0), impulse, k=5)
    expected = [np.linalg.norm(curve(np.arange(301.0), order)) for order in (1, 2)]
    np.testing.assert_allclose(SPLINE.gains[:, -1], expected, rtol=1e-13)


def sine(time: Array) -> tuple[Array, Array, Array]:
    angle = 2 * np.pi * time
    return np.sin(angle), 2 * np.pi * np.cos(angle), -4 * np.pi**2 * np.sin(angle)


@pytest.mark.parametrize(
    ("spacing", "method", "published"),
    [
        (0.01, SPLINE, 8.552970172104324e-07),
        (0.01, CENTRAL, 0.012986169788611335),
        (0.001, CENTRAL, 0.00012987847707535),
    ],
)
def test_clean_sine_errs_as_published(spacing: float, method: Method, published: float) -> None:
    time = np.arange(0.0, 2.0, spacing)
    q, _, qdd = sine(time)
    error = np.abs(differentiate(time, q[:, None], method)[1][:, 0] - qdd)[20:-20].max()
    assert 0.99 * published < error < 1.01 * published


@pytest.mark.parametrize("count", [6, 7, 20, 97, 200, 1000])
@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_spline_is_that_of_scipy(count: int, jitter: float) -> None:
    rng = np.random.default_rng(count)
    time = (np.arange(count) + rng.uniform(-jitter, jitter, count)) * 0.01
    values = np.column_stack((np.sin(9 * time), np.cos(5 * time)))
    curve = make_interp_spline(time, values, k=5)
    first, second = differentiate(time, values, SPLINE)
    assert np.abs(first - curve(time, 1)).max() <= 2e4 * EPS * np.abs(values).max() / 0.01
    assert np.abs(second - curve(time, 2)).max() <= 2e4 * EPS * np.abs(values).max() / 0.01**2


@pytest.mark.parametrize("window", [7, 31, 101])
def test_savitzky_golay_is_that_of_scipy(window: int) -> None:
    values = np.random.default_rng(1).normal(size=300)
    found = differentiate(np.arange(300) * 0.5, values[:, None], savgol(window))
    for order, derivative in enumerate(found, start=1):
        expected = savgol_filter(values, window, 4, deriv=order, delta=0.5, mode="interp")
        assert np.abs(derivative[:, 0] - expected).max() <= 1e-10 * np.abs(expected).max()  # SciPy's own rounding


def least_squares(time: Array, values: Array, row: int, order: int) -> tuple[float, float]:
    """Derivatives at a row of the polynomial fitted to all, by rational arithmetic."""
    u = [Fraction(t) - Fraction(time[row]) for t in time.tolist()]
    rows = [[sum(x ** (i + j) for x in u) for j in range(order + 1)] for i in range(order + 1)]
    for i, equation in enumerate(rows):
        equation.append(sum(Fraction(y) * x**i for x, y in zip(u, values.tolist(), strict=True)))
    for i, pivot in enumerate(rows):
        for other in rows[:i] + rows[i + 1 :]:
            factor = other[i] / pivot[i]
            other[:] = [x - factor * y for x, y in zip(other, pivot, strict=True)]
    return float(rows[1][-1] / rows[1][1]), float(2 * rows[2][-1] / rows[2][2])


@pytest.mark.parametrize("far", [0.0, 1e3])
def test_local_polynomials_are_those_of_rational_arithmetic(far: float) -> None:
    """In the middle and at the ends; normal equations would miss the second derivative at an end by 1e-7."""
    time = np.sort(np.random.default_rng(2).uniform(0.0, 2.0, 60))
    values = far + np.sin(3 * time)
    first, second = (rate[:, 0] for rate in differentiate(time, values[:, None], savgol(7)))
    for row, start in ((0, 0), (1, 0), (30, 27), (58, 53), (59, 53)):
        part = slice(start, start + 7)
        expected = least_squares(time[part], values[part], row - start, 4)
        assert abs(first[row] - expected[0]) <= 1e-11 * np.abs(first).max()
        assert abs(second[row] - expected[1]) <= 1e-11 * np.abs(second).max()


def test_a_local_polynomial_depends_on_its_own_window_alone() -> None:
    """To the bit: whichever rows it is asked for together with, and however far the joint has turned before."""
    rng = np.random.default_rng(8)
    time = np.cumsum(rng.uniform(0.5, 1.5, 400))
    values, turns = rng.normal(size=(400, 2)), np.cumsum(rng.integers(-1, 2, (400, 2)), axis=0).astype(float)
    everywhere = at_samples(time, values, turns, np.arange(400), 7, 4)
    for rows in (np.array([60, 61]), np.array([200, 77, 200]), np.arange(100, 377)):
        alone = at_samples(time[50:], values[50:], turns[50:] - 9.0, rows - 50, 7, 4)
        for one, all_ in zip(alone, everywhere, strict=True):
            np.testing.assert_array_equal(one, all_[rows])


@pytest.mark.parametrize("offset", [0.0, 1e3, -7.0])
@pytest.mark.parametrize("step", [1e-3, 1 / 1024, 0.1, 3.0])
def test_equal_spacing_survives_rounding(offset: float, step: float) -> None:
    time = offset + np.arange(1000) * step
    assert equal_spacing(time) == pytest.approx(step, rel=1e-9)
    time[500] += 1e-4 * step
    assert equal_spacing(time) == 0.0


@pytest.mark.parametrize("count", [3, 4, 5, 6, 7, 20])
@pytest.mark.parametrize("mode", ["auto", "spline", "savgol", "central"])
def test_few_samples(count: int, mode: str) -> None:
    """A parabola is exact however few samples there are."""
    time = np.array([0.0, 0.1, 0.3, 0.35, 0.5, 0.7, 1.0, *np.arange(1.2, 10.0, 0.25)])[:count]
    result = from_arrays(ONE, time, (3 * time**2 - time)[:, None], reading=Reading(mode))  # type: ignore[arg-type]
    assert np.abs(result.qdd - 6.0).max() < 1e-9
    assert np.abs(result.qd[:, 0] - (6 * time - 1)).max() < 1e-10


def test_turns_of_a_continuous_joint() -> None:
    time = np.arange(2000) / 1000
    angle = 9.0 * time + 0.5 * np.sin(2 * np.pi * time)
    wrapped = (angle + np.pi) % (2 * np.pi) - np.pi
    turning = from_arrays(Signals((Signal("a", "continuous"),)), time, wrapped[:, None])
    straight = from_arrays(Signals((Signal("a", "continuous"),)), time, angle[:, None])
    np.testing.assert_array_equal(turning.q[:, 0], wrapped)
    assert np.abs(turning.qdd - straight.qdd).max() < 1e-7
    assert turning.derivation is not None
    assert turning.derivation.acceleration == "quintic spline"
    fixed = from_arrays(ONE, time, wrapped[:, None], reading=Reading("spline"))
    assert np.abs(fixed.qdd).max() > 6e6


def test_given_velocity_is_differentiated_once() -> None:
    time = np.arange(400) * 0.01
    q, qd, qdd = sine(time)
    result = from_arrays(ONE, time, 0.0 * q[:, None], qd[:, None])
    assert result.derivation is not None
    (joint,) = result.derivation.joints
    assert (joint.source, joint.velocity, joint.acceleration) == ("qd", "given", "quintic spline")
    np.testing.assert_array_equal(result.qd[:, 0], qd)
    assert np.abs(result.qdd[:, 0] - qdd)[20:-20].max() < 1e-6


def test_stamps_too_close_to_differentiate() -> None:
    time = np.array([0.0, 1e-200, 2e-200, 3e-200])
    with pytest.raises(TrajectoryError, match="the derivative is not finite"):
        from_arrays(ONE, time, np.array([[0.0], [1.0], [0.0], [1.0]]))


def test_a_pause_longer_than_the_window() -> None:
    time = np.concatenate((np.arange(1000) / 1000, 100 + np.arange(1000) / 1000))
    q = np.round(np.sin(time), 5)
    with pytest.raises(TrajectoryError, match=r"row 1001: a pause of 99\.001 s is longer than the window"):
        from_arrays(ONE, time, q[:, None])
    for mode in ("central", "spline"):
        from_arrays(ONE, time, q[:, None], reading=Reading(mode))  # type: ignore[arg-type]


@pytest.mark.parametrize("mode", ["auto", "spline", "savgol", "central"])
@pytest.mark.parametrize("spread", [1.0, 3.0, 8.0])
def test_wild_stamps_give_numbers_or_a_clean_error(mode: str, spread: float) -> None:
    rng = np.random.default_rng(6)
    for _ in range(10):
        time = np.cumsum(10.0 ** rng.uniform(-spread, spread, 200))
        try:
            result = from_arrays(ONE, time, rng.normal(size=(200, 1)), reading=Reading(mode))  # type: ignore[arg-type]
        except TrajectoryError:
            continue
        assert np.isfinite(result.qdd).all()
