"""Where a motion begins: what the scene says, and within the joints' limits where it says nothing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from robodyn.errors import InputError
from robodyn.programs.vectors import length
from robodyn.robot.kinematics import Values, coordinates, named
from robodyn.robot.limits import coordinate_ranges
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats

ROOM = 0.05
"""Of a joint's range, and rad or m at most: what is left to a limit where 0 is none of the positions between limits."""
_NAMED = 8


def default_pose(model: Model) -> Floats:
    """Return q (nq,) where a scene says nothing: 0 and no turn, or of joints that may not stand at 0 the nearest
    position within their limits, ROOM away from them, so that gravity does not end the motion where it begins."""
    q = np.zeros(model.nq)
    for joint in model.independent:
        if joint.kind == "floating":
            q[joint.coordinate + 6] = 1.0
    least, largest = coordinate_ranges(model)
    stuck = ((least >= 0.0) | (largest <= 0.0)) & (least <= largest)
    room = np.minimum(ROOM * (largest - least), ROOM)
    return np.where(stuck, np.where(least >= 0.0, least + room, largest - room), q)


def initial_state(model: Model, scene: Scene) -> Floats:
    """Return (width,) q, qd, no work done, and no step yet: what the scene says in numbers, else the default pose."""
    q = dict(zip(model.coordinates, default_pose(model).tolist(), strict=True))
    qd = dict.fromkeys(model.rates, 0.0)
    for values, begun in ((q, scene.initial_q), (qd, scene.initial_qd)):
        for name, entry in begun.items():
            assert not isinstance(entry, str), "a scene of a Signal has its initial state in numbers"
            values[name] = entry
    state = np.array([*q.values(), *qd.values(), 0.0, 0.0])
    for joint in model.independent:
        if joint.kind == "floating":
            h = state[joint.coordinate + 3 : joint.coordinate + 7]
            if not h.any():
                raise InputError(f"the quaternion of {joint.name} is zero", remedy="no turn is qx qy qz qw = 0 0 0 1")
            h /= length(h)
    return state


def begun_at(model: Model, scene: Scene, values: Values) -> Scene:
    """Return the scene with initial positions of the joints in their order, or of coordinates by name."""
    given = named(model, values, model.coordinates if isinstance(values, Mapping) else coordinates(model))
    return replace(scene, initial_q={**scene.initial_q, **given}) if given else scene


def limits_at_start(model: Model, scene: Scene) -> list[str]:
    """Return lines on the joints that begin elsewhere than at 0 for their limits' sake, and on those without room."""
    pose, (least, largest) = default_pose(model), coordinate_ranges(model)
    joints = [joint for joint in model.independent if joint.kind != "floating"]
    moved = [
        f'"{joint.name}" at {pose[joint.coordinate]:.4g} {"m" if joint.kind == "prismatic" else "rad"}'
        for joint in joints
        if pose[joint.coordinate] and joint.name not in scene.initial_q
    ]
    stuck = [f'"{joint.name}"' for joint in joints if largest[joint.coordinate] <= least[joint.coordinate]]
    lines = [f"begun within the limits and not at 0: {_first(moved)}"] if moved and not scene.loops else []
    if stuck and scene.joint_limits == "stop":
        why = "limits, those of joints that mimic it among them, leave no room"
        lines.append(f'{_first(stuck)} cannot move: {why} (joint_limits = "ignore" in a scene does not look)')
    return lines


def _first(names: list[str]) -> str:
    return ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")
