"""What a robot stands on: whether a base seems bolted down, or carried by legs, wheels or rotors."""

from __future__ import annotations

import re
from collections.abc import Sequence

from robodyn.programs.vectors import length
from robodyn.robot.kinematics import configuration, link_poses
from robodyn.robot.model import Model
from robodyn.support.wording import shown

GROUNDS = frozenset({"world", "ground", "earth", "floor", "wall", "ceiling", "table"})
"""Names of a root link by which a description says that what is fixed to it does not move."""
FEET = frozenset({"foot", "feet", "toe", "sole", "ankle", "hoof", "paw"})
LEGS = FEET | frozenset({"leg", "lowerleg", "upperleg", "knee", "calf", "shank", "shin", "tibia", "thigh"})
WHEELS = frozenset({"wheel", "wheels", "caster", "casters"})
ROTORS = frozenset({"rotor", "propeller", "prop", "thruster"})
FLIERS = frozenset({"quadrotor", "quadcopter", "hexarotor", "multirotor", "drone", "uav", "flying"})
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_NAMES = 4


def untouched(model: Model) -> str:
    """Return what makes one think that a base is not bolted down, and does not touch anything; empty if nothing does.

    Legs are two or more branches of two or more joints that end below all of the base (z up), or that have links called
    foot, shank and the like. The names of wheels, casters, rotors and flying machines count. A root called world or
    ground is bolted down.
    """
    root = _words(model.bodies[0].name)
    if root & GROUNDS and root <= GROUNDS | {"link", "frame"}:
        return ""
    if not model.n:
        return "no joint moves"
    legs = _legs(model)
    if len(legs) > 1:
        return f"there is no contact at its feet ({_some(legs)})"
    wheels = [name for name in model.links if _words(name) & WHEELS]
    if len(wheels) > 1:
        return f"there is no contact at its wheels ({_some(wheels)})"
    near = [name for name, frame in model.links.items() if model.bodies[frame.body].parent < 1]
    rotors = [name for name in near if _words(name) & ROTORS]
    if len(rotors) > 2:
        return f"there is no thrust at its rotors ({_some(rotors)})"
    flies = [name for name in (model.name, *model.links) if _words(name) & FLIERS]
    return f"there is no thrust, and by its names it flies ({_some(flies)})" if flies else ""


def _words(name: str) -> frozenset[str]:
    return frozenset(word.lower() for word in _WORDS.findall(name))


def _some(names: Sequence[str]) -> str:
    more = f" and {len(names) - _NAMES} more" if len(names) > _NAMES else ""
    return ", ".join(shown(name) for name in names[:_NAMES]) + more


def _legs(model: Model) -> list[str]:
    """Return the links at which legs end, the branches of the base, by where they are or else by their names."""
    base = model.bodies[0].inertia
    own = [frame.p[2] for name, frame in model.links.items() if frame.body == 0 and "footprint" not in _words(name)]
    bottom = float(min(base.mc[2] / base.m, *own, 0.0) if base.m > 0.0 else min(own, default=0.0))
    first, depth, reach = [0], [0], [0.0]
    for i, body in enumerate(model.bodies[1:], 1):
        first.append(first[body.parent] or i)
        depth.append(depth[body.parent] + (body.joint.mimics is None))
        reach.append(reach[body.parent] + (length(body.joint.p) if body.parent else 0.0))
    places = {name: pose.p for name, pose in link_poses(model, configuration(model)).items()}
    below: list[tuple[str, float, float]] = []
    named: list[str] = []
    for hip in dict.fromkeys(first[1:]):
        links = [name for name, frame in model.links.items() if first[frame.body] == hip]
        if ends := [name for name in links if depth[model.links[name].body] > 1]:
            foot = min(ends, key=lambda name: places[name][2])
            end, height = model.links[foot], float(places[foot][2])
            long, drop = reach[end.body] + length(end.p), float(model.bodies[hip].joint.p[2]) - height
            if drop > 0.5 * long and bottom - height > 0.25 * long:
                below.append((foot, height, long))
            named += [name for name in links if _words(name) & LEGS][-1:]
    lowest = min((height for _, height, _ in below), default=0.0)
    level = [foot for foot, height, long in below if height < lowest + 0.2 * long]
    return level if len(level) > 1 and base.m > 0.0 else named
