"""What a lower sample rate costs: the peak torques of every second, fourth and eighth sample."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.plan import Plan
from robodyn.measure.accuracy.derivative_ladder import torques
from robodyn.measure.accuracy.ladder import Ladder, Rung
from robodyn.measure.accuracy.timing import timed
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.robot_motion import motion

Floats = NDArray[np.float64]
EVERY = 1, 2, 4, 8
FEWEST = 32
"""Samples that are left at least."""


def rate_ladder(a_plan: Plan, samples: Trajectory) -> Ladder:
    """The largest change of a joint's peak torque, relative to the largest peak, where samples are left out.

    Accelerations that the data do not give are derived from the samples that are left. Times are per sample of the
    data, so they tell what leaving out saves.
    """
    full = _peaks(a_plan, samples, 1)
    acts = {str(k): partial(_peaks, a_plan, samples, k) for k in EVERY if len(samples) >= FEWEST * k}
    size = a_plan.torques().size
    rate = (len(samples) - 1) / (samples.time[-1] - samples.time[0])
    rungs = [
        Rung(f"{_nth(int(k))}, {rate / int(k):.4g} Hz", (_change(peaks, full),), time, size / int(k))
        for k, (peaks, time) in timed(acts, 1 / len(samples)).items()
    ]
    return Ladder("sample rate", ("peak torque",), "the peaks at the full rate", "sample", tuple(rungs))


def _peaks(a_plan: Plan, samples: Trajectory, every: int) -> Floats:
    rows = slice(None, None, every)
    extra = {name: column[rows] for name, column in samples.extra.items()}
    time, q, qd, qdd = (part[rows] for part in (samples.time, samples.q, samples.qd, samples.qdd))
    left = replace(samples, time=time, q=q, qd=qd, qdd=qdd, extra=extra)
    if samples.derivation is not None:
        given = all(joint.velocity == "given" for joint in samples.derivation.joints)
        left = motion(a_plan.model, time, q, qd if given else None, columns=extra)
    found: Floats = np.abs(torques(a_plan, left)).max(axis=0)
    return found


def _change(peaks: Floats, full: Floats) -> float:
    return float(np.abs(peaks - full).max() / (full.max() or 1.0))


def _nth(every: int) -> str:
    return {1: "every sample", 2: "every 2nd"}.get(every, f"every {every}th")
