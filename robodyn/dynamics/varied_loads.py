"""Loads of a robot whose parameters theta are changed, and their derivatives by theta; see `Variations`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.effects.friction import coulomb_torque, direction
from robodyn.dynamics.effects.motors import acceleration_of, at_joints, coupled_motors, speed_of, spins, with_spins
from robodyn.dynamics.plan import Plan, loads, runner_of
from robodyn.dynamics.regressor import INERTIAL
from robodyn.dynamics.variations import Variation, Variations
from robodyn.programs.derivative import jacobian
from robodyn.programs.program import trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape, Traced
from robodyn.programs.vectors import Scalar, total, vector
from robodyn.scene.fit import refuse_constraints
from robodyn.solids.inertia.laws import Inertia, combined, symmetric

Row = Sequence[tuple[int, float]]
"""A sum of loads, each by its number and its weight; loads are numbered as `Plan.wrenches` has them, with joints."""


def summed(rows: Iterable[Row], loads: Sequence[Any]) -> list[Any]:
    """Return the sums of some loads, scalars or arrays."""
    return [total(loads[k] if weight == 1.0 else weight * loads[k] for k, weight in row) for row in rows]


def derivative_runner(plan: Plan, found: Variations, rows: Sequence[Row]) -> Runner:
    """Return the derivatives of sums of loads by theta, at a given `theta`: for each sum in turn those by all of theta.

    Accuracy: as that of the loads.
    """
    refuse_constraints(plan.scene)

    def outputs(tape: Tape) -> Iterable[Scalar]:
        theta = _theta(tape, found)
        sums = summed(rows, _loads(plan, tape, theta, found))
        return [entry for row in jacobian(sums, [{each: 1.0} for each in theta]) for entry in row]

    return runner_of(trace(outputs), plan, {"theta": len(found.jacobian)})


def _theta(tape: Tape, found: Variations) -> list[Traced]:
    return [tape.input("theta", k) for k, _ in enumerate(found.jacobian)]


def _loads(plan: Plan, tape: Tape, theta: Sequence[Scalar], found: Variations) -> list[Scalar]:
    """Return the loads of a robot with more moments, friction and rotors."""
    sample, terms = plan.terms(tape)
    inertias, width = list(terms.inertias), len(INERTIAL)
    for k, body in enumerate(found.bodies):
        m, x, y, z, *moments = theta[width * k : width * (k + 1)]
        inertias[body] = combined((inertias[body], Inertia(m, vector(x, y, z), symmetric(moments))))
    at_joints = [each for each in found.each if not each.moments]
    terms = replace(terms, inertias=tuple(inertias))
    result = loads(sample, _with_joints(terms, sample, plan, theta[width * len(found.bodies) :], at_joints))
    return [*result.tau, *(scalar for wrench in result.reactions for part in wrench for scalar in part)]


def _with_joints(terms: Terms, sample: Sample, plan: Plan, x: Sequence[Scalar], each: Sequence[Variation]) -> Terms:
    """Return the terms with more friction, which is linear in its coefficients, and more inertia of rotors."""
    of = {body.joint.name: [(i, body.joint, 1.0)] for i, body in enumerate(sample.model.bodies)}
    of |= {motor.name: turned for motor, turned in coupled_motors(sample.model, plan.scene)}
    torques: list[tuple[int, Scalar]] = []
    spinning, load = [], dict(terms.load)
    rotors = {spin.joint.name: spin for spin in spins(sample.model, plan.scene)}
    for scalar, variation in zip(x, each, strict=True):
        turned, friction = of[variation.joint], variation.friction
        speed, acceleration = speed_of(sample, turned), acceleration_of(sample, turned)
        dry = coulomb_torque(friction, speed, plan.scene.slip_speed) if friction.dry else 0.0
        torque = friction.viscous * speed + dry + variation.rotor * acceleration
        torques += at_joints(turned, scalar * torque)
        if friction.load:
            i, way = turned[0][0], direction(speed, plan.scene.slip_speed)
            load[i] = load.get(i, 0.0) + scalar * (friction.load * way)
        if variation.rotor and variation.joint in rotors:
            spin = rotors[variation.joint]
            spinning.append((spin, scalar * (variation.rotor / spin.gear)))
    return with_spins(replace(terms, load=load).with_torques(torques), sample, spinning)
