"""Poses, masses and moments that several rules ask for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from math import fsum, sqrt

import numpy as np

from robodyn.checks.context import Context, Group, Thresholds
from robodyn.checks.rule import Severity
from robodyn.programs.vectors import IDENTITY, ZERO, product, rotation_from_rpy
from robodyn.robot.kinematics import Pose
from robodyn.robot.urdf.view import InertialView, LinkView, OriginView
from robodyn.solids.inertia.laws import Inertia, combined, inertia_of, symmetric

Tensor = tuple[float, ...]  # ixx, ixy, ixz, iyy, iyz, izz [kg m^2]
POINT = 1e-6  # radius of gyration [m] below which a body counts as a point
_ROUNDING = 2e-15
STILL = Pose(IDENTITY, ZERO)  # the pose of a link in its own frame


def pose(origin: OriginView) -> Pose | None:
    """The pose of an origin; None where a number in it cannot be read."""
    xyz, rpy = origin.xyz.or_default(0.0, 0.0, 0.0), origin.rpy.or_default(0.0, 0.0, 0.0)
    return None if xyz is None or rpy is None else Pose(rotation_from_rpy(*rpy), np.array(xyz))


def link_poses(context: Context) -> Mapping[str, Pose]:
    """The pose of each link's frame in that of its rigid group's first link; without those that cannot be read."""
    poses: dict[str, Pose] = {}
    for group in context.tree.groups:
        first, *others = group.links
        poses[first.name] = STILL
        for link in others:
            joint = context.tree.above[link.name]
            outer, inner = poses.get(joint.parent), pose(joint.origin)
            if outer is not None and inner is not None:
                poses[link.name] = behind(outer, inner)
    return poses


def behind(outer: Pose, inner: Pose) -> Pose:
    """The pose in the outer frame of what has a pose in the inner one."""
    return Pose(product(outer.R, inner.R), outer.p + product(outer.R, inner.p))


def relative(outer: Pose, inner: Pose) -> Pose:
    """The pose of the inner frame in the outer one, both being given in a third."""
    return Pose(product(outer.R.T, inner.R), product(outer.R.T, inner.p - outer.p))


def carried_masses(context: Context) -> Mapping[Group, float]:
    """The mass of all that moves with each rigid group, itself included; unreadable masses count as 0."""
    carried: dict[Group, float] = {}
    for group in reversed(context.tree.groups):
        own = fsum(link.mass or 0.0 for link in group.links)
        carried[group] = own + fsum(carried[child] for child in group.children)
    return carried


@lru_cache(maxsize=4096)
def principal_moments(tensor: Tensor) -> tuple[float, float, float]:
    """The principal moments of inertia, ascending [kg m^2], within 2e-15 of the largest; what is rounding is 0."""
    size = max(map(abs, tensor)) or 1.0
    moments = np.linalg.eigvalsh(symmetric(tensor) / size)
    small, middle, large = (np.where(np.abs(moments) > _ROUNDING, moments, 0.0) * size).tolist()
    return small, middle, large


def broken_law(tensor: Tensor, limits: Thresholds) -> str | None:
    """The rule that tells why no body has a tensor: RD206, a principal moment is not positive, or RD207, the largest is
    more than the sum of the others; None where a body can have it."""
    small, middle, large = principal_moments(tensor)
    if small <= limits.positive_definite * large:
        return "RD206"
    return None if small + middle >= (1 - limits.triangle) * large else "RD207"


def severity_of_zero(context: Context, link: LinkView) -> Severity | None:
    """How bad a link's zero mass is: None in a body that has mass by its other links, or that does not move."""
    tree = context.tree_or_none
    group = None if tree is None else tree.group[link.name]
    if group is None or group.joint is None or group.mass != 0:
        return None
    return Severity.WARNING if context.once(carried_masses)[group] > 0 else Severity.ERROR


def is_a_point(link: LinkView) -> bool:
    """Whether what inertia it has is that of a point: a radius of gyration below a micrometre."""
    if link.tensor is None or link.mass is None:
        return False
    return max(map(abs, link.tensor)) <= POINT * POINT * max(link.mass, 0.0)


def tensors(context: Context) -> Iterator[tuple[LinkView, InertialView, Tensor]]:
    for link in context.view.links:
        if link.inertial is not None and link.tensor is not None and not is_a_point(link):
            yield link, link.inertial, link.tensor


def inertia_together(context: Context, links: Sequence[LinkView]) -> Inertia | None:
    """The inertia of links of a rigid group, in the frame of the first; None where a number cannot be read."""
    poses, found = context.once(link_poses), list[Inertia]()
    first = poses.get(links[0].name)
    for link in links:
        if link.inertial is None:
            continue
        outer, inner = poses.get(link.name), pose(link.inertial.origin)
        if link.mass is None or link.tensor is None or first is None or outer is None or inner is None:
            return None
        at = behind(relative(first, outer), inner)
        found.append(inertia_of(link.mass, ZERO, symmetric(link.tensor), at.R, at.p))
    return combined(found)


def gyration(context: Context, group: Group) -> float | None:
    """sqrt(tr(I_c) / 2 m) [m] of a group; None where a number of it cannot be read, or no mass is there."""
    whole = inertia_together(context, group.links)
    if whole is None or not whole.m > 0:
        return None
    return sqrt(max(float(np.trace(whole.about_centre)), 0.0) / (2.0 * float(whole.m)))


def widest(tensor: Tensor) -> int:
    """Return which of the six entries to point at in an inertia that no body has: a diagonal entry that is not
    positive, or the product that is largest beside its moments; where neither stands out, the largest moment."""
    diagonal = {0: tensor[0], 3: tensor[3], 5: tensor[5]}
    least = min(diagonal, key=lambda k: diagonal[k])
    if diagonal[least] <= 0:
        return least
    pairs = {1: (0, 3), 2: (0, 5), 4: (3, 5)}
    excess = {k: tensor[k] ** 2 - tensor[i] * tensor[j] for k, (i, j) in pairs.items()}
    worst = max(excess, key=lambda k: excess[k])
    return worst if excess[worst] > 0 else max(diagonal, key=lambda k: diagonal[k])
