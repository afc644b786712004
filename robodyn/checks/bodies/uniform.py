"""The uniform solids that links are if their shapes are of one density."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robodyn.checks.bodies.shapes import Solids, real_shapes, solids
from robodyn.checks.context import Context
from robodyn.checks.meshes.facts import MeshFacts
from robodyn.checks.meshes.files import all_facts
from robodyn.programs.vectors import product
from robodyn.robot.masses.likeness import Uniform
from robodyn.robot.urdf.view import GeometryView, LinkView
from robodyn.solids.inertia.laws import symmetric
from robodyn.solids.inertia.solids import SHAPES
from robodyn.solids.inertia.validity import Box

_FILLED = 0.35
"""Volume of a part over that of the box around it: the median of meshes of published robots."""
_LEAST = 0.03
"""Volume over the box's below which a surface that is not closed encloses nothing definite."""


@dataclass(frozen=True, eq=False)
class Shaped:
    """A link as its shapes have it.

    Attributes:
        solid: in the link's axes.
        definite: whether every shape encloses a volume; a box stands for one that does not.
    """

    solid: Uniform
    definite: bool


def shaped(context: Context) -> Mapping[str, Shaped]:
    """Return by name the links of which all visual shapes are known, or else all collision shapes, as uniform solids.

    A mesh that is not closed counts as what its triangles enclose with their boundary's cone to a point inside, where
    that is like a body: of the open meshes of published robots 98 in 100 are.
    """
    known, facts = context.once(solids), context.once(all_facts)
    found = {}
    for link in context.view.links:
        one = _shaped(link, known, facts)
        if one is not None:
            found[link.name] = one
    return found


def _shaped(link: LinkView, known: Solids, facts: Mapping[str, MeshFacts]) -> Shaped | None:
    shapes = real_shapes(link)
    shapes = [shape for shape in shapes if shape.kind == "visual"] or shapes
    if not shapes or not all(shape in known for shape in shapes):
        return None
    parts, definite = [], True
    for shape in shapes:
        own = _mesh(shape, known[shape].box, facts) or _primitive(shape)
        definite = definite and own is not None
        where = known[shape].pose
        if own is None:
            own = _boxed(known[shape].box)
        parts.append(Uniform(own.volume, product(where.R, own.c) + where.p, product(where.R, own.S, where.R.T)))
    whole = together(parts)
    return None if whole is None else Shaped(whole, definite)


def together(parts: Sequence[Uniform]) -> Uniform | None:
    """Return several solids of one density as one; None without volume or extent."""
    volume = sum(part.volume for part in parts)
    if not 0.0 < volume < np.inf:
        return None
    c = sum((part.volume * part.c for part in parts), np.zeros(3)) / volume
    S = sum((part.volume * (part.S + np.outer(part.c - c, part.c - c)) for part in parts), np.zeros((3, 3))) / volume
    return Uniform(volume, c, S) if 0.0 < np.trace(S) < np.inf else None


def _mesh(shape: GeometryView, box: Box, facts: Mapping[str, MeshFacts]) -> Uniform | None:
    """Return what a mesh encloses; None where that is nothing definite, or it is no mesh."""
    if shape.shape is None or shape.shape.tag != "mesh":
        return None
    one, scale = facts[shape.shape.get("filename") or ""], np.array(shape.scale.or_default(1.0, 1.0, 1.0))
    volume = abs(one.volume * float(scale.prod()))
    c, S = np.array(one.centre) * scale, symmetric(one.second) * np.outer(scale, scale)
    sides = box.hi - box.lo
    if not (volume > 0.0 and (box.lo <= c).all() and (c <= box.hi).all() and (np.diagonal(S) > 0.0).all()):
        return None
    if not one.closed:
        most = (box.hi - c) * (c - box.lo)
        if volume < _LEAST * float(sides.prod()) or (np.diagonal(S) > most).any():
            return None
    return Uniform(volume, c, S)


def _primitive(shape: GeometryView) -> Uniform | None:
    form = None if shape.shape is None else SHAPES.get(shape.shape.tag)
    if form is None:
        return None
    lengths = [length for size in shape.sizes for length in size.values or ()]
    body = form(*lengths, mass=1.0)
    return Uniform(body.volume or 0.0, body.com, body.S_c)


def _boxed(box: Box) -> Uniform:
    sides = box.hi - box.lo
    return Uniform(_FILLED * float(sides.prod()), (box.lo + box.hi) / 2.0, np.diag(sides**2 / 12.0))
