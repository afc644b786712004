"""Differentiation: stencils against published figures and SciPy, any spacing, wraps, quaternions, too few samples."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.derivatives import derive
from robodyn.trajectory.derivatives.derivative_selection import select
from robodyn.trajectory.derivatives.differentiate import SPLINE, differentiate, equal_spacing, savgol
from robodyn.trajectory.formats.table import ArrayTable
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.options import Reading
from robodyn.trajectory.read import TrajectoryReader, from_arrays

Array = NDArray[np.float64]
EPS = np.finfo(np.float64).eps
ONE = Signals((Signal("a", "angle"),))


@pytest.mark.parametrize(("count", "jitter"), [(6, 0.3), (97, 0.0), (1000, 0.3)])
def test_spline_is_that_of_scipy(count: int, jitter: float) -> None:
    rng = np.random.default_rng(count)
    time = (np.arange(count) + rng.uniform(-jitter, jitter, count)) * 0.01
    values = np.column_stack((np.sin(9 * time), np.cos(5 * time)))
    curve = make_interp_spline(time, values, k=5)
    first, second = differentiate(time, values, SPLINE)
    assert np.abs(first - curve(time, 1)).max() <= 2e4 * EPS * np.abs(values).max() / 0.01
    assert np.abs(second - curve(time, 2)).max() <= 2e4 * EPS * np.abs(values).max() / 0.01**2


@pytest.mark.parametrize("window", [7, 101])
def test_savitzky_golay_is_that_of_scipy(window: int) -> None:
    from scipy.signal import savgol_filter

    values = np.random.default_rng(1).normal(size=300)
    found = differentiate(np.arange(300) * 0.5, values[:, None], savgol(window))
    for order, derivative in enumerate(found, start=1):
        expected = savgol_filter(values, window, 4, deriv=order, delta=0.5, mode="interp")
        assert np.abs(derivative[:, 0] - expected).max() <= 1e-10 * np.abs(expected).max()  # SciPy's own rounding


def test_local_polynomials_are_those_of_least_squares() -> None:
    """In the middle and at the ends; normal equations would miss the second derivative at an end by 1e-7."""
    time = np.sort(np.random.default_rng(2).uniform(0.0, 2.0, 60))
    values = 1e3 + np.sin(3 * time)
    first, second = (rate[:, 0] for rate in differentiate(time, values[:, None], savgol(7)))
    for row, start in ((0, 0), (1, 0), (30, 27), (58, 53), (59, 53)):
        part = slice(start, start + 7)
        curve = Polynomial.fit(time[part], values[part] - 1e3, 4)
        assert abs(first[row] - curve.deriv()(time[row])) <= 1e-11 * np.abs(first).max()
        assert abs(second[row] - curve.deriv(2)(time[row])) <= 1e-11 * np.abs(second).max()


@pytest.mark.parametrize("step", [1e-3, 3.0])
def test_equal_spacing_survives_rounding(step: float) -> None:
    for offset in (0.0, 1e3, -7.0):
        time = offset + np.arange(1000) * step
        assert equal_spacing(time) == pytest.approx(step, rel=1e-9)
        time[500] += 1e-4 * step
        assert equal_spacing(time) == 0.0


@pytest.mark.parametrize("mode", ["auto", "spline", "savgol", "central"])
def test_few_samples(mode: str) -> None:
    """A parabola is exact however few samples there are; a velocity that is given is differentiated once."""
    for count in (3, 4, 5, 6, 7, 20):
        time = np.array([0.0, 0.1, 0.3, 0.35, 0.5, 0.7, 1.0, *np.arange(1.2, 10.0, 0.25)])[:count]
        q, qd = (3 * time**2 - time)[:, None], (6 * time - 1)[:, None]
        result = from_arrays(ONE, time, q, reading=Reading(mode))  # type: ignore[arg-type]
        assert np.abs(result.qdd - 6.0).max() < 1e-9
        assert np.abs(result.qd - qd).max() < 1e-10
        given = from_arrays(ONE, time, 0.0 * q, qd, reading=Reading(mode))  # type: ignore[arg-type]
        np.testing.assert_array_equal(given.qd, qd)
        assert np.abs(given.qdd - 6.0).max() < 1e-9


def test_turns_of_a_continuous_joint() -> None:
    time = np.arange(2000) / 1000
    angle = 9.0 * time + 0.5 * np.sin(2 * np.pi * time)
    wrapped = (angle + np.pi) % (2 * np.pi) - np.pi
    turning = from_arrays(Signals((Signal("a", "continuous"),)), time, wrapped[:, None])
    straight = from_arrays(Signals((Signal("a", "continuous"),)), time, angle[:, None])
    np.testing.assert_array_equal(turning.q[:, 0], wrapped)
    assert np.abs(turning.qdd - straight.qdd).max() < 1e-7
    assert turning.derivation is not None
    assert turning.derivation.joints[0].acceleration == "quintic spline"
    fixed = from_arrays(ONE, time, wrapped[:, None], reading=Reading("spline"))
    assert np.abs(fixed.qdd).max() > 6e6


def test_a_pause_longer_than_the_window() -> None:
    time = np.concatenate((np.arange(400) / 400, 100 + np.arange(400) / 400))
    q = np.round(np.sin(time), 5)
    with pytest.raises(TrajectoryError, match=r"row 401: a pause of 99\.0025 s is longer than the window"):
        from_arrays(ONE, time, q[:, None])
    for mode in ("central", "spline"):
        from_arrays(ONE, time, q[:, None], reading=Reading(mode))  # type: ignore[arg-type]


@pytest.mark.parametrize("mode", ["auto", "spline", "savgol", "central"])
def test_wild_stamps_give_numbers_or_a_clean_error(mode: str) -> None:
    rng = np.random.default_rng(6)
    for spread in 4 * (1.0, 3.0, 8.0):
        time = np.cumsum(10.0 ** rng.uniform(-spread, spread, 200))
        try:
            result = from_arrays(ONE, time, rng.normal(size=(200, 1)), reading=Reading(mode))  # type: ignore[arg-type]
        except TrajectoryError:
            continue
        assert np.isfinite(result.qdd).all()


FREE = Signals((Signal("base", "floating"),))


def read(columns: dict[str, Array], mode: str = "auto") -> Trajectory:
    reader = TrajectoryReader(ArrayTable(None, columns), FREE, reading=Reading(mode))  # type: ignore[arg-type]
    (block,) = reader.blocks()
    return block


def turn(time: Array) -> tuple[Array, Array, Array]:
    """Roll, pitch and yaw that all move: quaternion x y z w, w and wd in body axes by the kinematics of the angles."""
    a, ad, add = 0.7 * np.sin(time), 0.7 * np.cos(time), -0.7 * np.sin(time)
    b, bd, bdd = 0.5 * np.sin(2 * time), np.cos(2 * time), -2 * np.sin(2 * time)
    c, cd, cdd = 3 * time, 3 + 0 * time, 0 * time
    Q = Rotation.from_euler("ZYX", np.column_stack((c, b, a))).as_quat()
    sa, ca, sb, cb = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
    w = np.column_stack((ad - cd * sb, bd * ca + cd * sa * cb, -bd * sa + cd * ca * cb))
    wd = np.column_stack(
        (
            add - cdd * sb - cd * cb * bd,
            bdd * ca - bd * sa * ad + cdd * sa * cb + cd * (ca * ad * cb - sa * sb * bd),
            -bdd * sa - bd * ca * ad + cdd * ca * cb + cd * (-sa * ad * cb - ca * sb * bd),
        )
    )
    return Q, w, wd


def columns(time: Array, Q: Array) -> dict[str, Array]:
    return {"time": time, **{f"base_q{axis}": Q[:, i] for i, axis in enumerate("xyzw")}}


@pytest.mark.parametrize(("jitter", "flips"), [(0.0, False), (0.2, True)])
def test_body_rates_of_a_clean_rotation(jitter: float, flips: bool) -> None:
    """w and wd to the accuracy of the spline, whichever of Q and -Q each sample holds."""
    rng = np.random.default_rng(0)
    time = (np.arange(1000) + rng.uniform(-jitter, jitter, 1000)) / 200
    Q, w, wd = turn(time)
    result = read(columns(time, Q * rng.choice([-1.0, 1.0], (1000, 1)) if flips else Q))
    inner = slice(10, -10)
    assert np.abs(result.qd[inner, :3] - w[inner]).max() < 1e-8
    assert np.abs(result.qdd[inner, :3] - wd[inner]).max() < 1e-6
    np.testing.assert_array_equal(result.qd[:, 3:], 0.0)


@pytest.mark.slow
def test_implied_deviation_of_body_rates() -> None:
    time = np.arange(1500) / 500
    Q, rng = turn(time)[0], np.random.default_rng(1)
    runs = [read(columns(time, Q + 1e-5 * rng.normal(size=Q.shape)), "spline") for _ in range(10)]
    spread = np.sqrt(np.stack([run.qdd[:, :3] for run in runs])[:, 100:-100].var(axis=0, ddof=1).mean())
    assert runs[0].derivation is not None
    assert 0.8 < runs[0].derivation.joints[0].std / spread < 1.25


def test_given_rates_are_kept_and_only_the_rest_derived() -> None:
    time = np.arange(600) / 200
    Q, w, wd = turn(time)
    rates = {"base_wx": w[:, 0], "base_wdy": wd[:, 1], "base_x": np.sin(time), "base_vy": np.cos(time)}
    result = read(columns(time, Q) | rates)
    np.testing.assert_array_equal(result.qd[:, 0], w[:, 0])
    np.testing.assert_array_equal(result.qdd[:, 1], wd[:, 1])
    np.testing.assert_array_equal(result.qd[:, 4], np.cos(time))
    inner = slice(10, -10)
    assert np.abs(result.qdd[inner, :3] - wd[inner]).max() < 1e-6
    assert np.abs(result.qdd[inner, 3] + np.sin(time)[inner]).max() < 1e-8
    assert np.abs(result.qdd[inner, 4] + np.sin(time)[inner]).max() < 1e-8
    assert result.notes == (
        "base: position y z is not given and taken as 0",
        "base: velocity vz is not given and taken as 0",
    )


def test_absent_columns() -> None:
    time = np.arange(50) / 100
    result = read({"time": time, "base_az": np.full(50, 2.0)})
    np.testing.assert_array_equal(result.q, np.tile([0, 0, 0, 0, 0, 0, 1.0], (50, 1)))
    np.testing.assert_array_equal(result.qd, 0.0)
    np.testing.assert_array_equal(result.qdd, np.tile([0, 0, 0, 0, 0, 2.0], (50, 1)))
    assert result.derivation is None
    assert result.notes == (
        "base: position x y z is not given and taken as 0",
        "base: orientation is not given and taken as the identity",
        "base: velocity wx wy wz vx vy vz is not given and taken as 0",
    )


@pytest.mark.parametrize("scale", [1.0, 1.0005, 0.5, 1e-200, 1e200])
def test_quaternions_are_normalised(scale: float) -> None:
    time = np.arange(300) / 100
    Q, w, _ = turn(time)
    result = read(columns(time, Q * scale), "spline")
    assert np.abs(np.linalg.norm(result.q[:, 3:], axis=1) - 1.0).max() <= 4 * EPS
    assert np.abs(result.qd[10:-10, :3] - w[10:-10]).max() < 1e-6
    assert any("quaternions normalised" in note for note in result.notes) == (abs(scale - 1.0) > 1e-3)


def test_zero_quaternion() -> None:
    Q = np.tile([0.0, 0.0, 0.0, 1.0], (9, 1))
    Q[5] = 0.0
    with pytest.raises(TrajectoryError, match="row 6: the quaternion of 'base' is zero"):
        read(columns(np.arange(9.0), Q))


@pytest.mark.parametrize("digits", [9, 4])
@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_blocks_do_not_change_a_bit(digits: int, jitter: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of motions that rest, where few samples need windows, and of noisy ones."""
    rng = np.random.default_rng(1)
    time = 1e-2 * (np.arange(700) + jitter * rng.uniform(-1, 1, 700))
    values = np.round(np.sin(np.minimum(time, 4.0))[:, None], digits)
    found = []
    for rows in (1 << 14, 128):
        monkeypatch.setattr(derive, "_ROWS", rows)
        monkeypatch.setattr(derive, "_REACHES", 1)
        with np.errstate(all="ignore"):
            selection = select([(time, values, values)], 2, "auto")
            found.append(np.array(derive.estimated(time, values, None, selection, 5)))
    np.testing.assert_array_equal(*found)
