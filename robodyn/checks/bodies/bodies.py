"""Boxes around links and rigid groups, the uniform solids that links are by their shapes, and inertials beside both."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import inf, isfinite, pi
from statistics import median
from typing import NamedTuple

import numpy as np

from robodyn.checks.bodies.masses import STILL, behind, link_poses, pose, widest
from robodyn.checks.context import Context, Group
from robodyn.checks.meshes.files import MeshFacts, all_facts, mesh_slips
from robodyn.programs.vectors import length, product
from robodyn.robot.kinematics import Pose
from robodyn.robot.masses.mistakes import DOUBTED, PRODUCTS, Given, Posterior, Uniform, mistake_posterior
from robodyn.robot.urdf.document import Span
from robodyn.robot.urdf.view import GeometryView, InertialView, JointView, LinkView
from robodyn.solids.inertia.laws import second_moments, symmetric
from robodyn.solids.inertia.solids import SHAPES
from robodyn.solids.inertia.validity import Box, around, half_size
from robodyn.support.floats import Floats
from robodyn.support.wording import figure, one_of

_FILLED = 0.35  # volume of a part over that of the box around it: the median of meshes of published robots
_LEAST_FILLED = 0.03  # volume over the box's below which a surface that is not closed encloses nothing definite
_LEAST_SHARE = 0.01
_MASS = 1e-6  # relative difference of masses that are the same
_NEAR = 1e-3  # metres between centres of mass that are the same
_EXACT = 0.02


class Solid(NamedTuple):
    """The box around a shape in its own axes [m], and where these are in the link's frame."""

    box: Box
    pose: Pose

    def placed(self, outer: Pose) -> Box:
        return self.box.placed(*(self.pose if outer is STILL else behind(outer, self.pose)))


_FEWEST = 3
"""Links with mass and shapes that show the unit of a robot. The medians of 86 published robots with as many are 7 to
3000 kg/m^3; drawn in millimetres they are 1e-9 of that."""
_LIKELY = 10.0, 9000.0
"""What a robot drawn in metres has in the median [kg/m^3], with room for one that is lighter or heavier."""
Solids = Mapping[GeometryView, Solid]


def solids(context: Context) -> Solids:
    """The boxes of all shapes whose size is known and not zero, and no slip of units; none where the robot is one."""
    return {} if context.once(other_unit) else context.once(_sized)


def _sized(context: Context) -> Solids:
    facts, mistaken = context.once(all_facts), context.once(mesh_slips)
    found = {}
    for link in context.view.links:
        for geometry in link.geometries:
            where, box = pose(geometry.origin), None
            if geometry.tag == "mesh":
                known, scale = facts.get(geometry.uri), geometry.scale.or_default(1.0, 1.0, 1.0)
                if known is not None and known.problem is None and scale is not None and all(scale):
                    ends = np.array((known.lo, known.hi)) * np.array(scale)
                    box = Box(ends.min(axis=0), ends.max(axis=0))
            elif geometry.sizes and all(size.values is not None for size in geometry.sizes):
                half = half_size(geometry.tag, [side for size in geometry.sizes for side in size.values or ()])
                box = Box(-half, half) if (half > 0).all() else None
            if where is not None and box is not None and geometry not in mistaken:
                found[geometry] = Solid(box, where)
    return found


def other_unit(context: Context) -> tuple[float, float] | None:
    """How many times too large a robot is drawn, None in metres; and its links' mass over their boxes' volume, in the
    median."""
    known, densities = context.once(_sized), list[float]()
    for link in context.view.links:
        box, mass = box_of(real_shapes(link), known, STILL), link.mass
        volume = 0.0 if box is None else float((box.hi - box.lo).prod())
        if volume > 0 and mass is not None and mass > 0:
            densities.append(mass / volume)
    middle = median(densities) if len(densities) >= _FEWEST else np.nan
    return next(((by, middle) for by in (1e3, 1e-3) if _LIKELY[0] <= middle * by**3 <= _LIKELY[1]), None)


def box_of(shapes: Iterable[GeometryView], known: Solids, outer: Pose) -> Box | None:
    """The box around shapes of a link whose frame has this pose in its axes; None if one is unknown, or none."""
    return around_known([known[shape].placed(outer) if shape in known else None for shape in shapes])


def link_boxes(context: Context) -> Mapping[str, Box | None]:
    """The box around the shapes of each link that has some, along its axes; None where one is unknown."""
    shaped = ((link.name, real_shapes(link)) for link in context.view.links)
    return {name: box_of(shapes, context.once(solids), STILL) for name, shapes in shaped if shapes}


def around_known(boxes: Sequence[Box | None]) -> Box | None:
    found = [box for box in boxes if box is not None]
    return around(found) if found and len(found) == len(boxes) else None


def real_shapes(link: LinkView, *kinds: str) -> list[GeometryView]:
    """The shapes of a link that can be read, by default of both kinds, visual and collision."""
    return [one for one in link.geometries if one.shape is not None and (not kinds or one.kind in kinds)]


