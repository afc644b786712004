"""A robot in a scene and a state as a system of single bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.effects.rotor_inertia import armatures
from robodyn.dynamics.plan import applied
from robodyn.equations.dae.joints import joint_connections, loop_connections, mimic_connections
from robodyn.equations.dae.state import State, state_of
from robodyn.equations.dae.system import Matrices, System, matrices
from robodyn.equations.jobs import bias_plan
from robodyn.programs.vectors import Scalar, length
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Posed:
    """A robot taken apart.

    Attributes:
        sample, terms: the motion without acceleration, and what the scene's effects make of it.
        system: its bodies, joints, mimic rules and loops.
        at: where the bodies are.
        matrices: of the equations of motion there, with the torques tau.
        length: of the robot: the largest distance between a mass centre and a joint [m], 1 where all are zero.
    """

    model: Model
    scene: Scene
    sample: Sample
    terms: Terms
    tau: Sequence[Scalar]
    system: System
    at: State
    matrices: Matrices
    length: float


def posed(model: Model, scene: Scene, q: Sequence[Scalar], qd: Sequence[Scalar], tau: Sequence[Scalar]) -> Posed:
    """The robot in a state; `q`, `qd` and `tau` may be any scalar.

    Raises:
        InputError: the scene does not fit the model.
    """
    sample = Sample(model, tuple(q), tuple(qd), (0.0,) * model.n)
    terms = applied(bias_plan(model, scene).effects, sample, scene)
    centres = [inertia.centre_of_mass for inertia in terms.inertias]
    joints = joint_connections(model, centres, sample.q)
    mimics, loops = tuple(mimic_connections(model, joints)), tuple(loop_connections(model, centres, scene.loops))
    rotors = {i: inertia for i, _, inertia in armatures(model, scene)}
    system = System(terms.inertias, joints, mimics, loops, rotors)
    at = state_of(model, centres, sample.q, sample.qd)
    found = matrices(system, at, terms.gravity, terms.wrenches, along_joints(model, system, terms, tau))
    arms = [*centres, *(body.joint.p - centres[body.parent] for body in model.bodies if body.parent >= 0)]
    size = max(length(np.asarray(arm, dtype=float)) for arm in arms) or 1.0
    return Posed(model, scene, sample, terms, tau, system, at, found, size)


def along_joints(model: Model, system: System, terms: Terms, tau: Sequence[Scalar]) -> list[Scalar]:
    """What acts along each joint's own coordinates: tau at the joint it belongs to, less friction and springs."""
    out: list[Scalar] = []
    for i, (body, connection) in enumerate(zip(model.bodies, system.joints, strict=True)):
        joint, taken = body.joint, terms.at_joint.get(i, 0.0)
        for k in range(len(connection.free)):
            out.append((0.0 if joint.mimics is not None else tau[joint.rate + k]) - taken)
    return out


def own_rates(model: Model, system: System, along: Sequence[Scalar]) -> list[Scalar]:
    """The n entries, in the order of `model.rates`, out of those of all joints in the order of the bodies."""
    out: list[Scalar] = [0.0] * model.n
    start = 0
    for body, connection in zip(model.bodies, system.joints, strict=True):
        width = len(connection.free)
        if body.joint.mimics is None:
            out[body.joint.rate : body.joint.rate + width] = along[start : start + width]
        start += width
    return out
