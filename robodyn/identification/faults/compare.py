"""Torques that a log measured against those computed of its motion, and what explains the difference.

1. `identification/log/log.py` reads the log: motion and measured torques.
2. `evidence_of` computes torques of the same motion, and puts both through one filter.
3. `told` finds torques that are exchanged, have the wrong sign, or are far too large or small.
4. `faults/faults.py` tells what explains the rest: gains, offsets, friction, rotors, delays, a payload.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.effects.friction import friction_of
from robodyn.dynamics.effects.motors import rotor_of
from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.errors import TrajectoryError
from robodyn.identification.faults.faults import OWN, VISCOUS, Evidence, Explained, Fault, explain, rms
from robodyn.identification.log.curves import add, curves_of
from robodyn.identification.log.log import REMEDY, Log, Samples, read_log
from robodyn.identification.log.rows import filtered
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.courses import Courses
from robodyn.support.floats import Floats, einsum, unit_columns
from robodyn.trajectory.plausible import refuse_units

_FEWEST = 100
_STILL = 1e-9  # of the largest torque, and rad/s: what is less does not vary, or move
_CLEAR, _LESS = 0.25, 0.7
"""Of the residual's sum of squares with channels as they are, what the right ones leave at most: as geometric mean, and
each of them."""
_FAR = 10.0  # measured torques that are so many times the computed ones, or so small a part of them, are doubtful


class Channels(NamedTuple):
    """For each joint the channel that has its torque, and with which sign, 1 or -1."""

    source: tuple[int, ...]
    sign: tuple[int, ...]

    @property
    def exchanged(self) -> list[tuple[int, ...]]:
        """The joints that have each other's torques: in each group each of the next, the last of the first."""
        left, found = [j for j, source in enumerate(self.source) if source != j], []
        while left:
            group = [left[0]]
            while self.source[group[-1]] != group[0]:
                group.append(self.source[group[-1]])
            found.append(tuple(group))
            left = [j for j in left if j not in group]
        return found

    @property
    def reversed(self) -> list[int]:
        return [j for j, sign in enumerate(self.sign) if sign < 0]

    @property
    def faults(self) -> list[tuple[int, ...]]:
        """The joints of each fault, as `words` has them."""
        return [*self.exchanged, *((j,) for j in self.reversed)]

    def words(self, names: Sequence[str]) -> list[str]:
        return [
            f"the measured torques of {', '.join(names[j] for j in first)} and {names[last]} are exchanged"
            if first
            else f"the measured torque of {names[last]} has the wrong sign"
            for *first, last in self.faults
        ]


def channels(evidence: Evidence) -> Channels:
    parts = zip(evidence.own.swapaxes(0, 1), evidence.computed.T, strict=True)
    return told([np.column_stack((own, computed, evidence.measured)) for own, computed in parts])


def rerouted(evidence: Evidence, right: Channels) -> Evidence:
    """Return evidence whose measured torques are those of the right channels."""
    return replace(evidence, measured=evidence.measured[:, list(right.source)] * np.array(right.sign, dtype=float))


def told(rows: Sequence[Floats]) -> Channels:
    """Return which measured torque is that of which joint, and with which sign.

    Each measured torque is fitted by each computed one, with either sign, beside friction and rotor inertia, which
    cannot be negative: the product of what is left is least (assignment problem). Channels differ from those of the
    log only where they leave less than `_CLEAR` of what these leave with better signs, and signs likewise.

    Args:
        rows: of each joint (k, 4 + n), or their triangular factor: torques per unit of its viscous friction, Coulomb
            friction and rotor inertia, its computed torque, and all n measured ones.
    """
    from scipy.optimize import linear_sum_assignment

    n = len(rows)
    cost = np.empty((n, n, 2))
    for i, each in enumerate(rows):
        factor = np.asarray(np.linalg.qr(each, mode="r"))
        size = (factor * factor).sum(axis=0)
        for j in range(n):
            least = 1e-12 * (size[3] + size[4 + j]) + 1e-300
            lefts = [_fitted(factor[:, :3], sign * factor[:, 4 + j] - factor[:, 3])[1] for sign in (1.0, -1.0)]
            cost[i, j] = np.array(lefts) + least
    best, own = cost.min(axis=2), np.arange(n)
    source = linear_sum_assignment(np.log(best))[1]
    found = own.copy()
    for group in map(list, Channels(tuple(map(int, source)), ()).exchanged):
        ratio = best[group, source[group]] / best[group, group]
        if np.log(ratio).mean() < np.log(_CLEAR) and (ratio < _LESS).all():
            found[group] = source[group]
    plus, minus = cost[own, found].T
    sign = np.where(minus < _CLEAR * plus, -1, 1)
    return Channels(tuple(map(int, found)), tuple(map(int, sign)))


