"""The loops that a description closes by itself, as a scene has them."""

from __future__ import annotations

from dataclasses import replace
from math import atan2
from typing import Any

import numpy as np

from robodyn.errors import DescriptionError
from robodyn.programs.vectors import product, rotation_from_rpy
from robodyn.robot.model import Model
from robodyn.robot.urdf.constraints import Constraint, read_constraints
from robodyn.robot.urdf.parts import Vector
from robodyn.scene.constraints import Loop
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import shown

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
