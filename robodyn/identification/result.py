"""What identification found, and the same in the words of descriptions and scenes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robodyn.dynamics.effects.friction import friction_of
from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.identification.calibrated import calibrated
from robodyn.identification.model_selection import Structure
from robodyn.identification.parameters.base import Base
from robodyn.robot.model import Model
from robodyn.scene.scene import CoupledMotor, Friction, Scene
from robodyn.scene.uncertainty import Covariance
from robodyn.support.floats import Floats


@dataclass(frozen=True)
class Errors:
    """||computed - measured|| / ||measured|| in N m, both sides filtered; of all joints together, and by joint."""

    relative_error: float
    joints: Mapping[str, float]


@dataclass(frozen=True)
class MotorFit:
    """What was found of a motor, joint side.

    Attributes:
        joints: how it turns with joints: {"wrist": 1.0}; of a joint's own motor that joint alone.
        viscous: N m s/rad; coulomb, offset: half the difference and half the sum of friction forwards and backwards
            [N m]; rotor: reflected inertia [kg m^2]; load: friction as a part of the torque that passes the gear.
        stribeck: torque of breakaway [N m], which decays with `stribeck_velocity` [rad/s].
    """

    joints: Mapping[str, float]
    viscous: float
    coulomb: float
    offset: float
    rotor: float
    stribeck: float | None = None
    stribeck_velocity: float | None = None
    load: float | None = None


@dataclass(frozen=True, eq=False)
class BaseFit:
    """Base parameters (r,) by least squares without bounds, with their covariance; and by the consistent parameters."""

    base: Base
    values: Floats
    covariance: Floats
    consistent: Floats

    @property
    def standard_errors(self) -> Floats:
        return np.sqrt(np.diagonal(self.covariance))


@dataclass(frozen=True, eq=False)
class Identified:
    """A description that explains logs.

    Attributes:
        names, described, theta: of `robodyn.regressor` of `model` in `scene`: before and after.
        scene: the given one with what was found of friction and rotors.
        coupled: names of motors of two joints, and what part of the squares of both joints' residuals they leave.
        train, held_out: of the consistent parameters; `bound_*` of least squares without bounds; `original_*` of the
            description. None where nothing is held out.
        discrepancy: by joint, standard error of torques of another motion beside that of the parameters, for what the
            model has not [N m]; delays: by joint, how late its torque is logged, which was taken out [s].
        alone: relative error of held-out torques (all, where none are held out) by the calibrated description without
            its scene: without rotors, coupled motors, and what friction is beside viscous and Coulomb's.
        strength: of the prior, chosen by cross-validation.
        cutoff: of the filter on both sides [Hz]; slip_speed: below which friction is smoothed [rad/s].
        consistent: whether every body that is shown can exist; unseen: bodies of which no torque shows anything.
        rows: that were compared, of all joints; samples: rows of the logs.
        faults: torques that are exchanged or have the wrong sign, and units that are doubtful, a line each, which are
            among the warnings.
    """

    model: Model
    scene: Scene
    names: tuple[str, ...]
    described: Floats
    theta: Floats
    base: BaseFit
    motors: Mapping[str, MotorFit]
    coupled: Mapping[str, float]
    train: Errors
    held_out: Errors | None
    bound_train: Errors
    bound_held_out: Errors | None
    original_train: Errors
    original_held_out: Errors | None
    discrepancy: Mapping[str, float]
    delays: Mapping[str, float]
    alone: float
    strength: float
    cutoff: float
    slip_speed: float
    consistent: bool
    unseen: tuple[str, ...]
    rows: int
    samples: int
    duration: float
    hashes: Mapping[str, str]
    faults: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def explains(self) -> bool:
        """Whether less than half of held-out torques (of all, where none are held out) is left."""
        return (self.held_out or self.train).relative_error < 0.5

    @property
    def better(self) -> bool:
        """Whether held-out torques (all, where none are held out) are explained better than by the description
        and by zero."""
        new, old = self.held_out or self.train, self.original_held_out or self.original_train
        return new.relative_error < min(old.relative_error, 1.0)


def motor_fits(structure: Structure, theta: Floats) -> dict[str, MotorFit]:
    found, fits = dict(zip(structure.names, theta.tolist(), strict=True)), {}
    for k, shape in structure.shapes.items():
        motor = structure.regressor.motors[k]
        turned = np.flatnonzero(motor.direction)
        joints = {structure.regressor.model.rates[j]: float(motor.direction[j]) for j in turned}
        values = {name.rpartition(".")[2]: found[name] for name in shape.names(motor)}
        fits[motor.name] = MotorFit(joints, stribeck_velocity=shape.stribeck, **values)
    return fits


def outcome(
    model: Model, scene: Scene, structure: Structure, theta: Floats, slip_speed: float
) -> tuple[tuple[str, ...], Floats, Floats, Scene]:
    """Return names and values before and after of what was found, as `robodyn.regressor` has them, and the scene."""
    joints = {body.joint.name: body.joint for body in model.bodies}
    motors = motor_fits(structure, theta)
    friction, coupled = dict(scene.friction), {motor.name: motor for motor in scene.coupled}
    for name, fit in motors.items():
        if name in joints:
            friction[name] = _as_shaped(friction_of(joints[name], scene), fit)
        else:
            before = coupled.get(name, CoupledMotor(name, fit.joints))
            coupled[name] = replace(before, friction=_as_shaped(before.friction, fit))
    bare = replace(scene, payloads=(), friction=friction, coupled=tuple(coupled.values()))
    zero = np.zeros(model.n)
    found = regressor(model, zero, zero, zero, scene=bare)
    values = dict(zip(found.names, found.theta.tolist(), strict=True))
    pairs = zip(structure.names, theta.tolist(), strict=True)
    values |= {name: value for name, value in pairs if name.rpartition(".")[2] in INERTIAL}
    for name, fit in motors.items():
        values |= {f"{name}.viscous": fit.viscous, f"{name}.rotor": fit.rotor}
        forward, backward = max(fit.offset + fit.coulomb, 0.0), min(fit.offset - fit.coulomb, 0.0)
        values |= {f"{name}.forward": forward, f"{name}.backward": backward}
        if fit.stribeck is not None:
            values[f"{name}.stribeck"] = fit.stribeck
    after = np.array([values[name] for name in found.names])
    whole = calibrated(model, found.names, after, bare)
    return found.names, found.theta, after, replace(whole, slip_speed=slip_speed, payloads=scene.payloads)


def _as_shaped(old: Friction, fit: MotorFit) -> Friction:
    """Return a friction that grows with load, and has Stribeck's excess or none, as what was fitted."""
    new = replace(old, load=fit.load or 0.0, stribeck=None)
    if fit.stribeck is None:
        return new
    return replace(new, stribeck=old.stribeck or old.dry, stribeck_velocity=fit.stribeck_velocity or 0.0)


