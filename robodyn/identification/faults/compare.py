"""Torques that a log measured against those computed of its motion, and what explains the difference.

1. `identification/log/log.py` reads the log: motion and measured torques.
2. `evidence_of` computes torques of the same motion, and puts both through one filter.
3. `faults/channels.py` tells torques that are exchanged or have the wrong sign.
4. `faults/faults.py` tells what explains the rest: gains, offsets, friction, rotors, delays, a payload.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from robodyn.dynamics.effects.friction import friction_of
from robodyn.dynamics.effects.motors import rotor_of
from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.errors import TrajectoryError
from robodyn.identification.faults.channels import Channels, channels, rerouted
from robodyn.identification.faults.faults import OWN, VISCOUS, Evidence, Explained, Fault, explain, rms
from robodyn.identification.log.log import REMEDY, Log, Samples, read_log
from robodyn.identification.log.rows import filtered
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats, einsum
from robodyn.trajectory.plausible import refuse_units

_FEWEST = 100
_STILL = 1e-9
"""Of the largest torque, and rad/s: what is less does not vary, or move."""


@dataclass(frozen=True)
class JointComparison:
    """A joint's measured torque beside the computed one, after the filter.

    Attributes:
        measured, computed, residual, left: RMS of both, of their difference, and of what the told faults leave of it.
        correlation: None where one of them is constant.
        effects: kind -> (value, standard error) of each of `OWN` that the log tells, be it more than noise or not.
    """

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
class Curves:
    """What plots show, (N, n) each but time (N,); `explained` has all told faults, `friction` is what of it is told."""

    time: Floats
    measured: Floats
    computed: Floats
    explained: Floats
    speed: Floats
    friction: Floats


@dataclass(frozen=True)
class Comparison:
    """Measured against computed torques.

    Attributes:
        samples: rows of the log; compared: seconds that are; cutoff: of the filter [Hz].
        relative_error, left: ||residual|| / ||measured|| over all joints, before and after all that is told.
        joints: with measured torques that vary; load_link: where a payload is looked for.
        gross: (n,) of each joint's residual, what `channels` explain.
    """

    robot: str
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
    curves: Curves = field(repr=False)


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
    raw, time, places, notes = evidence_of(log)
    right = channels(raw)
    routed = rerouted(raw, right)
    joints = {joint.rate: joint for joint in model.independent}
    present = np.zeros((len(places), 3))
    for row, place in zip(present, places, strict=True):
        friction, (inertia, gear) = friction_of(joints[place], scene), rotor_of(joints[place], scene)
        row[:] = friction.viscous, 0.5 * (friction.forward - friction.backward), gear * gear * inertia
    found = explain(routed, present)
    inside, names = raw.inside, [model.rates[place] for place in places]
    total, before = np.linalg.norm(raw.measured[inside]), rms(raw.difference)
    curves = Curves(
        time=time[inside] - log.start,
        measured=routed.measured[inside],
        computed=raw.computed[inside],
        explained=routed.measured[inside] - found.residual,
        speed=raw.own[inside, :, 0],
        friction=_friction(routed, found.faults)[inside],
    )
    return Comparison(
        robot=model.name,
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


def _friction(evidence: Evidence, faults: tuple[Fault, ...]) -> Floats:
    """Return the friction that was told (k, n), as a sensor measures it."""
    gains = {fault.effect.joint: 1.0 + fault.values[0] for fault in faults if fault.effect.kind == "gain"}
    found = np.zeros_like(evidence.computed)
    for (kind, j, _), values in ((fault.effect, fault.values) for fault in faults):
        if j is not None and kind in ("viscous", "coulomb"):
            found[:, j] += gains.get(j, 1.0) * values[0] * evidence.own[:, j, OWN.index(kind) - VISCOUS]
    return found


def load_body(model: Model) -> str:
    """Return the body at the end of the longest chain, the last of equals: what carries a payload."""
    depth: list[int] = []
    for parent in model.parents:
        depth.append(1 + (depth[parent] if parent >= 0 else 0))
    return model.bodies[max(range(len(depth)), key=lambda i: (depth[i], i))].name


def evidence_of(log: Log) -> tuple[Evidence, Floats, tuple[int, ...], list[str]]:
    """Return the evidence of a log, its times (k,), the joints in it as places in `model.rates`, and notes.

    It is of the longest stretch without gaps; joints whose torque is constant in it are left out. Raise TrajectoryError
    if none varies, or the filter leaves too few samples.
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
    values, step = values[:, places], float(np.median(np.diff(time)))
    found = Evidence(step, tau[:, places], values[..., 0], values[..., 1:4], values[..., 4:])
    return found, time, tuple(places), notes


def _columns(log: Log, samples: Samples) -> Floats:
    """Return (k, n, 4 + 10) computed torque, columns of friction and rotor, and those of a payload."""
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
    return np.where(np.isfinite(samples.tau)[..., None], found, 0.0)
