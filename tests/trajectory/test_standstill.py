"""Speeds are 0 where positions stand still within the table's own resolution, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.derivatives.standstill import resolution, standing
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.read import from_arrays, open_trajectory
from robodyn.trajectory.write import open_writer

ONE = Signals((Signal("a", "angle", -10.0, 10.0, 100.0),))
GRIDS = {"nine digits": 1e-9, "six digits": 1e-6, "17 bits": 2 * np.pi / 2**17, "13 bits": 2 * np.pi / 2**13}


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
    return from_arrays(ONE, time, q[:, None])


@pytest.mark.parametrize("grid", [*GRIDS.values(), 0.0], ids=[*GRIDS, "doubles"])
@pytest.mark.parametrize("step", [1e-3, 1e-2])
@pytest.mark.parametrize("move", [smooth, hard])
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


@pytest.mark.parametrize("sigma", [1e-6, 1e-5, 1e-4])
def test_noise_in_a_dwell_is_no_motion(sigma: float) -> None:
    time = np.arange(0.0, 3.0, 1e-3)
    for seed, move in enumerate((smooth, hard)):
        exact, there = dwell(time, 1.0, move)
        noisy = exact + sigma * np.random.default_rng(seed).standard_normal(len(time))
        assert not derived(time, noisy).qd[there, 0].any()


@pytest.mark.parametrize("grid", GRIDS.values(), ids=GRIDS)
@pytest.mark.parametrize("step", [1e-3, 1e-2])
def test_a_slow_motion_goes_on(grid: float, step: float) -> None:
    """A motion of more than a step of the grid in 100 rows, in one direction or about a turning point."""
    time = np.arange(2000) * step
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
    found = from_arrays(ONE, time, exact[:, None], given[:, None], np.zeros((len(time), 1)))
    assert not found.qd[there, 0].any()
    assert (found.qd[~there, 0] == given[~there]).all()


def test_given_speeds_that_contradict_positions_are_kept() -> None:
    """A table of friction, say: one place, all speeds; and a creep that positions are too coarse to show."""
    time = np.arange(0.0, 3.0, 1e-3)
    still, rest = np.full((len(time), 1), 0.2), np.zeros((len(time), 1))
    for speeds in (np.sin(3.0 * time), np.full(len(time), 0.5), 1e-5 + 0.0 * time):
        assert (from_arrays(ONE, time, still, speeds[:, None], rest).qd[:, 0] == speeds).all()
    coarse = np.round((0.2 + 1e-5 * time) / 1e-3) * 1e-3 + hard(time - 2.5)
    speeds = 1e-5 + np.gradient(hard(time - 2.5), time)
    found = from_arrays(ONE, time, coarse[:, None], speeds[:, None], rest)
    assert (found.qd[:2200, 0] == speeds[:2200]).all()


def test_blocks_do_not_matter(tmp_path) -> None:
    time = np.arange(0.0, 6.0, 1e-3)
    exact = sum(dwell(time - 3.0 * k, 1.0, smooth)[0] - 0.3 for k in range(2))
    with open_writer(str(tmp_path / "t.csv"), ("q_a",)) as writer:
        writer.write(time, np.round(exact, 6)[:, None])
    whole, parts = (
        np.concatenate([block.qd[:, 0] for block in open_trajectory(tmp_path / "t.csv", ONE, block_rows=rows).blocks()])
        for rows in (1 << 15, 900)
    )
    assert ((whole == 0.0) == (parts == 0.0)).all()
    assert 2000 <= (whole == 0.0).sum() < 2150
