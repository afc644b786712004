"""Error bars and verdicts of robots that were identified from noisy logs, on other motions: they hold as often as told.

Bars are by the code of `torques`, of loads and derivatives by the regressor, which a test compares. Nothing was tuned
on these seeds.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.identified_logs import Bench, coloured, quintics, waves, white
from helpers.oracles import ROBOTS
from helpers.verdicts import Verdicts

import robodyn

SEEDS = ("two_link_spatial", "scara", "puma560")
EDGES = np.array((0.05, 0.2, 0.4, 0.6, 0.8, 0.95))


def bench(name, motion, seed):
    return Bench(robodyn.load(ROBOTS / f"{name}.urdf" if name in SEEDS else Path(path_of(name))), motion, seed)


def magnitudes(bar):
    """Return standard error, value and ends of a bar that does not reach zero, without the sign."""
    return np.array([bar.standard_error, *sorted(map(abs, (bar.value, bar.low, bar.high)))])


def test_bars_are_those_of_torques():
    """By derivatives or by draws; a limit of the peak curve is a share of it."""
    known = Verdicts(bench("two_link_spatial", waves, 82), quintics)
    for values, C in known.bench.logs(white, 2):
        limits = 1.005 * known.true
        bars, stated = known.direct(values, C, limits)
        scale = np.append(limits[: known.n], np.ones(known.n))
        for limit, bar, probability, unit in zip(known.public(values, C, limits), bars, stated, scale, strict=True):
            assert limit.figure.method == bar.method
            assert limit.probability == pytest.approx(probability, abs=1e-9)
            assert unit * magnitudes(limit.figure) == pytest.approx(magnitudes(bar), rel=1e-9)


def test_a_few_verdicts():
    known = Verdicts(bench("two_link_spatial", waves, 83), quintics)
    held, stated, kept = known.judged(list(known.bench.logs(white, 20)))
    assert 0.85 <= held.mean() <= 1.0
    assert np.mean((stated - kept) ** 2) < 0.12


@pytest.mark.slow
def test_verdicts_hold_as_often_as_they_are_told():
    """500 logs of five robots: bars of peaks and of RMS, and how often limits are kept that were told with a chance."""
    shares, told, truth = [], [], []
    for name in (*SEEDS, "ur5_robot", "panda"):
        held = []
        for seed, (motion, other, noise) in enumerate(((waves, quintics, white), (quintics, waves, coloured))):
            known = Verdicts(bench(name, motion, 84 + seed), other)
            found, stated, kept = known.judged(list(known.bench.logs(noise, 50)))
            held.append([found[:, : known.n].mean(), found[:, known.n :].mean()])
            told.append(stated.ravel())
            truth.append(kept.ravel())
        shares.append(np.mean(held, axis=0))
    assert np.all(np.abs(np.mean(shares, axis=0) - 0.95) <= 0.02)
    assert np.all(np.abs(np.array(shares) - 0.95) <= 0.05)
    told, truth = np.concatenate(told), np.concatenate(truth)
    for bin in range(len(EDGES) + 1):
        own = np.digitize(told, EDGES) == bin
        assert own.sum() > 200
        assert abs(told[own].mean() - truth[own].mean()) <= 0.05
