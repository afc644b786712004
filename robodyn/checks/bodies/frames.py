"""Where the links of a rigid group stand in it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robodyn.checks.context import Context
from robodyn.programs.vectors import product, rotation_from_rpy
from robodyn.robot.kinematics import Pose
from robodyn.robot.urdf.view import OriginView


def pose(origin: OriginView) -> Pose | None:
    """Return the pose of an origin; None where a number in it cannot be read."""
    xyz, rpy = origin.xyz.or_default(0.0, 0.0, 0.0), origin.rpy.or_default(0.0, 0.0, 0.0)
    if xyz is None or rpy is None:
        return None
    return Pose(rotation_from_rpy(rpy[0], rpy[1], rpy[2]), np.array(xyz))


def link_poses(context: Context) -> Mapping[str, Pose]:
    """The pose of each link's frame in that of its rigid group's first link; without those that cannot be read."""
    poses: dict[str, Pose] = {}
    for group in context.tree.groups:
        first, *others = group.links
        poses[first.name] = Pose(np.eye(3), np.zeros(3))
        for link in others:
            joint = context.tree.above[link.name]
            outer, inner = poses.get(joint.parent), pose(joint.origin)
            if outer is not None and inner is not None:
                poses[link.name] = Pose(product(outer.R, inner.R), outer.p + product(outer.R, inner.p))
    return poses


def centres_of_mass(context: Context) -> Mapping[str, tuple[float, ...]]:
    """Return the centre of mass of each link with an <inertial>, in the frame of its rigid group's first link [m]."""
    poses = context.once(link_poses)
    centres = {}
    for link in context.view.links:
        inertial = None if link.inertial is None else pose(link.inertial.origin)
        if inertial is not None and link.name in poses:
            outer = poses[link.name]
            centres[link.name] = tuple((outer.p + product(outer.R, inertial.p)).tolist())
    return centres
