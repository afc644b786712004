"""The motion of each joint from its coordinates, for any scalar."""

from __future__ import annotations

from collections.abc import Sequence

from robodyn.programs.vectors import IDENTITY, ZERO, Scalar, rotation_about, rotation_from_quaternion, vector
from robodyn.robot.model import Joint, Model
from robodyn.robot.motion_types import Motion

REST = Motion(IDENTITY, ZERO, ZERO, ZERO, ZERO, ZERO)


def joint_motion(joint: Joint, q: Sequence[Scalar], qd: Sequence[Scalar], qdd: Sequence[Scalar]) -> Motion:
    """How the joint moves its body relative to the parent body.

    Revolute: `R = R_0 rot(axis, q)`, `w = axis qd`, `wd = axis qdd`. Prismatic: `p = p_0 + R_0 axis q`, `v = axis qd`,
    `a = axis qdd`. Floating: position and quaternion in the parent's axes; its rates are the angular velocity in the
    body's axes and the rate of the position in the parent's. Fixed: the placement, at rest.

    R and p are arrays of objects even where these are floats, so that NumPy multiplies them in order, without BLAS.

    Args:
        joint: with its placement R_0, p_0.
        q, qd, qdd: the values of this joint alone, one each, or 7, 6 and 6 for a floating joint (x y z qx qy qz qw;
            wx wy wz vx vy vz) [rad or m, and per s and s^2].
    """
    R, p = joint.R.astype(object), joint.p.astype(object)
    if joint.kind == "fixed":
        return REST._replace(R=R, p=p)
    if joint.kind == "floating":
        turn = rotation_from_quaternion(*q[3:]).astype(object)
        return Motion(
            R @ turn,
            p + R @ vector(*q[:3]),
            vector(*qd[:3]),
            turn.T @ vector(*qd[3:]),
            vector(*qdd[:3]),
            turn.T @ vector(*qdd[3:]),
        )
    axis = joint.axis
    if joint.kind == "revolute":
        return Motion(R @ rotation_about(axis, q[0]), p, axis * qd[0], ZERO, axis * qdd[0], ZERO)
    return Motion(R, p + (R @ axis) * q[0], ZERO, axis * qd[0], ZERO, axis * qdd[0])


def motions(model: Model, q: Sequence[Scalar], qd: Sequence[Scalar], qdd: Sequence[Scalar]) -> list[Motion]:
    """The motion of every joint of the model; mimic joints move by `multiplier q + offset` of their master.

    Args:
        q: nq scalars; qd, qdd: n scalars, in the model's order.
    """
    out = []
    for body in model.bodies:
        joint = body.joint
        if joint.kind == "floating":
            i, k = joint.coordinate, joint.rate
            out.append(joint_motion(joint, q[i : i + 7], qd[k : k + 6], qdd[k : k + 6]))
        elif joint.kind == "fixed":
            out.append(joint_motion(joint, (), (), ()))
        else:
            ratio, own = joint.multiplier, joint.coordinate
            out.append(
                joint_motion(
                    joint, [ratio * q[own] + joint.offset], [ratio * qd[joint.rate]], [ratio * qdd[joint.rate]]
                )
            )
    return out
