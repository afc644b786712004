"""Printed peaks and their bars hold the largest torque of motions that are known exactly, and verdicts do not mislead.

One joint of each motion is looked at, as joints of one motion are not independent. Bounds are those that a true share
of 93 % of bars that hold, or of 2 % of verdicts that mislead, misses once in a thousand runs of other seeds.
"""

from __future__ import annotations

from itertools import chain

import numpy as np
import pytest
from benchmarks.peak_bar_coverage import ABOVE, BELOW, ENOUGH, GREEN, NARROW, Case, case
from helpers.exact_motions import MOTIONS, course
from helpers.read_motions import GIVEN, READINGS

DRAWS = 4
RISK, KEPT = 1e-3, 0.9
CLASSES = [*MOTIONS, *READINGS, *GIVEN, "100 Hz", "250 Hz", "500 Hz", "1000 Hz"]


@pytest.fixture(scope="module")
def cases() -> list[Case]:
    """Draws differ from motion to motion, so that every reading is among them."""
    return [case(kind, k + draw, "test", judged=1) for k, kind in enumerate(MOTIONS) for draw in range(DRAWS)]


def least(share: float, count: int) -> int:
    """Fewer of `count` than this have a chance below RISK where this share is true."""
    from scipy.stats import binom

    return int(binom.ppf(RISK, count, share))


@pytest.mark.slow
@pytest.mark.parametrize("name", CLASSES)
def test_bars_hold_the_largest_torque_and_no_verdict_is_green_over_an_exceeded_limit(cases: list[Case], name: str):
    """Of most tables of a class something is printed."""
    every = [each for each in cases if name in each.labels]
    own = [each for each in every if not each.refused]
    assert every
    assert len(own) >= len(every) / 2, next(each.refused for each in every if each.refused)
    holds = [each.verdicts[0][0].holds(each.verdicts[0][0].true) for each in own]
    assert sum(holds) >= least(ENOUGH, len(own)), f"{sum(holds)} of {len(own)}"
    green = sum(each.told(BELOW)[0] is True for each in own)
    assert len(own) - green >= least(1 - GREEN, len(own)), f"{green} of {len(own)}"


@pytest.mark.slow
def test_verdicts_tell_a_limit_that_is_kept(cases: list[Case]) -> None:
    """No bar is so wide that it always holds: where it is narrow, a limit 5 % above the largest torque is kept.

    No verdict is green over rates that positions contradict, so the share that is kept is of the other tables. A
    verdict is of all joints: one with a wide bar near its limit leaves it open.
    """
    firsts = [each.verdicts for each in cases]
    narrow = [told for load, share, told in chain(*firsts) if share == ABOVE and load.bar <= NARROW * load.true]
    assert len(narrow) >= len(cases) / 3
    assert len(narrow) - sum(told is False for told in narrow) >= least(1 - GREEN, len(narrow))
    sound = [case.verdicts for case in cases if case.labels[2] in ("none", "velocity", "both")]
    narrow = [told for load, share, told in chain(*sound) if share == ABOVE and load.bar <= NARROW * load.true]
    assert sum(told is True for told in narrow) >= least(KEPT, len(narrow)), len(narrow)


def test_the_motions_are_what_they_are_said_to_be() -> None:
    """Velocities and accelerations are the slopes of positions and velocities, but for one step beside each jump."""
    for kind in MOTIONS:
        for draw in range(2):
            motion = course(kind, np.random.default_rng(draw), [(-2.0, 2.0), (0.0, 0.3)], 0.002)
            t = np.linspace(0.0, motion.duration, 8001)
            q, qd, qdd = motion.at(t)
            away = (t > 0) & (t < motion.duration)
            for corner in chain(*(path.corners for path in motion.paths)):
                away &= np.abs(t - corner) > 2 * t[1]
            for values, slopes in ((q, qd), (qd, qdd)):
                off = np.abs(np.gradient(values, t[1], axis=0) - slopes)[away]
                assert off.max() <= 1e-4 * np.abs(slopes).max()