def magnitudes(rows: Sequence[Floats], names: Sequence[str]) -> list[str]:
    """Return a line if measured torques are a multiple of the computed ones that masses seldom make, which leaves less
    than `_CLEAR` of what is left without, beside friction and rotor inertia; rows: as `told` has them."""
    far = []
    for j, (each, name) in enumerate(zip(rows, names, strict=True)):
        factor = np.asarray(np.linalg.qr(each, mode="r"))
        own, computed = factor[:, 4 + j], factor[:, 3]
        values, left = _fitted(factor[:, :4], own)
        gain = float(values[3])
        if left < _CLEAR * _fitted(factor[:, :3], own - computed)[1] and gain > 0.0 and not 1 / _FAR < gain < _FAR:
            far.append(f"{gain:.2g} ({name})")
    what = f"measured torques are {', '.join(far)} times what the description makes beside friction"
    return [f"{what}: is their unit another, or a gear?"] if far else []


def _fitted(columns: Floats, right: Floats) -> tuple[Floats, float]:
    """Return the values of columns, none of them negative, and what they leave of the squares."""
    from scipy.optimize import nnls

    unit, lengths = unit_columns(columns)
    values, left = nnls(unit, right)
    return np.asarray(values / lengths), float(left) ** 2


@dataclass(frozen=True)
class JointComparison:
    """A joint's measured torque beside the computed one, after the filter: RMS of both, of their difference, and of
    what the told faults leave of it; correlation: None where one is constant; effects: kind -> (value, standard error)
    of each of `OWN` that the log tells, be it more than noise or not."""

    name: str
    unit: str
    measured: float
    computed: float
    residual: float
    left: float
    relative_error: float
    correlation: float | None
    moves: bool
    effects: dict[str, tuple[float, float]]


@dataclass(frozen=True)
class Comparison:
    """Measured against computed torques. samples: rows of the log; compared: seconds that are; cutoff: of the filter
    [Hz]. relative_error, left: ||residual|| / ||measured|| over all joints, before and after all that is told.
    load_link: where a payload is looked for; gross: (n,) of each joint's residual, what `channels` explain; curves: as
    `curves_of` has them and every q_COORDINATE; `explained` has all told faults."""

    model: Model
    file: str
    samples: int
    duration: float
    cutoff: float
    compared: float
    relative_error: float
    left: float
    joints: tuple[JointComparison, ...]
    load_link: str
    channels: Channels
    faults: tuple[Fault, ...]
    gross: Floats
    notes: tuple[str, ...]
    curves: Courses = field(repr=False)


def compare(
    model: Model, path: str, scene: Scene = DEFAULT, *, cutoff: float | None = None, **reading: Any
) -> Comparison:
    """Return measured against computed torques of a log, and what explains the difference.

    Args:
        cutoff: of the zero-phase filter that both pass [Hz]; None: where the noise of the torques begins.

    Raises:
        TrajectoryError: the log cannot be read, can hardly be in the units that it is taken in, has no torques, none
            that varies, or is too short.
        SceneError: the scene has loops or contacts.
    """
    log = read_log(path, model, scene, cutoff=cutoff, **reading)
    refuse_units(log.caveats, path)
    raw, time, places, notes, q = evidence_of(log)
    right = channels(raw)
    routed = rerouted(raw, right)
    joints = {joint.rate: joint for joint in model.independent}
    present = np.zeros((len(places), 3))
    for row, place in zip(present, places, strict=True):
        friction, (inertia, gear) = friction_of(joints[place], scene), rotor_of(joints[place], scene)
        row[:] = friction.viscous, 0.5 * (friction.forward - friction.backward), gear * gear * inertia
    found = explain(routed, present)
    gains = {fault.effect.joint: 1.0 + fault.values[0] for fault in found.faults if fault.effect.kind == "gain"}
    friction_told = np.zeros_like(routed.computed)  # as a sensor measures it
    for (kind, j, _), values in ((fault.effect, fault.values) for fault in found.faults):
        if j is not None and kind in ("viscous", "coulomb"):
            friction_told[:, j] += gains.get(j, 1.0) * values[0] * routed.own[:, j, OWN.index(kind) - VISCOUS]
    inside, names = raw.inside, [model.rates[place] for place in places]
    total, before = np.linalg.norm(raw.measured[inside]), rms(raw.difference)
    curves = curves_of(names, [f"q_{name}" for name in model.coordinates])
    explained = routed.measured[inside] - found.residual
    torques = routed.measured[inside], raw.computed[inside], explained, friction_told[inside]
    add(curves, time[inside] - log.start, (raw.own[inside, :, 0], *torques), [*q[inside].T])
    return Comparison(
        model=model,
        file=path,
        samples=log.samples,
        duration=log.stop - log.start,
        cutoff=log.cutoff,
        compared=float(np.ptp(time[inside])),
        relative_error=float(np.linalg.norm(raw.difference) / total),
        left=float(np.linalg.norm(found.residual) / total),
        joints=tuple(_joint(model, name, raw, found, j) for j, name in enumerate(names)),
        load_link=load_body(model),
        channels=right,
        faults=found.faults,
        gross=np.asarray(1.0 - (rms(routed.difference) / np.where(before > 0.0, before, 1.0)) ** 2),
        notes=(*log.notes, *notes),
        curves=curves,
    )


