"""Friction that grows with load: a share of the torque that passes the gear, whichever way that acts.

The actuator supplies `tau = tau_l + load |tau_l| s(qd) + own friction + rotor`, where the torque through the gear tau_l
is what moves and holds the links, springs between them included.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from robodyn.dynamics.effects import coulomb_friction
from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.dynamics.effects.viscous_friction import joints_with_friction
from robodyn.dynamics.recursions.newton_euler import along_joint, newton_euler
from robodyn.programs.vectors import Scalar, sign, total
from robodyn.robot.kinematics import Motion
from robodyn.robot.kinematics import motions as motions_of
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Scene


def _loaded(model: Model, scene: Scene) -> Iterator[tuple[int, Joint, float]]:
    return ((i, joint, rub.load) for i, joint, rub in joints_with_friction(model, scene) if rub.load)


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    joints = [joint for _, joint, _ in _loaded(model, scene)]
    none, some = "no joint has friction that grows with load", "joints whose friction grows with load"
    return Verdict.of_joints(joints, ("qd", zero_columns), none, "no joint with such friction moves", some)


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    load = {
        i: share * coulomb_friction.direction(sample.speed(joint), scene.slip_speed)
        for i, joint, share in _loaded(sample.model, scene)
    }
    return replace(terms, load=load)


def lost(sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
    """sum load |tau_l| s(qd) qd [W]; terms are those of the sample's accelerations."""
    model = sample.model
    joints = motions_of(model, sample.q, terms.qd, terms.qdd)
    reactions = newton_euler(model.parents, joints, terms.inertias, terms.gravity, terms.wrenches)
    power = []
    for i, share in terms.load.items():
        joint = model.bodies[i].joint
        passed = along_joint(joint, reactions[i]) + terms.through_gear.get(i, 0.0)
        power.append(share * (passed * sign(passed)) * sample.speed(joint))
    return total(power)


EFFECT = Effect(
    "load friction",
    "load abs(tau_l) sign(qd), tau_l being what the gear passes on to the links and the springs between them",
    why,
    add,
    lost=lost,
    by_load=True,
)
