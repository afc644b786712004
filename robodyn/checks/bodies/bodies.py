"""The inertials of links as bodies, and how they fit the shapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite

from robodyn.checks.bodies.masses import link_poses, pose, widest
from robodyn.checks.bodies.shapes import group_boxes, link_boxes
from robodyn.checks.context import Context
from robodyn.programs.vectors import product
from robodyn.robot.kinematics import Pose
from robodyn.robot.urdf.elements import Span
from robodyn.robot.urdf.view import InertialView, LinkView
from robodyn.solids.inertia.laws import second_moments, symmetric
from robodyn.solids.inertia.validity import Box
from robodyn.support.floats import Floats

_LEAST = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One inertial and the boxes that it ought to fit.

    Attributes:
        link, inertial: it.
        mass: kg, positive.
        c: (3,) centre of mass in the link's frame [m].
        S: (3, 3) second moments about the centre, along the link's axes [kg m^2]; None without a tensor, or if it is 0.
        own: box around the link's own shapes, along its axes.
        group: box around the shapes of its rigid group, in the frame of that group's first link.
        pose: of the link in that frame.
    """

    link: LinkView
    inertial: InertialView
    mass: float
    c: Floats
    S: Floats | None
    own: Box | None
    group: Box | None
    pose: Pose

    @property
    def tensor_span(self) -> Span:
        """Where to point at in its tensor."""
        return self.inertial.entries[widest(self.link.tensor or (0.0,) * 6)].span

    @property
    def box(self) -> Box | None:
        """The smallest box that surely holds it, along the link's axes: around its own shapes, else the group's."""
        if self.own is not None or self.group is None:
            return self.own
        R = self.pose.R
        return self.group.placed(R.T, -product(R.T, self.pose.p))

    @property
    def in_group(self) -> tuple[Floats, Floats | None]:
        """Centre and second moments in the group's frame."""
        R = self.pose.R
        return product(R, self.c) + self.pose.p, None if self.S is None else product(R, self.S, R.T)


def bodies(context: Context) -> Mapping[str, Body]:
    """Return the body of every link whose inertial has a positive mass and can be read, by name. From stage TREE on."""
    own, poses, boxes = context.once(link_boxes), context.once(link_poses), context.once(group_boxes)
    found = {}
    for link in context.view.links:
        where = None if link.inertial is None else pose(link.inertial.origin)
        if link.inertial is None or where is None or link.name not in poses:
            continue
        mass = link.mass
        if mass is None or not 0 < mass < float("inf"):
            continue
        found[link.name] = Body(
            link=link,
            inertial=link.inertial,
            mass=mass,
            c=where.p,
            S=_second(link, where),
            own=own.get(link.name),
            group=boxes.get(context.tree.group[link.name]),
            pose=poses[link.name],
        )
    return found


def share(context: Context, body: Body) -> float | None:
    """Return its share of its rigid group's mass; None where that is below 1 %, so that it does not matter."""
    whole = context.tree.group[body.link.name].mass
    part = body.mass / whole if whole else 1.0
    return part if part >= _LEAST else None


def _second(link: LinkView, where: Pose) -> Floats | None:
    tensor = link.tensor
    if tensor is None or not all(map(isfinite, tensor)) or not any(tensor):
        return None
    S: Floats = product(where.R, second_moments(symmetric(tensor)), where.R.T)
    return S