def size_of(box: Box) -> float:
    return length(box.hi - box.lo)


def gap(first: Box, second: Box) -> float:
    """The distance between two boxes [m]; 0 where they meet."""
    return length(np.maximum(np.maximum(first.lo - second.hi, second.lo - first.hi), 0.0))


def outside(box: Box, point: Floats) -> float:
    """The distance of a point (3,) from the box [m]; 0 within."""
    return gap(box, Box(point, point))


class Shaped(NamedTuple):
    """The solid that a link's shapes are, in its axes; not `definite` if a box stands for one that encloses no
    volume."""

    solid: Uniform
    definite: bool


def shaped(context: Context) -> Mapping[str, Shaped]:
    """By name the links of which all visual shapes are known, or else all collision shapes, as uniform solids. A mesh
    that is not closed counts as what it encloses with the cone of its boundary to a point inside, where that is like a
    body."""
    known, facts = context.once(solids), context.once(all_facts)
    found = {}
    for link in context.view.links:
        shapes = real_shapes(link, "visual") or real_shapes(link)
        if not shapes or not all(shape in known for shape in shapes):
            continue
        parts, definite = [], True
        for shape in shapes:
            (box, where), own = (known[shape].box, known[shape].pose), _solid(shape, known[shape].box, facts)
            definite = definite and own is not None
            if own is None:
                sides = box.hi - box.lo
                own = Uniform(_FILLED * float(sides.prod()), (box.lo + box.hi) / 2.0, np.diag(sides**2 / 12.0))
            parts.append(Uniform(own.volume, product(where.R, own.c) + where.p, product(where.R, own.S, where.R.T)))
        whole = together(parts)
        if whole is not None:
            found[link.name] = Shaped(whole, definite)
    return found


def together(parts: Sequence[Uniform]) -> Uniform | None:
    """Several solids of one density as one; None without volume or extent."""
    volume = sum(part.volume for part in parts)
    if not 0.0 < volume < np.inf:
        return None
    c = sum((part.volume * part.c for part in parts), np.zeros(3)) / volume
    S = sum((part.volume * (part.S + np.outer(part.c - c, part.c - c)) for part in parts), np.zeros((3, 3))) / volume
    return Uniform(volume, c, S) if 0.0 < np.trace(S) < np.inf else None


def _solid(shape: GeometryView, box: Box, facts: Mapping[str, MeshFacts]) -> Uniform | None:
    """Return a primitive, or what a mesh encloses; None where that is nothing definite."""
    if shape.tag != "mesh":
        body = SHAPES[shape.tag](*(length for size in shape.sizes for length in size.values or ()), mass=1.0)
        return Uniform(body.volume or 0.0, body.com, body.S_c)
    one, scale = facts[shape.uri], np.array(shape.scale.or_default(1.0, 1.0, 1.0))
    volume = abs(one.volume * float(scale.prod()))
    c, S = np.array(one.centre) * scale, symmetric(one.second) * np.outer(scale, scale)
    sides = box.hi - box.lo
    if not (volume > 0.0 and (box.lo <= c).all() and (c <= box.hi).all() and (np.diagonal(S) > 0.0).all()):
        return None
    if not one.closed:
        most = (box.hi - c) * (c - box.lo)
        if volume < _LEAST_FILLED * float(sides.prod()) or (np.diagonal(S) > most).any():
            return None
    return Uniform(volume, c, S)


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One inertial and the boxes that it ought to fit."""

    link: LinkView
    inertial: InertialView
    mass: float
    c: Floats  # (3,) centre of mass in the link's frame [m]
    S: Floats | None  # (3, 3) second moments about it, along the link's axes [kg m^2]; None without a tensor, or if 0
    own: Box | None  # around the link's shapes, along its axes
    group: Box | None  # around those of its rigid group, in the frame of the group's first link
    pose: Pose  # that of the link in there

    @property
    def tensor_span(self) -> Span:
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
        R = self.pose.R
        return product(R, self.c) + self.pose.p, None if self.S is None else product(R, self.S, R.T)


def bodies(context: Context) -> Mapping[str, Body]:
    """The body of every link whose inertial has a positive mass and can be read, by name. From stage TREE on."""
    own, poses, known = context.once(link_boxes), context.once(link_poses), context.once(solids)
    found, boxes = {}, dict[Group, Box | None]()
    for group in context.tree.groups:
        shaped = ((real_shapes(link), poses.get(link.name)) for link in group.links)
        boxes[group] = around_known([box_of(shapes, known, at) if at else None for shapes, at in shaped if shapes])
    for link in context.view.links:
        where = None if link.inertial is None else pose(link.inertial.origin)
        mass, tensor, S = link.mass, link.tensor, None
        if link.inertial is None or where is None or link.name not in poses or mass is None or not 0 < mass < inf:
            continue
        if tensor is not None and all(map(isfinite, tensor)) and any(tensor):
            S = product(where.R, second_moments(symmetric(tensor)), where.R.T)
        box = boxes[context.tree.group[link.name]]
        found[link.name] = Body(link, link.inertial, mass, where.p, S, own.get(link.name), box, poses[link.name])
    return found


def share(context: Context, body: Body) -> float | None:
    """Its share of its rigid group's mass; None where that is below 1 %, so that it does not matter."""
    whole = context.tree.group[body.link.name].mass
    part = body.mass / whole if whole else 1.0
    return part if part >= _LEAST_SHARE else None


