"""Loads of a robot whose parameters theta are changed, and their derivatives by theta; see `Variations`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from robodyn.dynamics.effects import coulomb_friction
from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.plan import Plan, loads
from robodyn.dynamics.regressor import INERTIAL
from robodyn.dynamics.runners import runner_of
from robodyn.dynamics.variations import Variation, Variations
from robodyn.programs.derivative import jacobian
from robodyn.programs.program import trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape, Traced
from robodyn.programs.vectors import Scalar, vector
from robodyn.scene.fit import refuse_constraints
from robodyn.solids.inertia.laws import Inertia, combined, symmetric


def derivative_runner(plan: Plan, found: Variations, joints: bool) -> Runner:
    """Return d loads / d theta at a given `theta`: for each load in turn its derivatives by all of theta.

    Loads are tau, the base wrench, and with `joints` the wrench of every joint's body, as `Plan.wrenches` has them.

    Accuracy: as that of the loads.
    """
    refuse_constraints(plan.scene)

    def outputs(tape: Tape) -> Iterable[Scalar]:
        theta = _theta(tape, found)
        rows = jacobian(_loads(plan, tape, theta, found, joints), [{each: 1.0} for each in theta])
        return [entry for row in rows for entry in row]

    return runner_of(trace(outputs), plan, {"theta": len(found.jacobian)})


def varied_runner(plan: Plan, found: Variations, joints: bool) -> Runner:
    """Return the loads of a given `theta`, by which parameters are off."""
    refuse_constraints(plan.scene)
    program = trace(lambda tape: _loads(plan, tape, _theta(tape, found), found, joints))
    return runner_of(program, plan, {"theta": len(found.jacobian)})


def _theta(tape: Tape, found: Variations) -> list[Traced]:
    return [tape.input("theta", k) for k, _ in enumerate(found.jacobian)]


def _loads(plan: Plan, tape: Tape, theta: Sequence[Scalar], found: Variations, joints: bool) -> list[Scalar]:
    """Return the loads of a robot with more moments, friction and rotors."""
    sample, terms = plan.terms(tape)
    inertias, width = list(terms.inertias), len(INERTIAL)
    for k, body in enumerate(found.bodies):
        m, x, y, z, *moments = theta[width * k : width * (k + 1)]
        inertias[body] = combined((inertias[body], Inertia(m, vector(x, y, z), symmetric(moments))))
    at_joints = [each for each in found.each if not each.moments]
    terms = replace(terms, inertias=tuple(inertias))
    result = loads(sample, _with_joints(terms, sample, plan, theta[width * len(found.bodies) :], at_joints))
    wrenches = result.reactions if joints else result.reactions[:1]
    return [*result.tau, *(scalar for wrench in wrenches for part in wrench for scalar in part)]


def _with_joints(terms: Terms, sample: Sample, plan: Plan, x: Sequence[Scalar], each: Sequence[Variation]) -> Terms:
    """Return the terms with more friction, which is linear in its coefficients, and more inertia of rotors."""
    of = {body.joint.name: (i, body.joint) for i, body in enumerate(sample.model.bodies)}
    torques = []
    for scalar, variation in zip(x, each, strict=True):
        i, joint = of[variation.joint]
        speed, friction = sample.speed(joint), variation.friction
        dry = coulomb_friction.torque(friction, speed, plan.scene.slip_speed) if friction.dry else 0.0
        torque = friction.viscous * speed + dry + variation.rotor * sample.acceleration(joint)
        torques.append((i, scalar * torque))
    return terms.with_torques(torques)
