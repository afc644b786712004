"""Boxes and volumes of what links and rigid groups are made of."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import pi, prod

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.frames import Pose, link_poses, pose
from robodyn.checks.mesh_facts import MeshFacts
from robodyn.checks.mesh_files import all_facts
from robodyn.checks.mesh_units import mesh_slips
from robodyn.checks.primitives import half_size
from robodyn.checks.tree import Group
from robodyn.checks.view import GeometryView, LinkView, numbers
from robodyn.programs.vectors import length, product
from robodyn.solids.inertia.boxes import Box, around
from robodyn.solids.inertia.exact import Floats


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """One shape in its link's frame.

    Attributes:
        view: it.
        box: around it in its own axes [m]; pose: where these are.
        volume: m^3; None where the surface of a mesh does not tell.
    """

    view: GeometryView
    box: Box
    pose: Pose
    volume: float | None

    @property
    def is_mesh(self) -> bool:
        return self.view.shape is not None and self.view.shape.tag == "mesh"

    def placed(self, outer: Pose) -> Box:
        """The box along outer axes, in which the link's frame stands at a pose."""
        return self.box.placed(product(outer.R, self.pose.R), product(outer.R, self.pose.p) + outer.p)


Solids = Mapping[GeometryView, Solid]


def solids(context: Context) -> Solids:
    """Every shape whose size is known and not zero, and is no slip of units."""
    facts, mistaken = context.once(all_facts), context.once(mesh_slips)
    found = {}
    for link in context.view.links:
        for geometry in link.geometries:
            where = pose(geometry.origin)
            if where is None or geometry.shape is None or geometry in mistaken:
                continue
            sized = _mesh(geometry, facts) if geometry.shape.tag == "mesh" else _primitive(geometry)
            if sized is not None:
                found[geometry] = Solid(geometry, sized[0], where, sized[1])
    return found


def _mesh(geometry: GeometryView, facts: Mapping[str, MeshFacts]) -> tuple[Box, float | None] | None:
    assert geometry.shape is not None, "it is a mesh"
    known = facts.get(geometry.shape.get("filename") or "")
    scale = numbers(geometry.shape, "scale", 3).or_default(1.0, 1.0, 1.0)
    if known is None or known.problem is not None or scale is None or not all(scale):
        return None
    ends = np.array((known.lo, known.hi)) * np.array(scale)
    volume = abs(known.volume * prod(scale)) if known.closed and not known.overlapping else 0.0
    return Box(ends.min(axis=0), ends.max(axis=0)), volume or None


def _primitive(geometry: GeometryView) -> tuple[Box, float] | None:
    half = half_size(geometry)
    if half is None or not (half > 0).all():
        return None
    x, _, z = half.tolist()
    tag = "" if geometry.shape is None else geometry.shape.tag
    volume = {
        "box": 8 * float(half.prod()),
        "cylinder": 2 * pi * x**2 * z,
        "sphere": 4 / 3 * pi * x**3,
        "capsule": pi * x**2 * (2 * (z - x) + 4 / 3 * x),
    }[tag]
    return Box(-half, half), volume


def box_of(shapes: Iterable[GeometryView], known: Solids, outer: Pose) -> Box | None:
    """Around shapes of one link, in axes in which its frame has this pose; None if one is unknown, or there is none."""
    boxes = [known[shape].placed(outer) if shape in known else None for shape in shapes]
    found = [box for box in boxes if box is not None]
    return around(found) if found and len(found) == len(boxes) else None


def group_boxes(context: Context) -> Mapping[Group, Box]:
    """Around all shapes of a rigid group, in the frame of its first link; without those of which a shape is unknown."""
    known, poses = context.once(solids), context.once(link_poses)
    found = {}
    for group in context.tree.groups:
        shaped = [link for link in group.links if real_shapes(link)]
        boxes = [box_of(real_shapes(link), known, poses[link.name]) if link.name in poses else None for link in shaped]
        whole = [box for box in boxes if box is not None]
        if whole and len(whole) == len(boxes):
            found[group] = around(whole)
    return found


def real_shapes(link: LinkView) -> list[GeometryView]:
    """The shapes of a link, without <visual/> and the like, which have none."""
    return [geometry for geometry in link.geometries if geometry.shape is not None]


def size_of(box: Box) -> float:
    """Length of its diagonal [m]."""
    return length(box.hi - box.lo)


def outside(box: Box, point: Floats) -> float:
    """Distance of a point (3,) from the box [m]; 0 within."""
    return length(np.maximum(np.maximum(box.lo - point, point - box.hi), 0.0))