def covariance(found: Identified) -> Covariance:
    """Return the calibrated parameters with the covariance of the base parameters, carried by those that name groups.

    The others of each group are taken for known, which changes no torque of a motion that shows no more than the log.
    What the model has not is a constant torque of each joint, unknown by its discrepancy: friction forwards and
    backwards, and, where that is, of breakaway.
    """
    loads = {f"{name}.load": found.scene.friction[name].load for name in found.scene.loaded}
    names, theta = (*found.names, *loads), np.append(found.theta, list(loads.values()))
    carried = carriers(found.base.base, names)
    C = carried @ found.base.covariance @ carried.T
    for name, deviation in found.discrepancy.items():
        constant = np.array([each in (f"{name}.forward", f"{name}.backward") for each in names], dtype=float)
        C += deviation**2 * np.outer(constant, constant)
        C += np.diag([deviation**2 * (each == f"{name}.stribeck") for each in names])
    own = np.flatnonzero(np.diagonal(C) > 0.0)
    C = C[np.ix_(own, own)]
    return Covariance(tuple(names[k] for k in own), theta[own], (C + C.T) / 2.0)


def carriers(base: Base, names: Sequence[str]) -> Floats:
    """Return (p, r) how much of each of `names` of `robodyn.regressor` stands for each base parameter."""
    places = {name: k for k, name in enumerate(names)}
    carried = np.zeros((len(names), base.rank))
    for column, k in enumerate(base.independent):
        motor, _, kind = base.names[k].rpartition(".")
        parts = {base.names[k]: 1.0}
        if kind in ("coulomb", "offset"):
            parts = {f"{motor}.forward": 1.0, f"{motor}.backward": 1.0 if kind == "offset" else -1.0}
        for name in parts.keys() & places.keys():
            carried[places[name], column] = parts[name]
    return carried
