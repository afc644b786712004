"""From wrenches at the joints to torques along their coordinates, for any scalar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from robodyn.programs.vectors import Scalar
from robodyn.robot.model import Model
from robodyn.robot.motion_types import Motion, Wrench


def joint_torques(
    model: Model, motions: Sequence[Motion], reactions: Sequence[Wrench], at_joint: Mapping[int, Scalar]
) -> list[Scalar]:
    """The generalized force along every coordinate: tau = S^T (f, n) + what acts at the joint itself.

    Revolute `axis . n`, prismatic `axis . f`; a floating joint gives the moment in the body's axes and the force in the
    parent's, which are dual to its rates. A mimic joint's torque is reflected onto its master by its multiplier.

    Args:
        motions, reactions: as `newton_euler` takes and returns them.
        at_joint: by body, torque added at its joint (friction, rotor, spring).

    Returns:
        n scalars [N m or N].
    """
    tau: list[Scalar] = [0.0] * model.n
    for i, body in enumerate(model.bodies):
        joint, reaction = body.joint, reactions[i]
        if joint.kind == "floating":
            force = joint.R.T @ (motions[i].R @ reaction.f)
            tau[joint.rate : joint.rate + 6] = [*reaction.n, *force]
        elif joint.kind != "fixed":
            along = joint.axis @ (reaction.n if joint.kind == "revolute" else reaction.f)
            tau[joint.rate] = tau[joint.rate] + joint.multiplier * (along + at_joint.get(i, 0.0))
    return tau
