"""Thinned curves keep every peak, in memory that does not grow, however the motion comes in blocks."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from robodyn.loads.history import SPANS, MinMaxDecimation, Recorder


def gathered(time, values, cuts, guess):
    thinned = MinMaxDecimation(("a", "b"), ("value",))
    edges = [0, *cuts, len(time)]
    for first, last in pairwise(edges):
        left = guess * (time[-1] - time[first])
        thinned.update(time[first:last], (values[:, first:last],), left)
    return thinned.curves()


@pytest.mark.parametrize("guess", [1.0, 0.01, 30.0])
@pytest.mark.parametrize("cuts", [(), (7, 5000, 5001, 20_000)])
def test_every_extreme_of_every_pixel_is_there(cuts, guess):
    rng = np.random.default_rng(1)
    time = np.cumsum(rng.uniform(0.0, 2e-3, 30_000)) + 5.0
    values = rng.normal(size=(2, len(time))).cumsum(axis=1)
    curves = gathered(time, values, cuts, guess)
    assert len(curves.kept) <= 1.3 * SPANS + 1
    for k in range(2):
        at, found = curves.line("value", k)
        assert (np.diff(at) > 0).all()
        places = np.searchsorted(time, at)
        np.testing.assert_array_equal(time[places], at)
        np.testing.assert_array_equal(values[k, places], found)
        assert (found.min(), found.max()) == (values[k].min(), values[k].max())


def test_extremes_of_each_span():
    time = np.linspace(0.0, 1.0, 100 * SPANS)
    values = np.random.default_rng(0).normal(size=(2, len(time)))
    curves = gathered(time, values, (1234, 9999), 1.0)
    spans = (time / (1.0 / SPANS)).astype(int)
    for k in range(2):
        at, found = curves.line("value", k)
        for span in range(SPANS):
            inside = (at / (1.0 / SPANS)).astype(int) == span
            expected = values[k, spans == span]
            assert (found[inside].min(), found[inside].max()) == (expected.min(), expected.max())


def test_few_samples_are_all_kept():
    time = np.array([0.0, 0.3, 0.31, 2.0])
    values = np.array([[1.0, 2.0, 3.0, -1.0], [0.0, 0.0, 0.0, 0.0]])
    at, found = gathered(time, values, (1, 2), 1.0).line("value", 0)
    np.testing.assert_array_equal(at, time)
    np.testing.assert_array_equal(found, values[0])


def test_speed_torque_and_power_are_of_the_same_sample():
    time = np.linspace(0.0, 3.0, 5000)
    qd, tau = np.sin(40 * time)[None], np.cos(31 * time)[None]
    recorder = Recorder(("j",), ("fx",))
    rows = np.array([0, 4999])
    recorder.update(time, qd, qd + 1, tau, tau, np.zeros((2, 2)), rows, 1.0)
    samples = recorder.history({}).joints.samples(0)
    np.testing.assert_array_equal(samples["power"], samples["speed"] * samples["torque"])
    np.testing.assert_array_equal(samples["acceleration"], samples["speed"] + 1)
    assert samples["power"].max() == (qd * tau).max()
    np.testing.assert_array_equal(samples["speed"], np.interp(samples["time"], time, qd[0]))
