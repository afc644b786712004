"""What a motion must keep to: limits of joints, and what is assumed where a description has none."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.effects.friction import friction_of
from robodyn.errors import InputError
from robodyn.robot.limits import MOST_EFFORT, MOST_VELOCITY, binding, coordinate_ranges
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives, count

MARGIN = 0.05
"""Of a joint's range that the motion keeps from each limit of position."""
SPEEDING = 0.25
"""In so many seconds a joint may reach its limit of speed, where no limit of acceleration is given [s]."""
_FAR, _NEAR = 1e4, 1e-6
"""Limits of position from which on they stand for "none", and room or speed that is none [rad, m, rad/s, m/s]."""
_RANGE = {"revolute": pi, "prismatic": 0.25}
"""To each side of 0 [rad, m] where there is no limit."""
_SPEED = {"revolute": pi, "prismatic": 0.5}
"""Where there is no limit [rad/s, m/s]."""

_UNIT = {"revolute": "rad", "prismatic": "m"}

Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Bounds:
    """Of each entry of q (n,), for a robot whose joints have one each.

    Attributes:
        middle, half: positions are within `middle +- half`, the margin taken off.
        speed, acceleration, effort: largest magnitudes; inf where there is none.
        moving: which joints move; the others are held at `home`.
        notes: what was assumed, a line each.
    """

    middle: Floats
    half: Floats
    speed: Floats
    acceleration: Floats
    effort: Floats
    moving: tuple[int, ...]
    home: Floats
    notes: tuple[str, ...]


def bounds_of(model: Model, scene: Scene, joints: tuple[str, ...] = (), acceleration: float | None = None) -> Bounds:
    """Return what motions of these joints, of all if none is named, must keep to.

    Args:
        acceleration: largest, of every joint [rad/s^2, m/s^2]; None: speed limit over `SPEEDING`.

    Raises:
        InputError: the base floats, there is no such joint, or none that can move.
    """
    if model.quaternions:
        what = f'"{model.quaternions[0][0]}" floats: nothing drives it along a motion'
        raise InputError(what, remedy="fix it", file=model.file)
    _known(model, joints)
    notes: list[str] = []
    least, largest = _ranges(model, notes)
    speed, half = _speeds(model, notes), (0.5 - MARGIN) * (largest - least)
    effort = np.array([binding(joint.effort) or np.inf for joint in model.independent])
    effort[effort >= MOST_EFFORT] = np.inf
    _say(notes, model, effort == np.inf, "no effort limit: any torque is allowed")
    wanted = np.array([not joints or joint.name in joints for joint in model.independent], dtype=bool)
    narrow = wanted & (np.minimum(half, speed) < _NEAR)
    weak = wanted & (np.array([friction_of(joint, scene).dry for joint in model.independent]) >= effort)
    _say(notes, model, narrow, "held: its limits leave no room")
    _say(notes, model, weak, "held: friction alone takes its effort limit")
    moving = tuple(np.flatnonzero(wanted & ~narrow & ~weak).tolist())
    if not moving:
        raise InputError("no joint can move", remedy="; ".join(notes) or "none is described", file=model.file)
    middle = 0.5 * (least + largest)
    home = np.where((least <= 0.0) & (largest >= 0.0), 0.0, middle)
    most = speed / SPEEDING if acceleration is None else np.full(model.n, acceleration)
    return Bounds(middle, half, speed, most, effort, moving, home, tuple(notes))


def _known(model: Model, joints: tuple[str, ...]) -> None:
    for name in joints:
        if name not in model.joint_names:
            remedy = alternatives(name, model.joint_names, "joints that have a coordinate")
            raise InputError(f"there is no joint {name!r} to move", remedy=remedy)


def _ranges(model: Model, notes: list[str]) -> tuple[Floats, Floats]:
    least, largest = (np.where(np.abs(end) < _FAR, end, np.nan) for end in coordinate_ranges(model))
    endless = np.isnan(least) | np.isnan(largest)
    for kind, width in _RANGE.items():
        what = f"no position limits: {width:.4g} {_UNIT[kind]} to each side"
        _say(notes, model, endless & _are(model, kind), what)
    most = np.array([_RANGE[joint.kind] for joint in model.independent])
    least = np.where(np.isfinite(least), least, np.where(np.isfinite(largest), largest - 2.0 * most, -most))
    return least, np.where(np.isfinite(largest), largest, least + 2.0 * most)


def _speeds(model: Model, notes: list[str]) -> Floats:
    """Return the largest speed of each coordinate that all joints which it moves allow."""
    speeds = np.full(model.n, np.inf)
    for body in model.bodies:
        joint, limit = body.joint, binding(body.joint.velocity)
        if limit is not None and limit < MOST_VELOCITY and joint.kind != "fixed" and joint.multiplier:
            speeds[joint.rate] = min(speeds[joint.rate], limit / abs(joint.multiplier))
    for kind, speed in _SPEED.items():
        these = np.isinf(speeds) & _are(model, kind)
        _say(notes, model, these, f"no speed limit: {speed:.4g} {_UNIT[kind]}/s assumed")
        speeds[these] = speed
    return speeds


def _are(model: Model, kind: str) -> Flags:
    return np.array([joint.kind == kind for joint in model.independent], dtype=bool)


def _say(notes: list[str], model: Model, these: Flags, what: str) -> None:
    names = [joint.name for joint, each in zip(model.independent, these, strict=True) if each]
    if names:
        notes.append(f"{count(len(names), 'joint')} ({', '.join(names)}): {what}")
