"""What was fitted, in the words of descriptions and scenes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.friction import friction_of
from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.identification.base import Base
from robodyn.identification.calibrated_scene import calibrated
from robodyn.identification.identified import Identified, MotorFit
from robodyn.identification.structure import Structure
from robodyn.robot.model import Model
from robodyn.scene.parts import CoupledMotor, Friction
from robodyn.scene.scene import Scene
from robodyn.scene.uncertainty import Covariance
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum


class Outcome(NamedTuple):
    """Parameters of `robodyn.regressor` in `scene` before and after, and the scene with what was found."""

    names: tuple[str, ...]
    described: Floats
    theta: Floats
    scene: Scene


def motor_fits(structure: Structure, theta: Floats) -> dict[str, MotorFit]:
    """Return what was found of every motor."""
    found = dict(zip(structure.names, theta.tolist(), strict=True))
    fits = {}
    for k, shape in structure.shapes.items():
        motor = structure.atoms.motors[k]
        joints = {structure.atoms.model.rates[j]: float(motor.direction[j]) for j in np.flatnonzero(motor.direction)}
        values = {name.rpartition(".")[2]: found[name] for name in shape.names(motor)}
        fits[motor.name] = MotorFit(joints, stribeck_velocity=shape.stribeck, **values)
    return fits


def outcome(model: Model, scene: Scene, structure: Structure, theta: Floats, slip_speed: float) -> Outcome:
    """Return what was found, as `robodyn.regressor` names it, in the scene without its payloads.

    Args:
        theta: of `structure.names`.
    """
    joints = {body.joint.name: body.joint for body in model.bodies}
    motors = motor_fits(structure, theta)
    friction, coupled = dict(scene.friction), {motor.name: motor for motor in scene.coupled}
    for name, fit in motors.items():
        if name in joints:
            old = friction_of(joints[name], scene)
            friction[name] = _as_shaped(old, fit)
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
    return Outcome(found.names, found.theta, after, replace(whole, slip_speed=slip_speed, payloads=scene.payloads))


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
    C = einsum("ar,rs,bs->ab", carried, found.base.covariance, carried)
    for name, deviation in found.discrepancy.items():
        constant = np.array([each in (f"{name}.forward", f"{name}.backward") for each in names], dtype=float)
        C += np.outer(deviation * constant, deviation * constant)
        C += np.diag([deviation**2 * (each == f"{name}.stribeck") for each in names])
    own = np.flatnonzero(np.diagonal(C) > 0.0)
    C = C[np.ix_(own, own)]
    return Covariance(tuple(names[k] for k in own), theta[own], (C + C.T) / 2.0)


def carriers(base: Base, names: Sequence[str]) -> Floats:
    """Return (p, r) how much of each of `names` of `robodyn.regressor` stands for each base parameter."""
    places = {name: k for k, name in enumerate(names)}
    carried = np.zeros((len(names), base.rank))
    for column, k in enumerate(base.independent):
        for name, part in _meant(base.names[k]):
            if name in places:
                carried[places[name], column] = part
    return carried


def _meant(name: str) -> tuple[tuple[str, float], ...]:
    """Return the parameters of `robodyn.regressor` that one of a motor stands for, and how much of each."""
    motor, _, kind = name.rpartition(".")
    if kind in ("coulomb", "offset"):
        return (f"{motor}.forward", 1.0), (f"{motor}.backward", 1.0 if kind == "offset" else -1.0)
    return ((name, 1.0),)
