"""The loops that a description closes by itself: its <constraint> elements, as a scene has them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan2
from typing import Any

import numpy as np

from robodyn.errors import DescriptionError
from robodyn.programs.vectors import product, rotation_from_rpy
from robodyn.robot.model import Model
from robodyn.robot.urdf.document import read_document
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import numbers
from robodyn.robot.urdf.parts import ZERO, Description, Origin, Vector
from robodyn.robot.urdf.strict import Strict
from robodyn.robot.urdf.structure import by_name
from robodyn.scene.parts import Loop
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives, shown

TAG = "constraint"
AXIS: Vector = (1.0, 0.0, 0.0)
"""What is taken where there is none, as for a joint."""


@dataclass(frozen=True, slots=True)
class Constraint:
    """A joint that closes a loop: it ties a frame of one link to a frame of another.

    Attributes:
        type: of a joint; the proposal does not list them.
        parent, child: links.
        parent_origin, child_origin: the frames, in those of the links.
        parent_axis, child_axis: as written, in the axes of the frames.
    """

    name: str
    type: str
    parent: str
    parent_origin: Origin
    parent_axis: Vector
    child: str
    child_origin: Origin
    child_axis: Vector
    line: int


KINDS = {"fixed": "weld", "revolute": "hinge", "continuous": "hinge", "spherical": "point", "ball": "point"}
"""Loops by the type of a constraint."""


def scene_of(model: Model, scene: Scene = DEFAULT) -> Scene:
    """Return the scene with the loops that the <constraint> elements of the robot's description close.

    Commands do so by themselves. A loop of the scene takes the place of the constraint that has its name.

    Args:
        model: what `load` returns.
        scene: the default is gravity alone.

    Raises:
        DescriptionError: a constraint is wrong, or of a type that is no loop here, and the scene does not replace it.
    """
    if model.description is None:
        return scene
    own = {loop.name for loop in scene.loops}
    others = [each for each in read_constraints(model.description) if each.name not in own]
    if not others:
        return scene
    return replace(scene, loops=(*(_loop(each, model.file) for each in others), *scene.loops))


def _loop(constraint: Constraint, file: str) -> Loop:
    """Return the loop that holds the child's frame at the parent's."""
    kind = KINDS.get(constraint.type.lower())
    owner = f"constraint {shown(constraint.name)}"
    if kind is None:
        what = f"{owner} has the type {shown(constraint.type)}, which is no loop here"
        remedy = f"types: {', '.join(KINDS)}; or give the scene a [[loop]] of this name"
        raise DescriptionError(what, remedy=remedy, file=file, line=constraint.line)
    if constraint.parent == constraint.child:
        what = f"{owner} ties link {shown(constraint.child)} to itself"
        raise DescriptionError(what, remedy="name two links", file=file, line=constraint.line)
    B, B_to = (rotation_from_rpy(*each.rpy) for each in (constraint.child_origin, constraint.parent_origin))
    axes: dict[str, Any] = {}
    if kind == "hinge":
        for role, written in (("child_axis", constraint.child_axis), ("parent_axis", constraint.parent_axis)):
            if not any(written):
                what = f"<{role}> of {owner} has the length 0, which gives no direction"
                raise DescriptionError(what, remedy='write xyz="0 0 1"', file=file, line=constraint.line)
        axes = {"axis": _turned(B, constraint.child_axis), "to_axis": _turned(B_to, constraint.parent_axis)}
    if kind == "weld":
        axes = {"rpy": _rpy(product(B_to, B.T))}
    ends = constraint.child, constraint.child_origin.xyz, constraint.parent, constraint.parent_origin.xyz
    return Loop(constraint.name, *ends, kind, **axes)


def _turned(R: Floats, axis: Vector) -> Vector:
    x, y, z = product(R, np.array(axis)).tolist()
    return x, y, z


def _rpy(R: Floats) -> Vector:
    """Return roll, pitch and yaw of a rotation; where the pitch is a right angle, one of many.

    Method: the yaw first, whatever it is, and the others of what is left when it is undone.

    Accuracy: `rotation_from_rpy` gives the rotation back within 8 eps.
    """
    yaw = atan2(R[1, 0], R[0, 0])
    left = product(rotation_from_rpy(0.0, 0.0, -yaw), R)
    return atan2(-left[1, 2], left[1, 1]), atan2(-left[2, 0], left[0, 0]), yaw


def constraint_count(description: Description) -> int:
    """Return how many there are, whatever they say."""
    return len(_elements(description))


def read_constraints(description: Description) -> tuple[Constraint, ...]:
    """Return the constraints in the order of the file.

    Source: the proposal to urdfdom_headers, pull request 108: elements of <robot> beside its joints.

    Raises:
        DescriptionError: a name is missing, twice there or refers to nothing; a number is none; with the line.
    """
    strict = Strict(description.file)
    links = [link.name for link in description.links]
    found = (_constraint(element, links, strict) for element in _elements(description))
    return tuple(by_name(found, TAG, strict).values())


def _elements(description: Description) -> list[Element]:
    if b"<" + TAG.encode() not in description.data:
        return []
    return read_document(description.data, description.file).root.findall(TAG)


def _constraint(element: Element, links: list[str], strict: Strict) -> Constraint:
    name = strict.text(element, "name", f"<{TAG}>")
    owner = f"{TAG} {shown(name)}"
    ends = {}
    for role in ("parent", "child"):
        link = strict.text(strict.needed_child(element, role, owner), "link", owner)
        if link not in links:
            what = f"the {role} of {owner} is link {shown(link)}, which does not exist"
            raise strict.error(element.line, what, alternatives(link, links, "links"))
        ends[role] = link
    return Constraint(
        name,
        strict.text(element, "type", owner),
        ends["parent"],
        _origin(element, "parent_origin", owner, strict),
        _vector(element, "parent_axis", "xyz", owner, strict, AXIS),
        ends["child"],
        _origin(element, "child_origin", owner, strict),
        _vector(element, "child_axis", "xyz", owner, strict, AXIS),
        element.line,
    )


def _origin(element: Element, tag: str, owner: str, strict: Strict) -> Origin:
    xyz, rpy = (_vector(element, tag, name, owner, strict, ZERO) for name in ("xyz", "rpy"))
    return Origin(xyz, rpy)


def _vector(element: Element, tag: str, name: str, owner: str, strict: Strict, default: Vector) -> Vector:
    part = strict.child(element, tag, owner)
    return default if part is None else strict.vector(numbers(part, name, 3), owner, *default)
