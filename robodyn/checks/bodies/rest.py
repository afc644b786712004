"""Where the links are at rest: each joint at 0, or at the limit next to it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robodyn.checks.bodies.masses import STILL, pose
from robodyn.checks.context import Context
from robodyn.programs.vectors import length, product, rotation_about
from robodyn.robot.kinematics import Pose
from robodyn.robot.urdf.view import JointView


def rest_poses(context: Context) -> Mapping[str, Pose]:
    """Return the pose of each link in the root's frame; without those that hang on what cannot be read. From stage
    TREE on."""
    poses = {context.tree.root.name: STILL}
    for link in context.tree.links[1:]:
        joint = context.tree.above[link.name]
        inner, outer = joint_pose(joint), poses.get(joint.parent)
        if inner is not None and outer is not None:
            poses[link.name] = behind(outer, inner)
    return poses


def behind(outer: Pose, inner: Pose) -> Pose:
    """Return the pose in the outer frame of what has a pose in the inner one."""
    return Pose(product(outer.R, inner.R), outer.p + product(outer.R, inner.p))


def relative(outer: Pose, inner: Pose) -> Pose:
    """Return the pose of the inner frame in the outer one, both being given in a third."""
    return Pose(product(outer.R.T, inner.R), product(outer.R.T, inner.p - outer.p))


def joint_pose(joint: JointView) -> Pose | None:
    """Return the pose of the child in the parent's frame at rest; None where it cannot be read."""
    fixed, q = pose(joint.origin), rest(joint)
    axis = joint.axis.or_default(1.0, 0.0, 0.0)
    if fixed is None or axis is None or not q or not any(axis):
        return fixed
    unit = np.array(axis) / length(np.array(axis))
    if joint.type == "prismatic":
        return Pose(fixed.R, fixed.p + product(fixed.R, unit) * q)
    return Pose(product(fixed.R, rotation_about(unit, q).astype(float)), fixed.p)


def rest(joint: JointView) -> float:
    reach = None if joint.limit is None else joint.limit.range
    if joint.type not in ("revolute", "prismatic") or reach is None or reach[0] > reach[1]:
        return 0.0
    return min(max(0.0, reach[0]), reach[1])