def _joint(model: Model, name: str, raw: Evidence, found: Explained, j: int) -> JointComparison:
    prismatic = any(body.joint.name == name and body.joint.kind == "prismatic" for body in model.bodies)
    measured, computed = raw.measured[raw.inside, j], raw.computed[raw.inside, j]
    a, b = measured - measured.mean(), computed - computed.mean()
    spread = float(np.linalg.norm(a) * np.linalg.norm(b))
    four = np.column_stack((measured, computed, measured - computed, found.residual[:, j]))
    size, of_computed, residual, left = rms(four).tolist()
    errors, first = np.sqrt(np.diag(found.covariance)), len(OWN) * j
    places = {kind: first + k for k, kind in enumerate(OWN) if first + k in found.told}
    return JointComparison(
        name=name,
        unit="N" if prismatic else "N m",
        measured=size,
        computed=of_computed,
        residual=residual,
        left=left,
        relative_error=residual / size,
        correlation=float(a @ b) / spread if spread > 0.0 else None,
        moves=bool(np.abs(raw.own[:, j, 0]).max() > _STILL),
        effects={kind: (float(found.theta[place]), float(errors[place])) for kind, place in places.items()},
    )


def load_body(model: Model) -> str:
    """Return the body at the end of the longest chain, the last of equals: what carries a payload."""
    depth: list[int] = []
    for parent in model.parents:
        depth.append(1 + (depth[parent] if parent >= 0 else 0))
    return model.bodies[max(range(len(depth)), key=lambda i: (depth[i], i))].name


def evidence_of(log: Log) -> tuple[Evidence, Floats, tuple[int, ...], list[str], Floats]:
    """Return the evidence of the longest stretch of a log without gaps, its times (k,), the joints whose torque varies
    in it as places in `model.rates`, notes, and positions (k, n).

    Raises:
        TrajectoryError: no torque varies, or too few samples are left.
    """
    parts = [*filtered(log, log.cutoff, lambda samples: _columns(log, samples))]
    time = np.concatenate([np.empty(0), *(part.time for part in parts)])
    steps = np.diff(time)
    gaps = np.flatnonzero(steps > 1.5 * np.median(steps)) + 1 if len(steps) else steps
    start, stop = max(pairwise([0, *map(int, gaps), len(time)]), key=lambda ends: ends[1] - ends[0])
    if stop - start < _FEWEST:
        what = f"{stop - start} samples are left by the filter of {log.cutoff:g} Hz, too few to compare"
        raise TrajectoryError(what, remedy="give a longer log, or a higher --cutoff", file=log.path)
    values, tau = (np.concatenate([part[k] for part in parts])[start:stop] for k in (1, 2))
    time, names, notes, places = time[start:stop], log.model.rates, list[str](), list[int]()
    if len(gaps):
        notes.append(f"it has gaps: compared is the stretch from {time[0]:.6g} s to {time[-1]:.6g} s")
    least = _STILL * float(np.abs(tau).max())
    for k in log.measured:
        if np.ptp(tau[:, k]) > least:
            places.append(k)
        else:
            notes.append(f"{names[k]}: its measured torque is constant, {tau[:, k].mean():.4g}, and left out")
    if not places:
        raise TrajectoryError("no measured torque varies: nothing can be told", remedy=REMEDY, file=log.path)
    q, values, step = values[..., -1], values[:, places], float(np.median(np.diff(time)))
    found = Evidence(step, tau[:, places], values[..., 0], values[..., 1:4], values[..., 4:-1])
    return found, time, tuple(places), notes, q


def _columns(log: Log, samples: Samples) -> Floats:
    """Return (k, n, 4 + 10 + 1) computed torque, columns of friction and rotor, those of a payload, and positions."""
    model = log.model
    qd = np.where(np.abs(samples.qd) > _STILL, samples.qd, 0.0)  # the sign of rounding is none
    Y, theta, names, rest = regressor(model, samples.q, qd, samples.qdd, scene=log.scene)
    place = {name: k for k, name in enumerate(names)}
    found = np.zeros((*rest.shape, 4 + len(INERTIAL)))
    found[..., 0] = einsum("kip,p->ki", Y, theta) + rest
    for i, name in enumerate(model.rates):
        if f"{name}.viscous" in place:
            viscous, forward, backward, rotor = (
                Y[:, i, place[f"{name}.{each}"]] for each in ("viscous", "forward", "backward", "rotor")
            )
            found[:, i, 1:4] = np.stack((viscous, forward - backward, rotor), axis=1)
    body = load_body(model)
    found[..., 4:] = Y[:, :, [place[f"{body}.{each}"] for each in INERTIAL]]
    found = np.where(np.isfinite(samples.tau)[..., None], found, 0.0)
    return np.concatenate((found, samples.q[..., None]), axis=2)
