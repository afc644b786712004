"""Logs on even grids, their noise, and the filter that acts on both sides alike."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from helpers.identified_logs import write_log

import robodyn
from robodyn.identification.log.log import noise_cutoff, read_log
from robodyn.identification.log.rows import convolved, filtered, kernel, rates, states

ARM = ROBOTS / "two_link_planar.urdf"
STEP = 0.004


def log_of(folder, time, q, tau, cutoff=None):
    write_log(folder / "log.csv", robodyn.load(ARM), time, q, tau)
    return read_log(str(folder / "log.csv"), robodyn.load(ARM), cutoff=cutoff)


def swing(time):
    return np.column_stack([np.sin(3.0 * time), 0.5 * np.cos(5.0 * time)])


def test_the_kernel_passes_and_stops():
    taps = kernel(20.0, STEP)
    assert taps.sum() == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_array_equal(taps, taps[::-1])
    time = STEP * np.arange(2000)
    for frequency, passes in ((5.0, 1.0), (14.0, 1.0), (20.0, 0.5), (26.0, 0.0), (60.0, 0.0)):
        wave = np.cos(2.0 * np.pi * frequency * time)[:, None]
        reach = len(taps) // 2
        np.testing.assert_allclose(convolved(wave, taps)[:, 0], passes * wave[reach:-reach, 0], atol=2e-4)


def test_derivatives_of_what_passes():
    time = STEP * np.arange(2000)
    w = 2.0 * np.pi * 2.0
    kernels = rates(kernel(20.0, STEP), STEP)
    reach = len(kernels[0]) // 2
    inner = time[reach:-reach]
    expected = np.sin(w * inner), w * np.cos(w * inner), -w * w * np.sin(w * inner)
    for taps, values in zip(kernels, expected, strict=True):
        found = convolved(np.sin(w * time)[:, None], taps)[:, 0]
        np.testing.assert_allclose(found, values, atol=1.5e-4 * np.abs(values).max())


@pytest.mark.parametrize("noise", [0.0, 1e-5])
def test_blocks_change_nothing(noise, tmp_path, monkeypatch):
    """Rows of a log in blocks of 100 samples are those of the log at once."""
    time = STEP * np.arange(2500)
    q = swing(time) + noise * np.random.default_rng(1).normal(size=(len(time), 2))
    log = log_of(tmp_path, time, q, np.cos(swing(time)), cutoff=12.0)
    assert log.noisy == bool(noise)
    whole = [np.concatenate(parts) for parts in zip(*filtered(log, 12.0, lambda s: s.qdd), strict=True)]
    monkeypatch.setattr("robodyn.identification.log.rows._ROWS", 100)
    parts = [np.concatenate(parts) for parts in zip(*filtered(log, 12.0, lambda s: s.qdd), strict=True)]
    for one, other in zip(whole, parts, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12 * np.abs(one).max())
    if not noise:
        exact = -np.array([9.0, 25.0]) * swing(whole[0])
        np.testing.assert_allclose(whole[1], exact, atol=5e-4 * np.abs(exact).max())


def test_uneven_stamps_are_put_on_a_grid(tmp_path):
    rng = np.random.default_rng(2)
    time = STEP * (np.arange(2000) + rng.uniform(-0.3, 0.3, 2000))
    log = log_of(tmp_path, time, swing(time), swing(time))
    assert not log.even
    found = list(log.blocks())
    stamps = np.concatenate([each.time for each in found])
    np.testing.assert_allclose(np.diff(stamps), log.step, rtol=1e-9)
    np.testing.assert_allclose(np.concatenate([each.q for each in found]), swing(stamps), atol=1e-6)
    np.testing.assert_allclose(np.concatenate([each.tau for each in found]), swing(stamps), atol=2e-4)


def test_no_window_reaches_over_a_gap(tmp_path):
    time = STEP * np.concatenate([np.arange(1000), np.arange(1100, 2000)])
    log = log_of(tmp_path, time, swing(time), swing(time), cutoff=12.0)
    assert [each.begins for each in states(log, 12.0)] == [True, True]
    stamps = np.concatenate([rows.time for rows in filtered(log, 12.0, lambda s: s.q)])
    reach = STEP * (len(kernel(12.0, STEP)) // 2)
    assert not ((stamps > 999 * STEP - reach + 1e-9) & (stamps < 1100 * STEP + reach - 1e-9)).any()


def test_noise_sets_the_cutoff():
    """Motion below 3 Hz and white noise: the cutoff lies between; lines of a converter do not count."""
    rng = np.random.default_rng(3)
    time = 0.001 * np.arange(20000)
    tau = 10.0 * np.sin(2.0 * np.pi * np.outer(time, [0.5, 1.0, 3.0])) @ np.ones((3, 2))
    noisy = tau + 0.1 * rng.normal(size=tau.shape)
    assert 3.0 <= noise_cutoff(noisy, 0.001) <= 12.0
    assert noise_cutoff(noisy + 3.0 * np.sin(2.0 * np.pi * 180.0 * time)[:, None], 0.001) <= 12.0
