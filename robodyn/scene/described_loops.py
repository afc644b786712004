"""The loops that a description closes by itself: its <constraint> elements, as a scene has them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from math import atan2
from typing import Any

import numpy as np

from robodyn.programs.vectors import product, rotation_from_rpy
from robodyn.robot.model import Model
from robodyn.robot.urdf.description import Strict
from robodyn.robot.urdf.document import read_document
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import numbers
from robodyn.robot.urdf.parts import ZERO, Description, Vector
from robodyn.scene.parts import Loop
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives, shown

TAG = "constraint"
AXIS: Vector = (1.0, 0.0, 0.0)
"""What is taken where there is none, as for a joint."""
KINDS = {"fixed": "weld", "revolute": "hinge", "continuous": "hinge", "spherical": "point", "ball": "point"}
"""Loops by the type of a constraint."""


def scene_of(model: Model, scene: Scene = DEFAULT) -> Scene:
    """Return the scene with the loops that the <constraint> elements of the robot's description close.

    Commands do so by themselves. A loop of the scene takes the place of the constraint that has its name.

    Source: the proposal to urdfdom_headers, pull request 108: elements of <robot> beside its joints.

    Raises:
        DescriptionError: a constraint is wrong, or of a type that is no loop here, and the scene does not replace it.
    """
    own, strict = {loop.name for loop in scene.loops}, Strict(model.file)
    lines: dict[str, int] = {}
    loops = []
    for element in [] if model.description is None else _elements(model.description):
        name = strict.text(element, "name", f"<{TAG}>")
        if name in own:
            continue
        if name in lines:
            what = f"a second {TAG} {shown(name)}, the first is in line {lines[name]}"
            raise strict.error(element.line, what, "rename one of them")
        lines[name] = element.line
        loops.append(_loop(element, name, model.links, strict))
    return replace(scene, loops=(*loops, *scene.loops)) if loops else scene


def _loop(element: Element, name: str, links: Collection[str], strict: Strict) -> Loop:
    owner = f"{TAG} {shown(name)}"
    ends = []
    for role in ("parent", "child"):
        link = strict.text(strict.needed_child(element, role, owner), "link", owner)
        if link not in links:
            what = f"the {role} of {owner} is link {shown(link)}, which does not exist"
            raise strict.error(element.line, what, alternatives(link, links, "links"))
        ends.append(link)
    parent, child = ends
    if parent == child:
        raise strict.error(element.line, f"{owner} ties link {shown(child)} to itself", "name two links")
    kind = KINDS.get(written := strict.text(element, "type", owner).lower())
    if kind is None:
        what = f"{owner} has the type {shown(written)}, which is no loop here"
        remedy = f"types: {', '.join(KINDS)}; or give the scene a [[loop]] of this name"
        raise strict.error(element.line, what, remedy)
    points, turns, axes = [], [], []
    for role in ("parent", "child"):
        points.append(_vector(element, f"{role}_origin", "xyz", owner, strict, ZERO))
        turns.append(rotation_from_rpy(*_vector(element, f"{role}_origin", "rpy", owner, strict, ZERO)))
        axis = _vector(element, f"{role}_axis", "xyz", owner, strict, AXIS)
        if kind == "hinge" and not any(axis):
            what = f"<{role}_axis> of {owner} has the length 0, which gives no direction"
            raise strict.error(element.line, what, 'write xyz="0 0 1"')
        x, y, z = product(turns[-1], np.array(axis)).tolist()
        axes.append((x, y, z))
    more: dict[str, Any] = {"axis": axes[1], "to_axis": axes[0]} if kind == "hinge" else {}
    if kind == "weld":
        more = {"rpy": _rpy(product(turns[0], turns[1].T))}
    return Loop(name, child, points[1], parent, points[0], kind, **more)


def _rpy(R: Floats) -> Vector:
    """Return roll, pitch and yaw of a rotation; where the pitch is a right angle, one of many.

    Method: the yaw first, whatever it is, and the others of what is left when it is undone.

    Accuracy: `rotation_from_rpy` gives the rotation back within 8 eps.
    """
    yaw = atan2(R[1, 0], R[0, 0])
    left = product(rotation_from_rpy(0.0, 0.0, -yaw), R)
    return atan2(-left[1, 2], left[1, 1]), atan2(-left[2, 0], left[0, 0]), yaw


def constraint_count(description: Description) -> int:
    """Return how many <constraint> elements there are, whatever they say."""
    return len(_elements(description))


def _elements(description: Description) -> list[Element]:
    if b"<" + TAG.encode() not in description.data:
        return []
    return read_document(description.data, description.file).root.findall(TAG)


def _vector(element: Element, tag: str, name: str, owner: str, strict: Strict, default: Vector) -> Vector:
    part = strict.child(element, tag, owner)
    return default if part is None else strict.vector(numbers(part, name, 3), owner, *default)
