"""Logs as evidence: measured and computed torques, and what may explain their difference, through one filter."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.errors import TrajectoryError
from robodyn.identification.fault_columns import Evidence
from robodyn.identification.log import Log
from robodyn.identification.log_scan import REMEDY
from robodyn.identification.rows import filtered
from robodyn.identification.samples import Samples
from robodyn.robot.model import Model
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

_FEWEST = 100
_STILL = 1e-9
"""Of the largest torque, and rad/s: what is less does not vary, or move."""
_OWN = 4


def load_body(model: Model) -> str:
    """Return the body at the end of the longest chain, the last of equals: what carries a payload."""
    depth: list[int] = []
    for parent in model.parents:
        depth.append(1 + (depth[parent] if parent >= 0 else 0))
    return model.bodies[max(range(len(depth)), key=lambda i: (depth[i], i))].name


def evidence_of(log: Log) -> tuple[Evidence, Floats, tuple[int, ...], list[str]]:
    """Return the evidence of a log, its times (k,), the joints in it as places in `model.rates`, and notes.

    It is of the longest stretch without gaps; joints whose torque is constant in it are left out.

    Raises:
        TrajectoryError: no torque varies, or the filter leaves too few samples.
    """
    time, values, tau, notes = _stretch(log)
    places = _varying(log, tau, notes)
    step = float(np.median(np.diff(time)))
    values = values[:, places]
    own, load = values[..., 1:_OWN], values[..., _OWN:]
    return Evidence(step, tau[:, places], values[..., 0], own, load), time, tuple(places), notes


def moving(evidence: Evidence) -> list[bool]:
    """Return whether each joint moves."""
    return [bool(np.abs(speed).max() > _STILL) for speed in evidence.own[..., 0].T]


def _stretch(log: Log) -> tuple[Floats, Floats, Floats, list[str]]:
    parts = [*filtered(log, log.cutoff, lambda samples: _columns(log, samples))]
    time = np.concatenate([np.empty(0), *(part.time for part in parts)])
    steps = np.diff(time)
    gaps = np.flatnonzero(steps > 1.5 * np.median(steps)) + 1 if len(steps) else steps
    start, stop = max(pairwise([0, *map(int, gaps), len(time)]), key=lambda ends: ends[1] - ends[0])
    if stop - start < _FEWEST:
        what = f"{stop - start} samples are left by the filter of {log.cutoff:g} Hz, too few to compare"
        raise TrajectoryError(what, remedy="give a longer log, or a higher --cutoff", file=log.path)
    inside = slice(start, stop)
    values, tau = (np.concatenate([part[k] for part in parts])[inside] for k in (1, 2))
    time = time[inside]
    notes = [f"it has gaps: compared is the stretch from {time[0]:.6g} s to {time[-1]:.6g} s"] if len(gaps) else []
    return time, values, tau, notes


def _columns(log: Log, samples: Samples) -> Floats:
    """Return (k, n, 4 + 10) computed torque, columns of friction and rotor, and those of a payload."""
    model = log.model
    Y, theta, names, rest = regressor(model, samples.q, samples.qd, samples.qdd, scene=log.scene)
    place = {name: k for k, name in enumerate(names)}
    found = np.zeros((*rest.shape, _OWN + len(INERTIAL)))
    found[..., 0] = einsum("kip,p->ki", Y, theta) + rest
    for i, name in enumerate(model.rates):
        if f"{name}.viscous" in place:
            viscous, forward, backward, rotor = (
                Y[:, i, place[f"{name}.{each}"]] for each in ("viscous", "forward", "backward", "rotor")
            )
            found[:, i, 1:_OWN] = np.stack((viscous, forward - backward, rotor), axis=1)
    body = load_body(model)
    found[..., _OWN:] = Y[:, :, [place[f"{body}.{each}"] for each in INERTIAL]]
    return np.where(np.isfinite(samples.tau)[..., None], found, 0.0)


def _varying(log: Log, tau: Floats, notes: list[str]) -> list[int]:
    """Return the measured joints whose torque varies in a stretch; a note is added for each of the others."""
    names, places = log.model.rates, []
    least = _STILL * float(np.abs(tau).max())
    for k in log.measured:
        if np.ptp(tau[:, k]) > least:
            places.append(k)
        else:
            notes.append(f"{names[k]}: its measured torque is constant, {tau[:, k].mean():.4g}, and left out")
    if not places:
        raise TrajectoryError("no measured torque varies: nothing can be told", remedy=REMEDY, file=log.path)
    return places
