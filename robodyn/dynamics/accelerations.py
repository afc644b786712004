"""The program of forward dynamics: qdd from q, qd and tau, all effects of a plan together."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.effects.rotor_inertia import reflected
from robodyn.dynamics.plan import Plan, applied
from robodyn.dynamics.recursions.aligned import aligned
from robodyn.dynamics.recursions.articulated_body import articulated_body
from robodyn.dynamics.recursions.newton_euler import inertial_wrenches
from robodyn.programs.program import Program, trace
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar
from robodyn.robot.kinematics import motions
from robodyn.robot.model import Joint, Model
from robodyn.robot.motion_types import Wrench
from robodyn.scene.fit import refuse_loops


def acceleration_program(plan: Plan) -> Program:
    """The program of qdd from q, qd and tau, which is another input; `plan.still` may name its entries too."""
    refuse_loops(plan.scene)
    model, scene, still = aligned(plan.model), plan.scene, plan.still

    def outputs(tape: Tape) -> Iterable[Scalar]:
        sample = replace(Plan(model, scene, still).sample(tape), qdd=(0.0,) * model.n)
        tau = [0.0 if ("tau", i) in still else tape.input("tau", i) for i in range(model.n)]
        return accelerations(sample, applied(plan.effects, sample, scene), tau, reflected(model, scene))

    return trace(outputs)


def accelerations(sample: Sample, terms: Terms, tau: Sequence[Scalar], rotors: Sequence[float]) -> list[Scalar]:
    """qdd of one sample, in whatever scalar it is made of.

    Args:
        sample: of a model of `aligned`.
        terms: without acceleration.
        tau: n scalars.
        rotors: n reflected rotor inertias.
    """
    model = sample.model
    joints = motions(model, sample.q, terms.qd, terms.qdd)
    biases = inertial_wrenches(model.parents, joints, terms.inertias, terms.gravity)
    for i, wrench in terms.wrenches:
        biases[i] = Wrench(biases[i].f - wrench.f, biases[i].n - wrench.n)
    forces = list(tau)
    for i, torque in terms.at_joint.items():
        joint = model.bodies[i].joint
        forces[joint.rate] = forces[joint.rate] - joint.multiplier * torque
    free = [(joint, joint.R.T @ joints[i].R) for i, joint in _floating(model)]
    for joint, turn in free:
        place = slice(joint.rate + 3, joint.rate + 6)
        forces[place] = turn.T @ np.array(forces[place])
    qdd = articulated_body(model, joints, terms.inertias, biases, forces, rotors)
    for joint, turn in free:
        place = slice(joint.rate + 3, joint.rate + 6)
        qdd[place] = turn @ np.array(qdd[place])
    return qdd


def _floating(model: Model) -> list[tuple[int, Joint]]:
    return [(i, body.joint) for i, body in enumerate(model.bodies) if body.joint.kind == "floating"]
