"""What MuJoCo 4.0 refuses or alters of masses and joints; each was learnt by running it."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot

from robodyn.checks.bodies.masses import link_poses, principal_moments
from robodyn.checks.consumers.found import Found, joints, named, part
from robodyn.checks.consumers.water import (
    Weight,
    compiler,
    invented,
    joined,
    weight_of,
)
from robodyn.checks.context import Context
from robodyn.checks.tree import Group
from robodyn.programs.linear import eigen
from robodyn.robot.urdf.parts import WITH_AXIS, WITH_RANGE
from robodyn.robot.urdf.view import JointView
from robodyn.solids.inertia.laws import inertia_matrix

LEAST = 1e-15
"""Mass [kg] and principal moments [kg m^2] of what moves."""
_LEAST_MOMENT = 1e-14
"""Of each tensor that is given, and of what comes of joining two bodies [kg m^2]."""
_LEAST_AXIS = 1e-7
_DRIVEN = ("revolute", "continuous", "prismatic")
_ROUNDING = 1e-15
"""Of principal moments, relative: within it MuJoCo's own rounding decides whether two make up for the third."""


def _unlimited(joint: JointView) -> bool:
    limit = joint.limit if joint.type in WITH_RANGE else None
    if limit is None or not (limit.lower.given or limit.upper.given):
        return False
    lower, upper = limit.lower.value, limit.upper.value
    return lower is None or upper is None or not lower < upper


unlimited = joints(_unlimited)
own_mimics = joints(lambda joint: joint.mimic is not None and joint.mimic.joint == joint.name and joint.type in _DRIVEN)
no_axis = joints(lambda joint: joint.type in WITH_AXIS and hypot(*(joint.axis.values or (1.0,))) < _LEAST_AXIS)


def massless(context: Context) -> Iterator[Found]:
    """Yield rigid groups that a joint moves, without mass or without moments of inertia; silent about those that are
    refused for a tensor."""
    if min(_number(context, "boundmass"), _number(context, "boundinertia")) >= LEAST:
        return
    refused = context.once(impossible)
    for group in context.tree.groups[1:]:
        first = group.links[0]
        if (first.mass or 0.0) >= LEAST and any(first.tensor or ()):
            continue
        weights = None if refused.intersection(link.name for link in group.links) else _weights(context, group)
        if weights is not None and not _stands(weights):
            yield part(first)


def _weights(context: Context, group: Group) -> list[Weight] | None:
    """Return what the links of a group weigh to MuJoCo, in the frame of its first one; None where one is not known."""
    poses = context.once(link_poses)
    found = []
    for link in group.links:
        weight = weight_of(context, link)
        if weight is None or link.name not in poses:
            return None
        found.append(weight.placed(poses[link.name]))
    return found


def _stands(weights: list[Weight]) -> bool:
    """Return whether a body comes of them: others are joined to the first in turn, those without mass not at all.

    Once it has moments in all directions, more mass adds to them.
    """
    whole = weights[0]
    if whole.mass >= LEAST and _least_moment(whole) >= _LEAST_MOMENT:
        return True
    for weight in weights[1:]:
        if weight.mass >= LEAST:
            whole = joined((whole, weight))
            return _least_moment(whole) >= _LEAST_MOMENT
    return whole.mass >= LEAST and _least_moment(whole) >= LEAST


def _least_moment(weight: Weight) -> float:
    return float(eigen(inertia_matrix(weight.S))[0][-1]) if weight.S.any() else 0.0


def _number(context: Context, name: str) -> float:
    """Return a number of <compiler>; 0 where it is not there or is none."""
    try:
        return float(context.once(compiler).get(name, "0"))
    except ValueError:
        return 0.0


def impossible(context: Context) -> frozenset[str]:
    """Return the links whose tensor no body has, also the root and links without mass; one of zeros counts as none."""
    balanced = context.once(compiler).get("balanceinertia") == "true"
    found = set()
    for link in context.tree.links:
        tensor = link.tensor
        if tensor is None or not any(tensor):
            continue
        along_axes = not (tensor[1] or tensor[2] or tensor[4])
        small, middle, large = sorted((tensor[0], tensor[3], tensor[5])) if along_axes else principal_moments(tensor)
        room = 0.0 if along_axes else _ROUNDING * large
        if small < _LEAST_MOMENT or (small + middle < large - room and not balanced):
            found.add(link.name)
    return frozenset(found)


def unphysical(context: Context) -> Iterator[Found]:
    """Yield what is refused for its tensor."""
    for link in context.tree.links:
        if link.name in context.once(impossible) and link.inertial is not None:
            yield part(link, link.inertial.element)


def incomplete(context: Context) -> Iterator[Found]:
    """Yield <inertial>s without <mass> or <inertia>."""
    for link in context.view.links:
        inertial = link.inertial
        if inertial is not None and (inertial.inertia_element is None or inertial.mass_element is None):
            yield part(link, inertial.element)


def inventions(context: Context) -> Iterator[Found]:
    """Yield links that MuJoCo gives a mass, with it."""
    for name, mass in context.once(invented).items():
        link = context.view.link[name]
        known = "of a mesh that is not there or cannot be read" if mass is None else f"{mass:.3g} kg"
        yield Found(link.element.span, f"{named(link)} {known}", mass or 0.0)


def deep_floats(context: Context) -> Iterator[Found]:
    """Yield floating joints on what another joint moves."""
    root = context.tree.groups[0]
    for joint in context.view.joints:
        if joint.type == "floating" and context.tree.group[joint.parent] is not root:
            yield part(joint)


def second_worlds(context: Context) -> Iterator[Found]:
    """Yield a link called world that is not the root."""
    yield from (part(link) for link in context.tree.links[1:] if link.name == "world")


def visuals(context: Context) -> Iterator[Found]:
    """Yield the <visual>s, unless the description asks for them."""
    if context.once(compiler).get("discardvisual", "true") == "true":
        for link in context.view.links:
            yield from (Found(one.element.span, named(link)) for one in link.geometries if one.kind == "visual")
