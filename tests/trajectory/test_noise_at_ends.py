"""Near an end of the data the filters see one side only, and the implied noise says so."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.read import from_arrays
from robodyn.trajectory.reading import Reading

SIGNALS = Signals((Signal("elbow", "angle"),))


@pytest.mark.slow
def test_implied_noise_of_acceleration_is_that_of_many_noisy_copies() -> None:
    places = [0, 5, 20, 300]
    rng, time = np.random.default_rng(7), np.arange(1001) * 1e-3
    line = 2 * time  # whatever the window, its second derivative is 0, so all of qdd is noise
    scores = []
    for _ in range(200):
        noisy = (line + 1e-4 * rng.standard_normal(1001))[:, None]
        trajectory = from_arrays(SIGNALS, time, noisy, reading=Reading("savgol"))
        assert trajectory.sampling is not None
        scores.append([trajectory.qdd[-1 - k, 0] / trajectory.sampling.noise[-1 - k, 0] for k in places])
    for score in np.sqrt(np.mean(np.square(scores), axis=0)):
        assert 1 / 1.25 <= score <= 1.25


def test_the_end_is_the_noisiest_place() -> None:
    rng = np.random.default_rng(8)
    time = np.arange(1001) * 1e-3
    trajectory = from_arrays(SIGNALS, time, (np.sin(3 * time) + 1e-4 * rng.standard_normal(1001))[:, None])
    assert trajectory.sampling is not None
    noise, off = trajectory.sampling.noise[:, 0], trajectory.sampling.off[:, 0]
    assert noise[0] > 5 * np.median(noise)
    assert off[0] > 3 * np.median(off)