def repeated(context: Context) -> Mapping[str, JointView]:
    """Return by child the fixed joints whose child has the mass of its parent again, and no shape of its own."""
    known = context.once(bodies)
    found = {}
    for joint in context.view.joints:
        part, again = known.get(joint.parent), known.get(joint.child)
        if joint.type != "fixed" or part is None or again is None or abs(part.mass - again.mass) > _MASS * part.mass:
            continue
        each = ([shape.shape for shape in real_shapes(body.link)] for body in (part, again))
        one, its = ({tuple(sorted(shape.values.items())) for shape in shapes if shape} for shapes in each)
        one_centre = length(part.in_group[0] - again.in_group[0]) <= _NEAR and not _stand_in(again)
        same = part.link.tensor == again.link.tensor and bool((part.c == again.c).all())
        if share(context, again) is not None and its <= one and not _stand_in(part) and (one_centre or same):
            found[joint.child] = joint
    return found


def _stand_in(body: Body) -> bool:
    tensor = body.link.tensor
    return tensor is None or tensor[0] == tensor[3] == tensor[5]


def given(link: LinkView) -> Given | None:
    """What a link says; None where a number cannot be read, mass or inertia is missing, or the rpy is in degrees."""
    mass, tensor = link.mass, link.tensor
    if link.inertial is None or tensor is None or mass is None or not 0 < mass < inf or not any(tensor):
        return None
    placed, turns = pose(link.inertial.origin), link.inertial.origin.rpy.or_default(0.0, 0.0, 0.0) or ()
    if placed is None or any(abs(turn) > 2.0 * pi for turn in turns) or not all(map(isfinite, (*tensor, *placed.p))):
        return None
    return Given(mass, product(placed.R.T, placed.p), placed.R, tensor)


def weighed(context: Context) -> Mapping[str, Posterior]:
    """By link the verdict of its shapes; none without a tree. Of a link that is less than 1 % of its rigid group only
    where its numbers were made from the very shapes."""
    if context.tree_or_none is None:
        return {}
    shapes, known = context.once(shaped), context.once(bodies)
    found = {}
    for name, body in known.items():
        said = given(body.link)
        if said is None or name not in shapes:
            continue
        shape = shapes[name].solid.along(said.R)
        own = said.mass, said.c.tobytes(), said.R.tobytes(), said.entries
        verdict = _verdict(own, (shape.volume, shape.c.tobytes(), shape.S.tobytes()))
        exact = verdict.named and not verdict.units and verdict.named[0].apart <= _EXACT
        if exact or share(context, body) is not None:
            found[name] = verdict
    return found


@lru_cache(maxsize=1024)
def _verdict(own: tuple[float, bytes, bytes, tuple[float, ...]], shape: tuple[float, bytes, bytes]) -> Posterior:
    """The posterior, once for the same numbers, in bytes: a quarter of the links of a robot are like another one."""
    (mass, c, R, entries), (volume, centre, S) = own, shape
    given = Given(mass, np.frombuffer(c), np.frombuffer(R).reshape(3, 3), entries)
    return mistake_posterior(given, Uniform(volume, np.frombuffer(centre), np.frombuffer(S).reshape(3, 3)))


def judged(context: Context, tensors: bool = True) -> Iterator[Body]:
    """Yield the bodies whose mass matters in their group, where no slip of units is suspected, nor, with `tensors`, one
    of the tensor named, and no mass repeated."""
    verdicts, again = context.once(weighed), context.once(repeated)
    for name, body in context.once(bodies).items():
        verdict = verdicts.get(name)
        explained = verdict is not None and (verdict.units or (tensors and verdict.named))
        if not explained and name not in again and share(context, body) is not None:
            yield body


def suspected(context: Context, body: Body, centre: bool = False) -> str | None:
    """What may explain that an inertia, or else a centre of mass, does not fit the shapes, in words; None if nothing
    does."""
    verdict = context.once(weighed).get(body.link.name)
    if verdict is None or verdict.right > DOUBTED:
        return None
    said = given(body.link)
    fits = (one for one in verdict.causes if (1 in one.mistake.wrong) == centre)
    if not centre and said is not None and said.raised and any(said.entries[k] for k in PRODUCTS):
        return one_of([f"its moments were raised to {figure(said.entries[0], 2)} kg m^2, as simulators are helped"])
    return one_of(one.what for one in fits)
