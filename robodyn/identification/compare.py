"""Torques that a log measured against those computed of its motion, and what explains the difference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from robodyn.dynamics.effects.friction import friction_of
from robodyn.dynamics.effects.motors import rotor_of
from robodyn.identification.evidence import evidence_of, load_body, moving
from robodyn.identification.fault_columns import OWN, VISCOUS, Evidence, rms
from robodyn.identification.faults import Explained, Fault, explain
from robodyn.identification.gross_faults import Channels, channels, rerouted
from robodyn.identification.log import read_log
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum
from robodyn.trajectory.plausible import refuse_units


@dataclass(frozen=True)
class JointComparison:
    """A joint's measured torque beside the computed one, after the filter.

    Attributes:
        name, unit: "N m" or "N".
        measured, computed, residual, left: RMS of both, of their difference, and of what the told faults leave of it.
        relative_error: ||residual|| / ||measured||.
        correlation: of measured and computed torque; None where one of them is constant.
        moves: whether the joint moves.
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
    """What plots show, (N, n) each but time (N,): torques, their residuals, speeds, and friction that was told.

    Attributes:
        explained: computed torque with all told faults; friction: what of it is told friction.
    """

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
        robot, file: names; samples: rows of the log; duration: s.
        cutoff: of the filter [Hz]; compared: seconds that are compared.
        relative_error, left: ||residual|| / ||measured|| over all joints, before and after all that is told.
        joints: with measured torques that vary.
        load_link: where a payload is looked for.
        channels: which measured torque is that of which joint; faults: see `Explained`.
        gross: (n,) of each joint's residual, what `channels` explain.
        notes: on the log.
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
        reading: of `robodyn.read_motion`.

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
    found = explain(routed, present_in(model, scene, places))
    inside = raw.inside
    names = [model.rates[place] for place in places]
    computed, difference = raw.computed[inside], (raw.measured - raw.computed)[inside]
    total = _total(raw.measured[inside])
    explained = routed.measured[inside] - found.residual
    friction, speed = _friction(routed, found.faults)[inside], raw.own[inside, :, 0]
    return Comparison(
        robot=model.name,
        file=path,
        samples=log.samples,
        duration=log.stop - log.start,
        cutoff=log.cutoff,
        compared=float(np.ptp(time[inside])),
        relative_error=_total(difference) / total,
        left=_total(found.residual) / total,
        joints=tuple(_joint(model, name, raw, found, j) for j, name in enumerate(names)),
        load_link=load_body(model),
        channels=right,
        faults=found.faults,
        gross=_explained(difference, found.difference),
        notes=(*log.notes, *notes),
        curves=Curves(time[inside] - log.start, routed.measured[inside], computed, explained, speed, friction),
    )


def present_in(model: Model, scene: Scene, places: Sequence[int]) -> Floats:
    """Return (n, 3) viscous and Coulomb friction and reflected rotor inertia of joints, by their places in tau."""
    found = np.zeros((len(places), 3))
    joints = {joint.rate: joint for joint in model.independent}
    for row, place in zip(found, places, strict=True):
        friction, (inertia, gear) = friction_of(joints[place], scene), rotor_of(joints[place], scene)
        row[:] = friction.viscous, 0.5 * (friction.forward - friction.backward), gear * gear * inertia
    return found


def _joint(model: Model, name: str, raw: Evidence, found: Explained, j: int) -> JointComparison:
    """Return what there is to say of a joint, of the torques that were measured as its."""
    prismatic = any(body.joint.name == name and body.joint.kind == "prismatic" for body in model.bodies)
    measured, computed = raw.measured[raw.inside, j], raw.computed[raw.inside, j]
    size, of_computed, residual, left = (
        float(rms(each[:, None])[0]) for each in (measured, computed, measured - computed, found.residual[:, j])
    )
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
        correlation=_correlation(measured, computed),
        moves=moving(raw)[j],
        effects={kind: (float(found.theta[place]), float(errors[place])) for kind, place in places.items()},
    )


def _friction(evidence: Evidence, faults: tuple[Fault, ...]) -> Floats:
    """Return the friction that was told (k, n), as a sensor measures it."""
    gains = {fault.effect.joint: 1.0 + fault.values[0] for fault in faults if fault.effect.kind == "gain"}
    found = np.zeros_like(evidence.computed)
    for effect, values in ((fault.effect, fault.values) for fault in faults):
        if effect.joint is not None and effect.kind in ("viscous", "coulomb"):
            size = gains.get(effect.joint, 1.0) * values[0]
            found[:, effect.joint] += size * evidence.own[:, effect.joint, OWN.index(effect.kind) - VISCOUS]
    return found


def _total(values: Floats) -> float:
    return float(np.sqrt(einsum("ki,ki", values, values)))


def _explained(before: Floats, after: Floats) -> Floats:
    """Return the share of each column's sum of squares that is gone."""
    size = rms(before)
    return np.asarray(1.0 - (rms(after) / np.where(size > 0.0, size, 1.0)) ** 2)


def _correlation(a: Floats, b: Floats) -> float | None:
    a, b = a - a.mean(), b - b.mean()
    size = float(np.sqrt(einsum("k,k", a, a) * einsum("k,k", b, b)))
    return float(einsum("k,k", a, b)) / size if size > 0.0 else None
