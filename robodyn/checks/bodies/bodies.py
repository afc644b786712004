"""The inertials of links as bodies: how they fit the shapes, and masses that are written twice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import inf, isfinite, pi

import numpy as np

from robodyn.checks.bodies.masses import link_poses, pose, widest
from robodyn.checks.bodies.shapes import group_boxes, link_boxes, shaped
from robodyn.checks.context import Context
from robodyn.programs.vectors import length, product
from robodyn.robot.kinematics import Pose
from robodyn.robot.masses.mistakes import DOUBTED, PRODUCTS, Given, Posterior, Uniform, mistake_posterior
from robodyn.robot.urdf.document import Span
from robodyn.robot.urdf.view import InertialView, JointView, LinkView
from robodyn.solids.inertia.laws import second_moments, symmetric
from robodyn.solids.inertia.validity import Box
from robodyn.support.floats import Floats
from robodyn.support.wording import figure, one_of

_LEAST_SHARE = 0.01
_MASS = 1e-6
"""Relative difference of masses that are the same."""
_NEAR = 1e-3
"""Metres between centres of mass that are the same."""
_EXACT = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One inertial and the boxes that it ought to fit.

    Attributes:
        c: (3,) centre of mass in the link's frame [m].
        S: (3, 3) second moments about the centre, along the link's axes [kg m^2]; None without a tensor, or if it is 0.
        own: box around the link's shapes, along its axes; group: around those of its rigid group, in the frame of the
            group's first link, in which `pose` is that of the link.
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
    own, poses, boxes = context.once(link_boxes), context.once(link_poses), context.once(group_boxes)
    found = {}
    for link in context.view.links:
        where = None if link.inertial is None else pose(link.inertial.origin)
        mass, tensor, S = link.mass, link.tensor, None
        if link.inertial is None or where is None or link.name not in poses or mass is None or not 0 < mass < inf:
            continue
        if tensor is not None and all(map(isfinite, tensor)) and any(tensor):
            S = product(where.R, second_moments(symmetric(tensor)), where.R.T)
        group = boxes.get(context.tree.group[link.name])
        found[link.name] = Body(link, link.inertial, mass, where.p, S, own.get(link.name), group, poses[link.name])
    return found


def share(context: Context, body: Body) -> float | None:
    """Its share of its rigid group's mass; None where that is below 1 %, so that it does not matter."""
    whole = context.tree.group[body.link.name].mass
    part = body.mass / whole if whole else 1.0
    return part if part >= _LEAST_SHARE else None


def repeated(context: Context) -> Mapping[str, JointView]:
    """Return by child the fixed joints whose child has the mass of its parent again."""
    known = context.once(bodies)
    found = {}
    for joint in context.view.joints:
        part, again = known.get(joint.parent), known.get(joint.child)
        if joint.type != "fixed" or part is None or again is None or abs(part.mass - again.mass) > _MASS * part.mass:
            continue
        one_centre = length(part.in_group[0] - again.in_group[0]) <= _NEAR
        spread = not _stand_in(part) and not _stand_in(again)
        if share(context, again) is not None and ((spread and one_centre) or _copied(part, again)):
            found[joint.child] = joint
    return found


def _copied(part: Body, again: Body) -> bool:
    """Return whether the numbers of one are those of the other, which has no shape, or products of inertia and another
    shape."""
    tensor = part.link.tensor
    same = tensor == again.link.tensor and bool((part.c == again.c).all()) and not _stand_in(part)
    if not same or tensor is None or not again.link.geometries:
        return same
    one, other = (
        {tuple(sorted(shape.shape.values.items())) for shape in link.geometries if shape.shape is not None}
        for link in (part.link, again.link)
    )
    return all(tensor[k] for k in (1, 2, 4)) and one != other


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
    """Return what may explain that an inertia, or else a centre of mass, does not fit the shapes, in words; None if
    nothing does."""
    verdict = context.once(weighed).get(body.link.name)
    if verdict is None or verdict.right > DOUBTED:
        return None
    said = given(body.link)
    fits = (one for one in verdict.causes if (1 in one.mistake.wrong) == centre)
    if not centre and said is not None and said.raised and any(said.entries[k] for k in PRODUCTS):
        return one_of([f"its moments were raised to {figure(said.entries[0], 2)} kg m^2, as simulators are helped"])
    return one_of(one.what for one in fits)
