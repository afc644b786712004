"""Which signals are called noisy, which method they get, how far its accelerations are off, and where speeds are 0."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.derivatives.derivative_selection import WINDOWS, quantum
from robodyn.trajectory.derivatives.differentiate import CENTRAL, SPLINE, differentiate, savgol
from robodyn.trajectory.derivatives.standstill import resolution, standing
from robodyn.trajectory.motion import JointDerivation, Trajectory
from robodyn.trajectory.options import Reading
from robodyn.trajectory.read import from_arrays

Array = NDArray[np.float64]
ONE = Signals((Signal("a", "angle"),))


def slow(name: str) -> object:
    return pytest.param(name, 5000 if name == "4 decimals" else 1000, marks=pytest.mark.slow)


def derive(time: Array, q: Array, mode: str = "auto") -> tuple[Trajectory, JointDerivation]:
    result = from_arrays(ONE, time, q[:, None], reading=Reading(mode))  # type: ignore[arg-type]
    assert result.derivation is not None
    return result, result.derivation.joints[0]


def encoder(bits: int) -> Callable[[Array], Array]:
    step = 2 * np.pi / 2**bits
    return lambda q: np.round(q / step) * step


def decimals(count: int) -> Callable[[Array], Array]:
    return lambda q: np.round(q, count)


def noise(size: float) -> Callable[[Array], Array]:
    return lambda q: q + size * np.random.default_rng(0).normal(size=q.shape)


@pytest.mark.parametrize(
    ("values", "step"),
    [
        (np.round(np.sin(np.arange(300.0)), 6), 1e-6),
        (encoder(12)(1000 + 3 * np.sin(np.arange(300.0))), 2 * np.pi / 2**12),
        (np.round(encoder(13)(np.sin(np.arange(300.0))), 9), 2 * np.pi / 2**13),
        (np.array([0.0, 6.0, 10.0]), 2.0),
        (np.sin(np.arange(300.0)), 0.0),
        (np.full(300, 1.234), 0.0),
        (np.array([1.5]), 0.0),
    ],
)
def test_grid(values: Array, step: float) -> None:
    assert quantum(values) == pytest.approx(step, rel=1e-4, abs=0.0)


def minimum_jerk(time: Array) -> Array:
    """Ten moves of 1 s from point to point, each a quintic; corners in the jerk between them."""
    points = np.random.default_rng(1).uniform(-1, 1, 12)
    i = np.clip(time.astype(int), 0, 10)
    s = np.clip(time - i, 0.0, 1.0)
    return points[i] + (points[i + 1] - points[i]) * s**3 * (10 - 15 * s + 6 * s**2)


def trapezoid(time: Array) -> Array:
    """Bang, cruise, bang: steps in the acceleration."""
    speed = np.interp(time % 4.0, [0.0, 0.5, 1.5, 2.0, 2.5, 3.5, 4.0], [0.0, 1.0, 1.0, 0.0, -1.0, -1.0, 0.0])
    return np.concatenate(([0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(time))))


CLEAN: dict[str, Callable[[Array], Array]] = {
    "sine": lambda t: np.sin(2 * np.pi * t),
    "five samples a period": lambda t: np.sin(2 * np.pi * t * 0.2 / (t[1] - t[0])),
    "chirp": lambda t: np.sin(t**2),
    "far from zero": lambda t: 1e4 + np.sin(t),
    "minimum jerk": minimum_jerk,
    "trapezoid": trapezoid,
    "ramp of decimals": lambda t: np.round(0.001 * np.arange(len(t)), 3),
    "rest": lambda t: np.full(len(t), 0.7),
    "one step": lambda t: np.where(t > 3.0, 1.0, 0.0),
    "square wave": lambda t: np.where(t % 2.0 < 1.0, 0.5, -0.5),
    "held samples": lambda t: np.sin(np.floor(t * 5.0) / 5.0),
    "teach points": lambda t: np.random.default_rng(2).uniform(-1, 1, len(t)),
    "coarse decimals": lambda t: np.round(np.sin(t), 1),
    "move after rest": lambda t: np.where(t < 8.0, 0.0, np.where(t > 9.0, 1.0, minimum_jerk(t))),
}


@pytest.mark.parametrize(("name", "rate"), [*((name, 100) for name in CLEAN), *map(slow, list(CLEAN)[::3])])
def test_clean_signals_are_not_smoothed(name: str, rate: int) -> None:
    time = np.arange(10 * rate) / rate
    result, joint = derive(time, CLEAN[name](time))
    assert joint.acceleration == "quintic spline"
    assert joint.std <= 1e-3
    rough = name in ("held samples", "teach points", "square wave", "one step")
    assert not rough or rate != 100 or any("smoothed" in note for note in result.notes)


NOISY = {
    "17 bits": encoder(17),
    "13 bits": encoder(13),
    "6 decimals": decimals(6),
    "4 decimals": decimals(4),
    "1e-4": noise(1e-4),
    "1e-6": noise(1e-6),
    "float32": lambda q: q.astype(np.float32).astype(np.float64),
}


@pytest.mark.parametrize(("name", "rate"), [("17 bits", 500), *map(slow, list(NOISY)[1:])])
def test_noisy_signals_are_smoothed_nearly_as_well_as_can_be(name: str, rate: int) -> None:
    """The window is found without the truth; with the truth one could do better by 60 % at most."""
    time = np.arange(4 * rate) / rate
    parts = [(1.0, 0.5, 0.0), (0.3, 1.7, 1.0)]
    truth = sum(-a * (2 * np.pi * f) ** 2 * np.sin(2 * np.pi * f * time + p) for a, f, p in parts)
    q = NOISY[name](np.asarray(sum(a * np.sin(2 * np.pi * f * time + p) for a, f, p in parts)))
    result, joint = derive(time, q)

    def error(qdd: Array) -> float:
        return float(np.sqrt(np.mean((qdd - truth)[rate // 10 : -rate // 10] ** 2)))

    best = min(error(differentiate(time, q[:, None], savgol(window))[1][:, 0]) for window in WINDOWS)
    assert joint.acceleration.startswith("Savitzky-Golay (window ")
    assert error(result.qdd[:, 0]) < 1.6 * best
    assert error(result.qdd[:, 0]) < 0.01 * np.abs(truth).max()


@pytest.mark.parametrize(("size", "jitter"), [(1e-7, 0.2), (1e-3, 0.0)])
def test_size_of_white_noise(size: float, jitter: float) -> None:
    rng = np.random.default_rng(3)
    time = (np.arange(2000) + rng.uniform(-jitter, jitter, 2000)) / 20.0
    _, joint = derive(time, np.sin(2 * np.pi * time) + size * rng.normal(size=2000))
    assert joint.noise == pytest.approx(size, rel=0.2)


def test_noise_of_a_fast_small_motion_does_not_erase_it() -> None:
    """Amplitude ten times the noise, 25 samples a period: windows that hold whole periods must not be chosen."""
    time = np.arange(4000) / 1000
    rng = np.random.default_rng(6)
    q = 0.01 * np.sin(2 * np.pi * 40 * time)
    result, _ = derive(time, q + 1e-3 * rng.normal(size=4000))
    truth = -((2 * np.pi * 40) ** 2) * q
    assert np.std((result.qdd[:, 0] - truth)[60:-60]) < 0.35 * np.std(truth)


@pytest.mark.parametrize("mode", [pytest.param("savgol", marks=pytest.mark.slow), "spline", "central"])
def test_implied_noise_of_acceleration_is_that_of_many_noisy_copies(mode: str) -> None:
    """By what the method makes of a unit in each sample, whose squares add up to those of all copies there could be."""
    rng, time = np.random.default_rng(7), np.arange(301) * 1e-3
    scores = []
    for _ in range(2):
        q = 2 * time + 1e-4 * rng.standard_normal(301)
        result, joint = derive(time, q, mode)
        window = re.search(r"window (\d+)", joint.acceleration)
        method = savgol(int(window[1])) if window else {"spline": SPLINE, "central": CENTRAL}[mode]
        of_units = differentiate(time, np.eye(301), method)[1]
        assert result.qdd[:, 0] == pytest.approx(of_units @ q, abs=1e-9 * np.abs(of_units).max())
        assert result.sampling is not None
        assert joint.std == pytest.approx(result.sampling.noise[150, 0], rel=1e-9)
        scores.append(result.sampling.noise[:, 0] / (1e-4 * np.sqrt((of_units**2).sum(axis=1))))
    score = np.sqrt(np.mean(np.square(scores), axis=0))
    assert (score >= 1 / 1.25).all()
    assert (score <= 1.25).all()


BITS = {bits: 2 * np.pi / 2**bits for bits in (13, 17)}
LIMITED = Signals((Signal("a", "angle", -10.0, 10.0, 100.0),))


def smooth(s):
    """A move of minimum jerk from 0 at s = 0 to 1 at s = 1."""
    s = np.clip(s, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s * s)


def hard(s):
    """A move of constant acceleration and deceleration."""
    s = np.clip(s, 0.0, 1.0)
    return np.where(s < 0.5, 2.0 * s * s, 1.0 - 2.0 * (1.0 - s) ** 2)


def dwell(time, long, move):
    """Positions that leave 0.3 for 1.0, stay for so long [s], and come back; and where they stay."""
    there = (time >= 1.0 - 1e-9) & (time <= 1.0 + long + 1e-9)
    return 0.3 + 0.7 * (move(time) - move(time - 1.0 - long)), there


def derived(time, q) -> Trajectory:
    return from_arrays(LIMITED, time, q[:, None])


@pytest.mark.parametrize(("grid", "step", "move"), [(1e-9, 1e-3, hard), (0.0, 1e-2, smooth), (BITS[13], 1e-2, smooth)])
def test_speeds_in_a_dwell_are_zero(grid: float, step: float, move) -> None:
    """Of dwells of 0.1 s and of 1 s; before and after it a joint moves but for where it is within its resolution."""
    for long in (0.1, 1.0):
        time = np.arange(0.0, 2.0 + long, step)
        exact, there = dwell(time, long, move)
        found = derived(time, np.round(exact / grid) * grid if grid else exact)
        assert not found.qd[there, 0].any()
        assert found.slowest is not None
        within = max(grid, float(found.slowest[0]) * 256 * step)  # a grid of the motion itself may be coarser
        away = np.abs(exact[:, None] - np.array([0.3, 1.0])).min(axis=1) > 1.5 * within
        assert found.qd[away & ~there, 0].all()


@pytest.mark.parametrize("sigma", [1e-6, 1e-4])
def test_noise_in_a_dwell_is_no_motion(sigma: float) -> None:
    time = np.arange(0.0, 3.0, 1e-3)
    for seed, move in enumerate((smooth, hard)):
        exact, there = dwell(time, 1.0, move)
        noisy = exact + sigma * np.random.default_rng(seed).standard_normal(len(time))
        assert not derived(time, noisy).qd[there, 0].any()


@pytest.mark.parametrize(("grid", "step"), [(1e-6, 1e-2), pytest.param(BITS[17], 1e-3, marks=pytest.mark.slow)])
def test_a_slow_motion_goes_on(grid: float, step: float) -> None:
    """A motion of more than a step of the grid in 100 rows, in one direction or about a turning point."""
    time = np.arange(1000) * step
    for steps in (0.01, 0.1, 1.0, 30.0):
        slope = steps * grid / step
        found = derived(time, np.round((0.2 + slope * time) / grid) * grid)
        assert (found.qd[:, 0] != 0.0).all()
        if grid < 1e-5:
            assert found.qd[8:-8, 0].mean() > 0.0
        if steps >= 0.1:  # below it, windows between two steps of the grid count most
            assert found.qd[8:-8, 0].mean() == pytest.approx(slope, rel=0.05)
    for curve in (1e-4, 1e-3, 1e-2):  # steps of the grid per row^2: a few dozens of rows within one step
        count = len(time)
        x = np.round(curve * (np.arange(count) - count / 2) ** 2)
        assert standing(x * grid, resolution(grid, 0.0, 1.0)).sum() <= (0 if curve > 1e-4 else 0.1 * count)


@pytest.mark.parametrize("noise", [1e-9, 1e-3])
def test_the_noise_of_given_speeds_in_a_dwell_is_no_motion(noise: float) -> None:
    time = np.arange(0.0, 3.0, 1e-3)
    exact, there = dwell(time, 1.0, hard)
    speeds = np.gradient(exact, time)
    speeds[there] = 0.0
    given = speeds + noise * np.random.default_rng(0).standard_normal(len(time))
    found = from_arrays(LIMITED, time, exact[:, None], given[:, None], np.zeros((len(time), 1)))
    assert not found.qd[there, 0].any()
    assert (found.qd[~there, 0] == given[~there]).all()


def test_given_speeds_that_contradict_positions_are_kept() -> None:
    """A table of friction, say: one place, all speeds; and a creep that positions are too coarse to show."""
    time = np.arange(0.0, 3.0, 1e-3)
    still, rest = np.full((len(time), 1), 0.2), np.zeros((len(time), 1))
    for speeds in (np.sin(3.0 * time), np.full(len(time), 0.5), 1e-5 + 0.0 * time):
        assert (from_arrays(LIMITED, time, still, speeds[:, None], rest).qd[:, 0] == speeds).all()
    coarse = np.round((0.2 + 1e-5 * time) / 1e-3) * 1e-3 + hard(time - 2.5)
    speeds = 1e-5 + np.gradient(hard(time - 2.5), time)
    found = from_arrays(LIMITED, time, coarse[:, None], speeds[:, None], rest)
    assert (found.qd[:2200, 0] == speeds[:2200]).all()
