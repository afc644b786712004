"""What deriving accelerations costs: every scheme, and lower sample rates, on the user's motion or on one like it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from robodyn.dynamics.plan import Plan, runner_of
from robodyn.errors import InputError
from robodyn.measure.accuracy.ladder import Ladder, Rung
from robodyn.measure.timing import timed
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.robot.model import Model
from robodyn.support.floats import Floats
from robodyn.trajectory.motion import Derivation, Trajectory
from robodyn.trajectory.read import motion, sources_of
from robodyn.trajectory.reading import MODES

MEASURES = "middle", "whole"
SEED = 0
"""Of the noise that is added to a motion like the given one."""


def derivative_ladder(a_plan: Plan, samples: Trajectory) -> Ladder:
    """Return torques with accelerations by each scheme against the torques of the motion they were derived from.

    Where the accelerations are given, they are forgotten and derived from the positions. Where they are not, a smooth
    motion like the given one takes its place, with white noise of the size that was found in the data: the truth is
    known, and the data are as bad.

    Raises:
        InputError: the motion is too short to be derived, or has floating joints and no accelerations.

    Accuracy: errors are of one draw of the noise.
    """
    if samples.derivation is None:
        truth, data, against = samples, samples.q, "the velocities and accelerations given"
    else:
        truth = like(a_plan.model, samples)
        data, against = noisy(a_plan.model, truth.q, samples.derivation)
    expected = torques(a_plan, truth)
    scale = np.abs(expected).max() or 1.0
    modes: tuple[Any, ...] = tuple(mode for mode in MODES if mode not in ("given", "anew"))
    derived = partial(motion, a_plan.model, truth.time, data, columns=truth.extra)
    acts = {str(mode): partial(derived, derivatives=mode) for mode in modes}
    rungs = []
    for name, (found, time) in timed(acts, 1 / len(truth)).items():
        off = np.abs(torques(a_plan, found) - expected).max(axis=1) / scale
        quarter = len(off) // 4
        rungs.append(Rung(name, (float(off[quarter : len(off) - quarter].max()), float(off.max())), time))
    return Ladder("derivatives", MEASURES, against, "sample", tuple(rungs))


def torques(a_plan: Plan, samples: Trajectory) -> Floats:
    """Return (N, n) of a motion, by NumPy."""
    program = a_plan.torques()
    run = NumpyBlocks(program, runner_of(program, a_plan).widths)
    return np.asarray(run(sources_of(samples, a_plan.scene), len(samples)), dtype=float)


def like(model: Model, samples: Trajectory) -> Trajectory:
    """Return a motion whose accelerations are splines through the derived ones, and its exact velocities and positions.

    Sampled half-way between the samples, so that no spline through its positions is the motion itself.

    Raises:
        InputError: a joint is floating.
    """
    from scipy.interpolate import CubicSpline

    if any(joint.kind == "floating" for joint in model.independent):
        raise InputError("a floating joint without accelerations has none that are known to compare with")
    time = samples.time
    qdd = CubicSpline(time, samples.qdd)
    qd = qdd.antiderivative()
    q = qd.antiderivative()
    off = (samples.q - q(time) - samples.qd[0] * (time - time[0])[:, None]).mean(axis=0)
    between = 0.5 * (time[1:] + time[:-1])
    moved = q(between) + samples.qd[0] * (between - time[0])[:, None] + off
    extra = {name: 0.5 * (column[1:] + column[:-1]) for name, column in samples.extra.items()}
    return motion(model, between, moved, samples.qd[0] + qd(between), qdd(between), columns=extra)


def noisy(model: Model, q: Floats, derivation: Derivation) -> tuple[Floats, str]:
    """Positions with the noise that was found in those of a motion, on the same grids; and what was done, in words."""
    found = {joint.name: joint for joint in derivation.joints}
    sigma, grid = (
        np.array([getattr(found.get(name), part, 0.0) for name in model.coordinates]) for part in ("noise", "quantum")
    )
    data = q + sigma * np.random.default_rng(SEED).standard_normal(q.shape)
    fine = grid > 0.0
    data[:, fine] = grid[fine] * np.round(data[:, fine] / grid[fine])
    size = f"noise of {sigma.max():.1e} as in it" if sigma.any() else "as free of noise"
    return data, f"a smooth motion like the given one, with {size}" if sigma.any() else f"a motion like it, {size}"


EVERY = 1, 2, 4, 8
FEWEST = 32
"""Samples that are left at least."""


def rate_ladder(a_plan: Plan, samples: Trajectory) -> Ladder:
    """Return the largest change of a joint's peak torque, relative to the largest peak, where samples are left out.

    Accelerations that the data do not give are derived from the samples that are left. Times are per sample of the
    data, so they tell what leaving out saves.
    """
    full = _peaks(a_plan, samples, 1)
    acts = {str(k): partial(_peaks, a_plan, samples, k) for k in EVERY if len(samples) >= FEWEST * k}
    size = a_plan.torques().size
    rate = (len(samples) - 1) / (samples.time[-1] - samples.time[0])
    names = {"1": "every sample", "2": "every 2nd"}
    rungs = []
    for k, (peaks, time) in timed(acts, 1 / len(samples)).items():
        change = float(np.abs(peaks - full).max() / (full.max() or 1.0))
        name = f"{names.get(k, f'every {k}th')}, {rate / int(k):.4g} Hz"
        rungs.append(Rung(name, (change,), time, size / int(k)))
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
