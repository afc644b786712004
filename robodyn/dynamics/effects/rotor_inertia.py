"""Rotor inertia: the motors' rotors turn G times as fast as their joints and add G^2 J qdd.

The rotors' own gyroscopic moments on the links are not part of this model, as in MuJoCo's armature and the Robotics
Toolbox; where a scene says a rotor's axis, `gyroscopic_moment` adds them.
"""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.programs.vectors import Scalar, total
from robodyn.robot.kinematics import Motion
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Scene


def rotor_of(joint: Joint, scene: Scene) -> tuple[float, float]:
    """Return the rotor inertia [kg m^2] and the gear ratio of a joint: the scene's word, else its transmission's."""
    rotor = scene.rotor.get(joint.name)
    inertia, gear = (None, None) if rotor is None else (rotor.inertia, rotor.gear)
    return joint.rotor_inertia if inertia is None else inertia, joint.reduction if gear is None else gear


def armatures(model: Model, scene: Scene) -> Iterator[tuple[int, Joint, float]]:
    """Yield the body, joint and reflected inertia G^2 J [kg m^2] of every joint that has a rotor."""
    for i, body in enumerate(model.bodies):
        joint = body.joint
        inertia, gear = rotor_of(joint, scene)
        if inertia and gear:
            yield i, joint, gear * gear * inertia


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    joints = [joint for _, joint, _ in armatures(model, scene)]
    none, some = "neither the scene nor a transmission has a rotor inertia", "joints with rotors"
    return Verdict.of_joints(joints, ("qdd", zero_columns), none, "no joint with a rotor accelerates", some)


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    return terms.with_torques(
        (i, armature * sample.acceleration(joint)) for i, joint, armature in armatures(sample.model, scene)
    )


def stored(sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
    """sum G^2 J qd^2 / 2 [J]."""
    turning = ((armature, sample.speed(joint)) for _, joint, armature in armatures(sample.model, scene))
    return total((0.5 * armature) * (speed * speed) for armature, speed in turning)


EFFECT = Effect("rotor inertia", "G^2 J qdd", why, add, stored=stored)
